"""A study file: which scenes are planned, and under which settings.

Every scene is planned with every combination of the settings that ``vary`` lists.
"""

from __future__ import annotations

import hashlib
import itertools
import math
import os.path
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from abi.errors import AbiError, SceneError
from abi.obstacles.triangle_mesh.surface import Surface
from abi.robot.urdf.robot import Robot
from abi.scene.scene import Scene, load_scene, scene_names
from abi.scene.scene_file import parse
from abi_sweep.random_boxes import random_boxes

MOST_PLANS = 200_000
"""Largest number of plans of a study."""
_FIELDS = ("version", "scenes", "vary")
_RANDOM_FIELDS = {"boxes": (1, 200, None), "seeds": (1, MOST_PLANS, 1), "first": (0, 2**31, 0)}
"""Least and greatest value of each field of a random scene, and its default."""
_FIXED = ("version", "unit", "workspace", "obstacles")
"""Fields of a scene that no study varies."""


@dataclass(frozen=True)
class Study:
    """Scenes and settings.

    Attributes:
        scenes: name and seed of each; without a seed it is a shipped scene's or a file's name.
        vary: values of each field of a scene, by its name in a scene file: ``mesh.pitch``.
        folder: folder that the names of files are relative to.
    """

    scenes: tuple[tuple[str, int | None], ...]
    vary: Mapping[str, tuple[Any, ...]]
    folder: Path = Path()

    @classmethod
    def from_dict(cls, data: object, folder: Path | None = None) -> Study:
        """Check ``data`` (as a study file holds it) and build the study.

        Raises:
            SceneError: names the first field that is wrong.
        """
        fields = _mapping("study", data, _FIELDS)
        version = fields.get("version")
        if type(version) is not int or version != 1:
            raise SceneError("version", version, "version: 1")
        listed = fields.get("scenes")
        if not isinstance(listed, list | tuple) or not listed:
            raise SceneError("scenes", listed, "a list with at least one scene")
        folder = folder or Path()
        scenes = itertools.chain.from_iterable(
            _scenes(f"scenes[{k}]", one, folder) for k, one in enumerate(listed)
        )
        study = cls(tuple(scenes), _vary(fields.get("vary", {})), folder)
        if study.size > MOST_PLANS:
            raise SceneError("vary", f"{study.size:,} plans", f"at most {MOST_PLANS:,}")
        return study

    @property
    def size(self) -> int:
        """Number of plans."""
        return len(self.scenes) * math.prod(len(values) for values in self.vary.values())

    @property
    def axes(self) -> tuple[str, ...]:
        """Fields with more than one value, in the order of the study."""
        return tuple(name for name, values in self.vary.items() if len(values) > 1)

    def settings(self) -> list[dict[str, Any]]:
        """Every combination of what varies: the value of each field, by its name."""
        combinations = itertools.product(*self.vary.values())
        return [dict(zip(self.vary, values, strict=True)) for values in combinations]

    def scene(self, name: str, seed: int | None) -> Scene:
        """A scene of the study before anything is varied.

        Raises:
            AbiError: it cannot be read; names the scene and the field.
        """
        if seed is not None:
            return random_boxes(seed, int(name.split()[0]))
        beside = self.folder / name
        try:
            return load_scene(beside if beside.is_file() else name)
        except SceneError as error:
            raise AbiError(f"The scene {name} cannot be planned: {error.message}") from None


def load_study(path: Path) -> Study:
    """Load a study file, YAML or JSON by its ending.

    Raises:
        SceneError: it is not readable, or a field is wrong.
    """
    try:
        data = parse(path)
    except SceneError as error:
        raise SceneError("study", error.value, error.expected) from None
    return Study.from_dict(data, path.parent)


def varied(scene: Scene, settings: Mapping[str, Any]) -> Scene:
    """The scene with other values of fields, named as in ``vary``.

    Raises:
        SceneError: a field is wrong.
    """
    changes: dict[str, Any] = {}
    for field, value in settings.items():
        section, _, name = field.partition(".")
        if name:
            changes.setdefault(section, {})[name] = value
        else:
            changes[section] = value
    return scene.replace(**changes)


def plan_key(scene: Scene) -> str:
    """Digest of everything that a plan depends on: the scene and the files it names."""
    digest = hashlib.sha256(scene.model_dump_json().encode())
    for name, content in sorted(scene.meshes.files.items()):
        digest.update(name.encode())
        assert isinstance(content, Surface | Robot)  # as they were read
        digest.update(content.digest.encode())
    return digest.hexdigest()[:16]


def _scenes(field: str, data: object, folder: Path) -> list[tuple[str, int | None]]:
    """Names and seeds of one entry: a scene's name, or random scenes."""
    if isinstance(data, str):
        shipped = scene_names()
        if data not in shipped and not any(os.path.isfile(one) for one in (folder / data, data)):
            raise SceneError(field, data, f"a scene's file, or one of {', '.join(shipped)}")
        return [(data, None)]
    if not isinstance(data, dict):
        raise SceneError(field, data, "a scene's name, a file, or boxes: 8 with seeds: 100")
    numbers = _mapping(field, data, tuple(_RANDOM_FIELDS))
    found = {}
    for name, (low, high, default) in _RANDOM_FIELDS.items():
        value = numbers.get(name, default)
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            raise SceneError(f"{field}.{name}", value, f"a whole number from {low} to {high:,}")
        found[name] = value
    title = f"{found['boxes']} boxes"
    return [(title, found["first"] + number) for number in range(found["seeds"])]


def _vary(data: object) -> dict[str, tuple[Any, ...]]:
    if not isinstance(data, dict):
        raise SceneError("vary", data, "fields of a scene with lists, as mesh.pitch: [1.2, 0.8]")
    for name, values in data.items():
        field = f"vary.{name}"
        if str(name).partition(".")[0] in _FIXED:
            raise SceneError(field, values, "another field: this one makes it another scene")
        if not isinstance(values, list | tuple) or not values:
            raise SceneError(field, values, "a list with at least one value")
    return {str(name): tuple(values) for name, values in data.items()}


def _mapping(field: str, data: object, known: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(data, dict):
        raise SceneError(field, data, f"a mapping with the fields {', '.join(known)}")
    for name in data:
        if name not in known:
            inner = name if field == "study" else f"{field}.{name}"
            raise SceneError(str(inner), data[name], f"one of the fields {', '.join(known)}")
    return data

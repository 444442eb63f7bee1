"""State of a tab as text, from which a reload, another server or a link restores it."""

from __future__ import annotations

import base64
import functools
import json
import math
import zlib
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Any

import msgspec

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.remembered_call import RememberedCall
from abi.scene.scene import Scene
from abi.scene.scene_file import MAX_JSON_BYTES
from abi.scene.without_obstacles import contacts_without, legs_without
from app.camera.view import View
from app.shared import mesh_store
from app.state.known_legs import KnownLeg, as_data, legs_of

LONGEST_LINK = 6000
"""Most characters of a state that servers and browsers accept in an address."""
MAX_PROGRESS = 10_000
"""Most characters of the progress in lessons."""
_VERSION = 1
_ZLIB_HEADER = b"\x78\x9c"
_FIELD = "link"
_NO_VIEW = (
    "Its camera stands where nothing can be seen, so the scene is shown as when it is opened by "
    "its name."
)


@dataclass(frozen=True)
class TabState:
    """State of a tab.

    Attributes:
        name: of the scene that was loaded, as in the list of scenes.
        scene: as it was changed since.
        view: the camera; None for the scene's own.
        time: of the motion, [s].
        playing: whether it advances by itself.
        shown: names of the switches that are on; None for those of a new tab.
        dark: whether the page is dark; None for as the system has it.
        challenge: what is to be reached, as JSON; empty for nothing.
        lessons: where the student is in which lesson, as the player writes it; empty for nowhere.
        practice: what is practised, as its panel writes it; empty for nothing.
        theatre: the search that is stepped through, as its panel writes it; empty for none.
        missing: names of mesh files that this server has not; the scene is without them.
        faults: sentences on what else is left out, because it is damaged.
        before: the state to which the end of a lesson or of the paper's figures leads; itself
            without one. No link has it.
        figure: number of the paper's figure that is shown since; 0 for none.
        tasks: the legs before the scene, where that is one of a sequence.
    """

    name: str
    scene: Scene
    view: View | None = None
    time: float = 0.0
    playing: bool = True
    shown: frozenset[str] | None = None
    dark: bool | None = None
    lessons: str = ""
    challenge: str = ""
    theatre: str = ""
    practice: str = ""
    missing: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()
    before: TabState | None = None
    figure: int = 0
    tasks: tuple[KnownLeg, ...] = ()

    def alone(self) -> TabState:
        """The state without the previous one, as others are shown it."""
        return replace(self, before=None, figure=0)

    def encode(self) -> str:
        """Encode the state in URL-safe characters."""
        return _encode(_scene_part, _tasks_part, _before_part, self)

    def settings(self) -> dict[str, Any]:
        """Everything but the scene and the previous state, as plain data."""
        return {
            "version": _VERSION,
            "name": self.name,
            "view": None if self.view is None else self.view.to_list(),
            "time": round(self.time, 3),
            "playing": self.playing,
            "shown": None if self.shown is None else sorted(self.shown),
            "dark": self.dark,
            "lessons": self.lessons,
            "challenge": self.challenge,
            "theatre": self.theatre,
            **({"practice": self.practice} if self.practice else {}),
            **({"figure": self.figure} if self.figure else {}),
        }

    @classmethod
    def decode(cls, text: str, meshes: MeshSource) -> TabState:
        """Decode a state from untrusted text.

        Args:
            text: by :meth:`encode`.
            meshes: the mesh files that its scene may name.

        Raises:
            SceneError: no such text, or a field of its scene is wrong.
        """
        data = _unpack(text)
        if not isinstance(data, dict) or data.get("version") != _VERSION:
            raise SceneError(_FIELD, _shortened(text), "one that this version has made")
        state, before = _state(data, meshes), _before(data.get("before"), meshes)
        state = replace(state, tasks=_tasks(data.get("tasks"), meshes))
        return state if before is None else replace(state, before=before, figure=_figure(data))


def encoder() -> Callable[[TabState], str]:
    """A function that encodes a tab's states as :meth:`TabState.encode` does, each after another.

    It compresses a scene once as long as that stays: one of thousands of obstacles takes tens of
    milliseconds, and the camera moves more often than the scene changes.
    """
    return functools.partial(
        _encode,
        RememberedCall(_scene_part),
        RememberedCall(_tasks_part),
        RememberedCall(_before_part),
    )


def _encode(
    scene_part: Callable[[Scene], tuple[bytes, bytes]],
    tasks_part: Callable[[tuple[KnownLeg, ...]], tuple[bytes, bytes]],
    before_part: Callable[[TabState | None], tuple[bytes, bytes]],
    state: TabState,
) -> str:
    """Encode a state with functions that give its parts, each as text and compressed."""
    settings = json.dumps(state.settings(), separators=(",", ":")).encode()
    settings = b"," + settings.removeprefix(b"{")
    parts = [scene_part(state.scene), tasks_part(state.tasks), before_part(state.before)]
    while len(parts) > 1 and sum(len(text) for text, _ in parts) + len(settings) > MAX_JSON_BYTES:
        parts.pop()  # what is shown now comes back rather than nothing
    # a zlib stream (RFC 1950) in stretches, none of which looks back into another
    checksum = zlib.adler32(b"")
    for text, _ in parts:
        checksum = zlib.adler32(text, checksum)
    checksum = zlib.adler32(settings, checksum)
    packed = b"".join(packed for _, packed in parts)
    stream = _ZLIB_HEADER + packed + _deflate(settings, zlib.Z_FINISH) + checksum.to_bytes(4)
    return base64.urlsafe_b64encode(stream).decode().rstrip("=")


def _fields_of(scene: Scene) -> str:
    files = json.dumps(mesh_store.keys(scene.meshes.files))
    return f'"scene":{scene.model_dump_json()},"files":{files}'


def _scene_part(scene: Scene) -> tuple[bytes, bytes]:
    """The begin of a JSON object, and the same compressed: a scene and its files."""
    return _part("{" + _fields_of(scene))


def _before_part(before: TabState | None) -> tuple[bytes, bytes]:
    """The previous state as a field of the object, and compressed; empty without one."""
    if before is None:
        return b"", b""
    settings = json.dumps(before.settings(), separators=(",", ":")).removeprefix("{")
    return _part(f',"before":{{{_fields_of(before.scene)},{settings}')


def _tasks_part(legs: tuple[KnownLeg, ...]) -> tuple[bytes, bytes]:
    """The sequence of tasks as a field of the object, and compressed; empty without one."""
    if not legs:
        return b"", b""
    return _part(f',"tasks":{{{_fields_of(legs[0].scene)},"legs":{json.dumps(as_data(legs))}}}')


def _part(text: str) -> tuple[bytes, bytes]:
    """A part of a text, and the same compressed so that it needs no part before."""
    content = text.encode()
    return content, _deflate(content, zlib.Z_FULL_FLUSH)


def _deflate(data: bytes, end: int) -> bytes:
    """Chunk of a deflate stream, which continues after it unless ``end`` is ``Z_FINISH``."""
    packer = zlib.compressobj(wbits=-zlib.MAX_WBITS)
    return packer.compress(data) + packer.flush(end)


def _state(data: dict[str, Any], meshes: MeshSource) -> TabState:
    """Parse a state from plain data, without the previous one."""
    dark, shown = data.get("dark"), data.get("shown")
    scene, missing = _scene(data.get("scene"), data.get("files"), meshes)
    view = View.of(data.get("view"))
    return TabState(
        name=str(data.get("name", ""))[:200],
        scene=scene,
        missing=missing,
        faults=() if view is not None or data.get("view") is None else (_NO_VIEW,),
        view=view,
        time=_time(data.get("time")),
        playing=data.get("playing") is not False,
        shown=frozenset(map(str, shown)) if isinstance(shown, list) else None,
        dark=dark if isinstance(dark, bool) else None,
        lessons=str(data.get("lessons", ""))[:MAX_PROGRESS],
        challenge=str(data.get("challenge", ""))[:MAX_PROGRESS],
        theatre=str(data.get("theatre", ""))[:MAX_PROGRESS],
        practice=str(data.get("practice", ""))[:MAX_PROGRESS],
    )


def _before(data: object, meshes: MeshSource) -> TabState | None:
    """Parse the previous state; None if it cannot be shown, whatever the present one is."""
    try:
        return _state(data, meshes) if isinstance(data, dict) else None
    except SceneError:
        return None


def _tasks(data: object, meshes: MeshSource) -> tuple[KnownLeg, ...]:
    """Parse a sequence of tasks; empty if it cannot be shown, whatever the present scene is."""
    if not isinstance(data, dict):
        return ()
    try:
        scene, missing = _scene(data.get("scene"), data.get("files"), meshes)
        return () if missing else legs_of(scene, data.get("legs"))
    except SceneError:
        return ()


def _figure(data: dict[str, Any]) -> int:
    number = data.get("figure")
    return number if type(number) is int and number >= 0 else 0


def _scene(data: object, keys: object, meshes: MeshSource) -> tuple[Scene, tuple[str, ...]]:
    """A scene with the files that are stored here, and the names of the missing ones."""
    wanted = keys if isinstance(keys, dict) else {}
    here = dict(meshes.files)
    missing = []
    for name, key in wanted.items():
        content = mesh_store.find(str(key))
        if content is not None:
            here[name] = content
        elif not _is_same(name, key, meshes):
            here.pop(name, None)
            missing.append(str(name))
    if missing and isinstance(data, dict) and isinstance(data.get("obstacles"), list):
        obstacles = data["obstacles"]
        gone = [
            number
            for number, one in enumerate(obstacles)
            if isinstance(one, dict) and one.get("file") in missing
        ]
        left = [one for number, one in enumerate(obstacles) if number not in gone]
        data = {
            **data,
            "obstacles": left,
            "arm": _arm_without(data.get("arm", {}), gone),
            "tasks": _tasks_without(data.get("tasks", []), gone),
        }
    if missing and isinstance(data, dict) and isinstance(arm := data.get("arm"), dict):
        held = arm.get("attached")
        if isinstance(held, dict) and held.get("file") in missing:
            tasks = _tasks_without(data.get("tasks", []), (), holds_it=True)
            data = {**data, "arm": {**arm, "attached": None}, "tasks": tasks}
    return Scene.from_dict(data, MeshSource(here, meshes.folder)), tuple(missing)


def _arm_without(arm: object, gone: Collection[int]) -> object:
    """An arm's section whose contacts refer to the remaining obstacles; unchanged if invalid."""
    if not isinstance(arm, dict) or not isinstance(arm.get("allowed"), list):
        return arm
    pairs = [one for one in arm["allowed"] if isinstance(one, list) and len(one) == 2]
    if any(type(one) not in (str, int) for pair in pairs for one in pair):
        return arm
    return {**arm, "allowed": contacts_without([(a, b) for a, b in pairs], gone)}


def _tasks_without(tasks: object, gone: Collection[int], holds_it: bool = False) -> object:
    """Legs that attach what they did, or nothing; unchanged if invalid."""
    if not isinstance(tasks, list) or not all(isinstance(leg, dict) for leg in tasks):
        return tasks
    return legs_without(tasks, gone, holds_it)


def _is_same(name: str, key: object, meshes: MeshSource) -> bool:
    """Check whether a source's file of a name is the one that was meant, and not just called so."""
    content = meshes.given(name)
    if isinstance(content, bytes | None) and not name.lower().endswith((".urdf", ".zip")):
        try:
            content = meshes.surface(name)
        except SceneError:
            return False
    return content is not None and mesh_store.keys({name: content})[name] == key


def _unpack(text: str) -> object:
    """Decompress an encoded text, up to the size of a scene file."""
    try:
        packed = base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))
        unpacked = zlib.decompressobj().decompress(packed, MAX_JSON_BYTES)
        return msgspec.json.decode(unpacked)
    except (msgspec.MsgspecError, ValueError, zlib.error, RecursionError):
        raise SceneError(_FIELD, _shortened(text), "a whole one: it is damaged") from None


def _time(value: object) -> float:
    usable = isinstance(value, int | float) and math.isfinite(value) and value >= 0
    return float(value) if usable else 0.0  # type: ignore[arg-type]


def _shortened(text: str) -> str:
    return text if len(text) <= 24 else f"{text[:10]}…{text[-10:]}"

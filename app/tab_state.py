"""State of a tab as a text: what a reload, another server or a link brings back."""

from __future__ import annotations

import base64
import json
import math
import zlib
from dataclasses import dataclass, replace
from typing import Any

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.scene.scene import Scene
from abi.scene.scene_file import MAX_JSON_BYTES
from app.camera import View

LONGEST_LINK = 6000
"""Characters of a state that servers and browsers still take as part of an address."""
MAX_PROGRESS = 10_000
"""Characters of the progress in lessons."""
_VERSION = 1
_FIELD = "link"


@dataclass(frozen=True)
class TabState:
    """What a tab shows.

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

    def with_challenge(self, challenge: str) -> TabState:
        """The state with a challenge, for a link to it."""
        return replace(self, challenge=challenge)

    def encode(self) -> str:
        """The state in letters that an address takes as they are."""
        data: dict[str, Any] = {
            "version": _VERSION,
            "name": self.name,
            "scene": self.scene.to_dict(),
            "view": None if self.view is None else self.view.to_list(),
            "time": round(self.time, 3),
            "playing": self.playing,
            "shown": None if self.shown is None else sorted(self.shown),
            "dark": self.dark,
            "lessons": self.lessons,
            "challenge": self.challenge,
        }
        packed = zlib.compress(json.dumps(data, separators=(",", ":")).encode(), 9)
        return base64.urlsafe_b64encode(packed).decode().rstrip("=")

    @classmethod
    def decode(cls, text: str, meshes: MeshSource) -> TabState:
        """The state of an encoded text, which may come from anyone.

        Args:
            text: by :meth:`encode`.
            meshes: the mesh files that its scene may name.

        Raises:
            SceneError: no such text, or a field of its scene is wrong.
        """
        data = _unpack(text)
        if not isinstance(data, dict) or data.get("version") != _VERSION:
            raise SceneError(_FIELD, _shortened(text), "one that this version has made")
        dark, shown = data.get("dark"), data.get("shown")
        return cls(
            name=str(data.get("name", ""))[:200],
            scene=Scene.from_dict(data.get("scene"), meshes),
            view=View.of(data.get("view")),
            time=_time(data.get("time")),
            playing=data.get("playing") is not False,
            shown=frozenset(map(str, shown)) if isinstance(shown, list) else None,
            dark=dark if isinstance(dark, bool) else None,
            lessons=str(data.get("lessons", ""))[:MAX_PROGRESS],
            challenge=str(data.get("challenge", ""))[:MAX_PROGRESS],
        )


def _unpack(text: str) -> object:
    """Plain data of an encoded text, of no more than a scene file may have."""
    try:
        packed = base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))
        unpacked = zlib.decompressobj().decompress(packed, MAX_JSON_BYTES)
        return json.loads(unpacked, parse_constant=_refuse_constant)
    except (ValueError, zlib.error, RecursionError):
        raise SceneError(_FIELD, _shortened(text), "a whole one: it is damaged") from None


def _refuse_constant(constant: str) -> object:
    raise ValueError(constant)


def _time(value: object) -> float:
    usable = isinstance(value, int | float) and math.isfinite(value) and value >= 0
    return float(value) if usable else 0.0  # type: ignore[arg-type]


def _shortened(text: str) -> str:
    return text if len(text) <= 24 else f"{text[:10]}…{text[-10:]}"

"""The verdict on one curve of a plan, or on its arm; and a plan that is soon checked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.scene.scene import load_scene
from abi.verify.verify import Verdict, verify

_KITCHEN = load_scene("kitchen-ur5e")
NEAR = _KITCHEN.replace(
    obstacles=_KITCHEN.obstacles[:2],
    goal=[0.8 * a + 0.2 * b for a, b in zip(_KITCHEN.start, _KITCHEN.goal, strict=True)],
    motion={"samples": 25},
)
"""A robot's first fifth of the way in a kitchen: exact numbers take a fifth of the time, too."""
_CHECKED = ("bspline", "quadratic", "arm")


def verdict_on(name: str, data: dict[str, Any], folder: Path | MeshSource | None = None) -> Verdict:
    """The verdict; the others' certificates, which take their time, are left out."""
    others = {one for one in _CHECKED if one != name and data.get(one)}
    alone = data | {one: data[one] | {"certificate": None} for one in others}
    return next(one for one in verify(alone, folder) if one.curve == name)

"""Directions that separate a capsule from one part of a mesh, reused for the parts next to it.

What decides most pairs is always inlined, because passing arrays costs reference counting.
"""

from __future__ import annotations

from typing import NamedTuple

from abi.arm_planning.world.collision_world_kernels import Obstacles
from abi.compilation.jitable import jitable
from abi.obstacles.primitive_kernels import axes_of, centre_of, core_of, in_body, support
from abi.obstacles.vector_kernels import Vec3, dot

_LATEST = 8


class Direction(NamedTuple):
    """A direction that separates a capsule from parts of a mesh near a pose.

    Attributes:
        way: unit vector towards the capsule, world.
        level: less the mesh's margin, the greatest product that such a part may have, [unit].
        mesh: number of the mesh.
    """

    way: Vec3
    level: float
    mesh: int


NO_DIRECTION = Direction((0.0, 0.0, 1.0), 0.0, -1)
"""Example for the compiler."""


@jitable(forceinline=True)
def is_separated(around: Obstacles, s: int, latest: list[Direction]) -> bool:
    """Check whether one of the latest directions keeps the part of a mesh in row s from a capsule.

    Near triangles have one in common with those beside and behind them.
    """
    separated: bool = around.meshes[s] >= 0 and len(latest) > 0 and _is_beyond(around, s, latest)
    return separated


@jitable(forceinline=True)
def _is_beyond(around: Obstacles, s: int, latest: list[Direction]) -> bool:
    """Check whether row s is beyond one of the directions."""
    mesh = around.meshes[s]
    axes, core = axes_of(around.primitives, s), core_of(around.primitives, s)
    centre, margin = centre_of(around.primitives, s), around.margins[s]
    for k in range(len(latest) - 1, -1, -1):
        known = latest[k]
        if known.mesh == mesh:
            reached = dot(known.way, centre) + support(core, in_body(axes, known.way))
            if reached < known.level - margin:
                return True
    return False


@jitable(forceinline=True)
def keep_direction(latest: list[Direction], way: Vec3, level: float, mesh: int) -> None:
    """Add a direction, see :class:`Direction`, to the latest, of which the oldest go."""
    if len(latest) == _LATEST:
        latest.pop(0)
    latest.append(Direction(way, level, mesh + 0))

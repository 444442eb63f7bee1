"""Tightening of a path on which both tool and arm stay clear.

For segments, tool and arm only answer yes or no; that takes most of the time. A path is a list of
points, [unit], world. ``clear(around, points)`` checks whether the segments between two or three
points are clear; with one that is not compiled, :func:`pull` runs as plain Python.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np

from abi.arm_planning.exclusion.paper_arm_segment_kernels import (
    NO_SEGMENTS,
    ArmSegments,
    Touched,
    arm_is_clear,
    new_touched,
)
from abi.arrays import FloatArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, compiled
from abi.obstacles.triangle_mesh.surface_tables_kernels import DescentWorkspace, new_room
from abi.obstacles.vector_kernels import Vec3, axpy, dot, sub, vec3_at
from abi.search.taut.tighten_kernels import length_of
from abi.search.taut.tighten_near_meshes_kernels import NO_SURROUNDINGS, PathObstacles, is_clear

_Segments = TypeVar("_Segments")
Clear = Callable[[_Segments, tuple[Vec3, ...]], bool]

_ROUNDS = 3
_STEPS = (0.8, 0.3, 0.08)
_SETTLED = 1e-3
_CUT = (0.45, 0.2)


class _Around(NamedTuple):
    """Surroundings of tool and arm.

    Attributes:
        tool: what the tool does.
        room: for its descents.
        arm: what the arm does.
        touched: what it touched last.
    """

    tool: PathObstacles
    room: DescentWorkspace
    arm: ArmSegments
    touched: Touched


@jitable
def _clear(around: _Around, points: tuple[Vec3, ...]) -> bool:
    """Check whether tool and arm are clear on the segments between points."""
    tool, room, arm, touched = around
    for k in range(len(points) - 1):
        a, b = points[k], points[k + 1]
        if not (is_clear(tool, 0, a, b, room) and arm_is_clear(arm, touched, a, b)):
            return False
    return True


@jitable
def _shortcuts(path: list[Vec3], around: _Segments, clear: Clear[_Segments]) -> list[Vec3]:
    """From each vertex straight to the farthest in sight, found by doubling, then halving."""
    kept, i, last = [path[0]], 0, len(path) - 1
    while i < last:
        near, step = i + 1, 2
        while i + step <= last and clear(around, (path[i], path[i + step])):
            near, step = i + step, 2 * step
        tried = i + step <= last
        far = min(i + step, last)
        while far > near + 1:
            middle = (near + far) // 2
            if clear(around, (path[i], path[middle])):
                near = middle
            else:
                far, tried = middle, True
        if near < far and not tried and clear(around, (path[i], path[last])):
            near = last
        i = near
        kept.append(path[i])
    return kept


@jitable
def _moved(path: list[Vec3], around: _Segments, clear: Clear[_Segments]) -> list[Vec3]:
    """Vertices dropped, or moved towards the chord of their neighbours."""
    kept = [path[0]]
    for k in range(1, len(path) - 1):
        a, vertex, b = kept[-1], path[k], path[k + 1]
        if clear(around, (a, b)):
            continue
        chord = sub(b, a)
        share = dot(sub(vertex, a), chord) / max(dot(chord, chord), 1e-300)
        pull = sub(axpy(min(max(share, 0.0), 1.0), chord, a), vertex)
        found = vertex
        for step in _STEPS:
            at = axpy(step, pull, vertex)
            if clear(around, (a, at, b)):
                found = at
                break
        kept.append(found)
    kept.append(path[-1])
    return kept


@jitable
def _cut_corners(path: list[Vec3], around: _Segments, clear: Clear[_Segments]) -> list[Vec3]:
    """Bends cut where that is clear."""
    kept = [path[0]]
    for k in range(1, len(path) - 1):
        vertex = path[k]
        back, ahead = sub(path[k - 1], vertex), sub(path[k + 1], vertex)
        cut = False
        for share in _CUT:
            first, last = axpy(share, back, vertex), axpy(share, ahead, vertex)
            if clear(around, (first, last)):
                kept.append(first)
                kept.append(last)
                cut = True
                break
        if not cut:
            kept.append(vertex)
    kept.append(path[-1])
    return kept


@jitable
def pull(path: list[Vec3], around: _Segments, clear: Clear[_Segments]) -> list[Vec3]:
    """Drop the vertices that a path can do without, move others, and cut corners.

    Args:
        path: the path, all of it clear.
        around: passed to ``clear``.
        clear: whether the segments between points are.

    Returns:
        The path, never longer.
    """
    path = _shortcuts(path, around, clear)
    for _ in range(_ROUNDS):
        before = length_of(path)
        path = _cut_corners(_moved(path, around, clear), around, clear)
        if length_of(path) > (1 - _SETTLED) * before:
            break
    return path


@compiled(example=(FLOATS, NO_SURROUNDINGS, NO_SEGMENTS))
def pulled(points: FloatArray, surroundings: PathObstacles, segments: ArmSegments) -> FloatArray:
    """Pull a path taut for the tool and an arm that the kernels know.

    Args:
        points: flat (3 k,), clear for tool and arm, [unit], world.
        surroundings: what the tool keeps clear of.
        segments: what the arm keeps clear of.

    Returns:
        The path, flat, never longer.
    """
    own = _Around(surroundings, new_room(), segments, new_touched())
    both = borrowed(own)
    path = pull([vec3_at(points, 3 * k) for k in range(len(points) // 3)], both, _clear)
    taut = np.empty(3 * len(path))
    for k in range(len(path)):
        taut[3 * k], taut[3 * k + 1], taut[3 * k + 2] = path[k]
    held(own)
    return taut

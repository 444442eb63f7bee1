"""Tightening of a path among obstacles of any shape.

For convex solids it is known where a segment touches them; for meshes only the distance and its
gradient are used. A path is a list of points, [unit], world.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, compiled
from abi.obstacles.obstacle_set_kernels import distance_gradient, nearest_to_segment
from abi.obstacles.primitive_kernels import WIDTH, in_world
from abi.obstacles.primitive_tree_kernels import blocked
from abi.obstacles.triangle_mesh.surface_distance_kernels import gradient_of
from abi.obstacles.triangle_mesh.surface_kernels import (
    NO_SURFACES,
    SurfaceSet,
    meshes_met,
    nearest_mesh,
    surface_at,
)
from abi.obstacles.triangle_mesh.surface_tables_kernels import (
    DescentWorkspace,
    new_room,
    to_surface,
)
from abi.obstacles.vector_kernels import Vec3, axpy, distance, dot, sub, vec3_at
from abi.search.taut.tighten_kernels import kind_of, length_of

_LOOK_BACK = 32  # points to which one may be joined
_CUTS = 6
_SWEEPS = 12
_MOST_POINTS = 64
_HALVINGS = 9
_SETTLED = 1e-4  # part of the length that a sweep must gain to be followed by another


class PathObstacles(NamedTuple):
    """Obstacles that a path keeps clear of.

    Attributes:
        solids: rows of the primitives.
        margins: (4 k,) distance from each of them that a segment keeps, see ``FreeSpace``.
        surfaces: the meshes.
        limits: (4,) distance from each mesh that a segment keeps.
    """

    solids: FloatArray
    margins: FloatArray
    surfaces: SurfaceSet
    limits: FloatArray


NO_SURROUNDINGS = PathObstacles(FLOATS, FLOATS, NO_SURFACES, FLOATS)
"""Example for the compiler."""


@jitable
def is_clear(
    surroundings: PathObstacles, kind: int, a: Vec3, b: Vec3, room: DescentWorkspace
) -> bool:
    """Check whether the segment a..b keeps the distance of its kind from all obstacles."""
    solids, margins, surfaces, limits = surroundings
    if blocked(solids, margins, kind * (len(solids) // WIDTH), a, b):
        return False
    return meshes_met(surfaces, limits[kind], a, b, 1, room)[0] == 0


@jitable
def _outward(surroundings: PathObstacles, x: Vec3, room: DescentWorkspace) -> Vec3:
    """Gradient of the distance to the nearest obstacle, a unit vector; 0 without obstacles."""
    solids, _, surfaces, _ = surroundings
    normal = (0.0, 0.0, 0.0)
    nearest, s = nearest_to_segment(solids, math.inf, x, x)
    if s >= 0:
        normal = distance_gradient(solids, s, x)[1]
    away, mesh, triangle, _ = nearest_mesh(surfaces, nearest, nearest, x, room)
    if away >= nearest:
        return normal
    tables, placement = surface_at(surfaces, mesh)
    p = to_surface(placement, x)
    return in_world(placement.axes, gradient_of(tables, p, away / placement.factor, triangle))


@jitable
def _shortcut(path: list[Vec3], surroundings: PathObstacles, room: DescentWorkspace) -> list[Vec3]:
    """A short path from first to last by vertices of the path that see each other.

    Each vertex is joined to that from which the way from the start is shortest; what comes first is
    tried first, for it mostly is.
    """
    count = len(path)
    cost, parent = np.zeros(count), np.zeros(count, np.int64)
    for j in range(1, count):
        cost[j], parent[j] = cost[j - 1] + distance(path[j - 1], path[j]), j - 1
        for i in range(max(j - _LOOK_BACK, 0), j - 1):
            through = cost[i] + distance(path[i], path[j])
            if through < cost[j] and is_clear(
                surroundings, kind_of(i, j, count - 1), path[i], path[j], room
            ):
                cost[j], parent[j] = through, i
    chain = [count - 1]
    while chain[-1] > 0:
        chain.append(parent[chain[-1]])
    kept = [path[0]]
    for k in range(len(chain) - 2, -1, -1):
        kept.append(path[chain[k]])
    return kept


@jitable
def _segment_is_clear(
    path: list[Vec3],
    i: int,
    trial: Vec3,
    first: bool,
    surroundings: PathObstacles,
    room: DescentWorkspace,
) -> bool:
    """Check if the leg to vertex i, or else the leg from it, would be clear with it elsewhere."""
    last = len(path) - 1
    if first:
        return is_clear(surroundings, kind_of(i - 1, i, last), path[i - 1], trial, room)
    return is_clear(surroundings, kind_of(i, i + 1, last), trial, path[i + 1], room)


@jitable
def _move(path: list[Vec3], i: int, surroundings: PathObstacles, room: DescentWorkspace) -> None:
    """Move a vertex to where its legs are shortest, of the places tried.

    Towards the chord of its neighbours, straight and in the plane across the gradient of the
    distance, as far as the legs stay clear.
    """
    a, here, b = path[i - 1], path[i], path[i + 1]
    before, best = distance(a, here), distance(a, here) + distance(here, b)
    if best == 0.0:
        return
    pull = sub(axpy(before / best, sub(b, a), a), here)
    normal = _outward(surroundings, here, room)
    across = axpy(-dot(pull, normal), normal, pull)
    best *= 1.0 - 1e-12
    first = True  # whether it was the first leg that was blocked last: it mostly is again
    for direction in (pull, across):
        step = 1.0
        for _ in range(_HALVINGS):
            trial = axpy(step, direction, here)
            length = distance(a, trial) + distance(trial, b)
            step /= 2
            if length >= best:
                continue
            if not _segment_is_clear(path, i, trial, first, surroundings, room):
                continue
            first = not first
            if _segment_is_clear(path, i, trial, first, surroundings, room):
                best, path[i] = length, trial
                break


@jitable
def _cut_corners(
    path: list[Vec3], surroundings: PathObstacles, room: DescentWorkspace
) -> list[Vec3]:
    """Replace each corner that can be cut by two vertices."""
    cut = [path[0]]
    least = _SETTLED / 4 * length_of(path)
    for i in range(1, len(path) - 1):
        here = path[i]
        to_a, to_b = sub(path[i - 1], here), sub(path[i + 1], here)
        a, b = distance(path[i - 1], here), distance(path[i + 1], here)
        step = min(a, b) / 2
        found = False
        while step > 0.0 and not found:
            p, q = axpy(step / a, to_a, here), axpy(step / b, to_b, here)
            if 2 * step - distance(p, q) <= least:
                break
            if is_clear(surroundings, 0, p, q, room):
                cut.append(p)
                cut.append(q)
                found = True
            step /= 2
        if not found:
            cut.append(here)
    cut.append(path[-1])
    return cut


@compiled(example=(FLOATS, NO_SURROUNDINGS))
def tightened(points: FloatArray, surroundings: PathObstacles) -> FloatArray:
    """Pull a path (3 k,) taut, see :func:`abi.search.taut.tighten_near_meshes.tighten_near_meshes`.

    Returns:
        The new path (m, 3).
    """
    own = new_room()
    room = borrowed(own)
    path = [vec3_at(points, 3 * i) for i in range(len(points) // 3)]
    path = _shortcut(path, surroundings, room)
    for _ in range(_CUTS):
        for _ in range(_SWEEPS):
            before = length_of(path)
            for i in range(1, len(path) - 1):
                _move(path, i, surroundings, room)
            path = _shortcut(path, surroundings, room)
            if before - length_of(path) <= _SETTLED * before:
                break
        cut = _cut_corners(path, surroundings, room)
        if len(cut) == len(path) or len(cut) > _MOST_POINTS:
            break
        path = cut
    held(own)
    return np.array(path)

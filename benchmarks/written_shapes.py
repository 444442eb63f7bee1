"""Solids whose true surface is known beside their polygons, and the files that are made of them."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass

import numpy as np
import scipy

from abi.arrays import FloatArray

Chance = random.Random


@dataclass(frozen=True)
class Solid:
    """A closed solid.

    Attributes:
        vertices: (n, 3).
        polygons: ids of the corners of each, counter-clockwise from outside; some are concave.
        surface: (k, 3, 3) triangles of the same surface, which are made without cutting polygons.
    """

    vertices: FloatArray
    polygons: tuple[tuple[int, ...], ...]
    surface: FloatArray


@dataclass(frozen=True)
class Written:
    """A mesh file, and what is true of it.

    Attributes:
        suffix: of its name.
        content: bytes.
        surface: (k, 3, 3) all triangles that it places; in metres if it gives a unit.
        metres: length of its unit, [m]; None if the format gives none.
        left_out: whether it holds more than that, so that a note is needed.
        refused: whether it holds what no reader here understands, so that it must not be taken.
    """

    suffix: str
    content: bytes
    surface: FloatArray
    metres: float | None = None
    left_out: bool = False
    refused: bool = False


def solid(chance: Chance) -> Solid:
    """A prism over a star-shaped polygon, a wall with a doorway, or a box, turned at random."""
    make = chance.choice((_prism, _doorway, _box))
    plain = make(chance)
    turn = scipy.spatial.transform.Rotation.from_rotvec([chance.uniform(-3, 3) for _ in range(3)])
    matrix = turn.as_matrix()
    return Solid(plain.vertices @ matrix.T, plain.polygons, plain.surface @ matrix.T)


def pose(chance: Chance) -> FloatArray:
    """A pose (4, 4) that moves, turns and stretches, and sometimes mirrors."""
    found = np.eye(4)
    turn = scipy.spatial.transform.Rotation.from_rotvec([chance.uniform(-3, 3) for _ in range(3)])
    scale = [chance.uniform(0.4, 2) * chance.choice((1, 1, 1, -1)) for _ in range(3)]
    found[:3, :3] = turn.as_matrix() * scale
    found[:3, 3] = [chance.uniform(-5, 5) for _ in range(3)]
    return found


def placed(surface: FloatArray, at: FloatArray) -> FloatArray:
    """Triangles (k, 3, 3) at a pose; those of a mirrored solid still face outward."""
    moved = surface @ at[:3, :3].T + at[:3, 3]
    return moved[:, ::-1] if np.linalg.det(at[:3, :3]) < 0 else moved


def together(surfaces: list[FloatArray]) -> FloatArray:
    """Triangles of several surfaces, (k, 3, 3)."""
    return np.concatenate([np.empty((0, 3, 3)), *surfaces])


def _box(chance: Chance) -> Solid:
    return _extruded([[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]], range(4), 1.0)


def _doorway(chance: Chance) -> Solid:
    """A wall whose sides are one concave polygon each."""
    low, high = sorted((chance.uniform(0.5, 2), chance.uniform(2.5, 4)))
    top = chance.uniform(1, 2)
    posts = [[(0.0, 0.0), (low, 0.0), (low, top), (0.0, top)]]
    posts += [[(high, 0.0), (5.0, 0.0), (5.0, top), (high, top)]]
    posts += [[(0.0, top), (low, top), (high, top), (5.0, top), (5.0, 3.0), (0.0, 3.0)]]
    corners = [(0.0, 0.0), (low, 0.0), (low, top), (high, top), (high, 0.0), (5.0, 0.0)]
    corners += [(5.0, 3.0), (0.0, 3.0)]
    return _extruded(posts, range(8), 0.3, corners)


def _prism(chance: Chance) -> Solid:
    count = chance.randint(3, 12)
    steps = [chance.uniform(0.3, 1) for _ in range(count)]
    angles = np.cumsum(steps) * 2 * math.pi / sum(steps)
    radii = [chance.uniform(0.3, 1) for _ in range(count)]
    corners = [(r * math.cos(a), r * math.sin(a)) for r, a in zip(radii, angles, strict=True)]
    # less than half a turn between neighbours, so that all is seen from the middle
    following = [*corners[1:], corners[0]]
    if any(a[0] * b[1] - a[1] * b[0] <= 0 for a, b in zip(corners, following, strict=True)):
        return _prism(chance)
    fans = [[(0.0, 0.0), a, b] for a, b in zip(corners, following, strict=True)]
    start = chance.randrange(count)
    return _extruded(fans, [*range(start, count), *range(start)], 1.5, corners)


def _extruded(
    convex: list[list[tuple[float, float]]],
    order: range | list[int],
    height: float,
    corners: list[tuple[float, float]] | None = None,
) -> Solid:
    """A solid of a given height over a polygon.

    Args:
        convex: convex parts that fill the polygon, counter-clockwise.
        order: of the corners in the caps' polygons.
        height: along z.
        corners: of the polygon; None for those of its only part.
    """
    outline = np.array(corners or convex[0])
    count = len(outline)
    low = np.column_stack([outline, np.zeros(count)])
    high = np.column_stack([outline, np.full(count, height)])
    sides = [(k, (k + 1) % count) for k in range(count)]
    polygons = [tuple(order)[::-1], tuple(count + k for k in order)]
    polygons += [(a, b, count + b, count + a) for a, b in sides]
    flat = np.array([[p[0], p[k], p[k + 1]] for p in convex for k in range(1, len(p) - 1)])
    bottom = np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=2)
    surface = [bottom[:, ::-1], bottom + np.array([0, 0, height])]
    surface += [np.array([[low[a], low[b], high[b]], [low[a], high[b], high[a]]]) for a, b in sides]
    return Solid(np.concatenate([low, high]), tuple(polygons), np.concatenate(surface))

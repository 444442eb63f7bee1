"""Places at the edges of obstacles by which a short path may go round them.

A shortest path among polyhedra bends only at their edges (Sharir and Schorr, On Shortest Paths in
Polyhedral Spaces, SIAM J. Comput. 15, 1986), wherever the nodes of the mesh are.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arrays import FloatArray
from abi.pose import rotation
from abi.shapes import Box, Capsule, Cylinder, Sphere, nearest

Solid = Box | Sphere | Cylinder | Capsule

_SIDES = 8  # of the prism around what is round
_WIDER = 1e-6  # part of the margin that the places keep beyond it
_APART = 1e-9  # and [unit]


def waypoints(
    obstacles: tuple[Solid, ...], margin: float, ends: FloatArray, samples: int
) -> FloatArray:
    """Places that keep the margin, on the edges of the widened obstacles.

    On each edge: ``samples`` places evenly apart, and the one by which the way between the ends is
    shortest. What is round is taken for a prism of 8 sides.

    Args:
        obstacles: convex solids.
        margin: distance to keep, [unit].
        ends: start and goal (2, 3), [unit], world.
        samples: number on each edge, at least 1.

    Returns:
        Places (n, 3), [unit], world.
    """
    wider = margin * (1 + _WIDER) + _APART
    places = [np.empty((0, 3))]
    for solid in obstacles:
        axes = _axes(solid, ends)
        centre = np.array(solid.position)
        first, last = (centre + corners @ axes for corners in _edges(solid, wider))
        shares = np.linspace(0, 1, samples + 2)[1:-1, None, None]
        places.append((first + shares * (last - first)).reshape(-1, 3))
        places.append(_between(first, last, ends))
    found = np.concatenate(places)
    return found[nearest(obstacles, found)[0] >= margin]


def _axes(solid: Solid, ends: FloatArray) -> FloatArray:
    """The body's axes as rows (3, 3); a ball's z points from start to goal."""
    if not isinstance(solid, Sphere):
        return rotation(solid.wxyz).T
    ahead = ends[1] - ends[0]
    ahead = ahead / np.linalg.norm(ahead)
    side = np.cross(ahead, np.eye(3)[np.abs(ahead).argmin()])
    side /= np.linalg.norm(side)
    return np.stack([side, np.cross(ahead, side), ahead])


def _edges(solid: Solid, margin: float) -> tuple[FloatArray, FloatArray]:
    """Ends (n, 3) of the edges of a prism around the widened solid, body."""
    if isinstance(solid, Box):
        half = np.array(solid.size) / 2
        edges = []
        for axis in range(3):
            for u in (-1, 1):
                for v in (-1, 1):
                    corner = np.zeros(3)
                    corner[[axis - 1, axis - 2]] = u, v
                    edges.append((corner * (half + margin), np.eye(3)[axis] * half[axis]))
        middle, along = (np.array(part) for part in zip(*edges, strict=True))
        return middle - along, middle + along
    radius, turn = solid.radius + margin, math.pi / _SIDES
    half_height = 0.0 if isinstance(solid, Sphere) else solid.height / 2
    angle = 2 * turn * np.arange(_SIDES)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(_SIDES)], axis=1) / math.cos(turn)
    up = np.array([0.0, 0.0, 1.0])
    first, last = radius * ring - half_height * up, radius * ring + half_height * up
    if isinstance(solid, Sphere):
        return first, last
    # over an end: a cylinder's rim, or the second corner of an octagon around a cap
    if isinstance(solid, Cylinder):
        rim, height = radius * ring, half_height + margin
    else:
        rim, height = radius * math.tan(turn) * ring, half_height + radius
    rims = np.concatenate([rim - height * up, rim + height * up])
    # from each corner of a rim to the next
    return np.concatenate([first, rims]), np.concatenate(
        [last, np.roll(rims.reshape(2, _SIDES, 3), -1, axis=1).reshape(-1, 3)]
    )


def _between(first: FloatArray, last: FloatArray, ends: FloatArray) -> FloatArray:
    """The place of each edge (n, 3) at which the way between the ends by the edge is shortest."""
    along = last - first
    length = np.linalg.norm(along, axis=1, keepdims=True)
    unit = along / np.where(length > 0, length, 1)
    feet, offs = [], []
    for end in ends:
        foot = np.einsum("ni,ni->n", end - first, unit)[:, None]
        feet.append(foot)
        offs.append(np.linalg.norm(end - first - foot * unit, axis=1, keepdims=True))
    total = offs[0] + offs[1]
    at = (feet[0] * offs[1] + feet[1] * offs[0]) / np.where(total > 0, total, 1)
    return np.asarray(first + np.clip(at, 0, length) * unit)

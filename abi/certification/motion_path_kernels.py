"""Polynomials that a robot's joints follow, evaluated and bounded by their Bézier points."""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.arrays import FloatArray
from abi.certification.posed_hulls_kernels import HullPose
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS


class Path(NamedTuple):
    """Polynomials of the joints between waypoints.

    Attributes:
        points: Bézier points, flat (k (degree + 1) n,), [rad] or [m].
        width: points of a polynomial: its degree + 1.
        joints: number n of joints.
    """

    points: FloatArray
    width: int
    joints: int


PATH = Path(FLOATS, 2, 1)
"""Example of a motion."""


class PathStretch(NamedTuple):
    """Part of a motion: from a waypoint, or a place between two, to another."""

    start: float
    end: float
    halvings: int


@jitable
def _part_of(path: Path, piece: int, j: int, shares: tuple[float, float], room: FloatArray) -> None:
    """Write the Bézier points of a joint on a part of a polynomial (de Casteljau, twice)."""
    low, high = shares
    last = path.width - 1
    for i in range(path.width):
        room[i] = path.points[(piece * path.width + i) * path.joints + j]
    for level in range(1, path.width):
        for i in range(last, level - 1, -1):
            room[i] = room[i - 1] + high * (room[i] - room[i - 1])
    inner = low / high if high > 0 else 0.0
    for level in range(1, path.width):
        for i in range(path.width - level):
            room[i] = room[i] + inner * (room[i + 1] - room[i])


@jitable
def joints_at(path: Path, at: float, pose: HullPose) -> None:
    """Write the coordinates at a parameter."""
    pieces = len(path.points) // (path.width * path.joints)
    piece = min(int(at), pieces - 1)
    for j in range(path.joints):
        _part_of(path, piece, j, (0.0, at - piece), pose.room)
        pose.joints[j] = pose.room[path.width - 1]


@jitable
def ways_of(path: Path, stretch: PathStretch, pose: HullPose) -> None:
    """Write how far each coordinate gets from the pose: bounded by Bézier points."""
    first = int(stretch.start)
    last = max(first + 1, math.ceil(stretch.end))
    for j in range(path.joints):
        far = 0.0
        for piece in range(first, last):
            shares = max(stretch.start - piece, 0.0), min(stretch.end - piece, 1.0)
            _part_of(path, piece, j, shares, pose.room)
            for i in range(path.width):
                far = max(far, abs(pose.room[i] - pose.joints[j]))
        pose.ways[j] = far

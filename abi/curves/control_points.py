"""Control points of a spline that rounds a path's bends and follows its straight stretches."""

from __future__ import annotations

import math

import numpy as np

from abi import arguments
from abi.arrays import BoolArray, FloatArray
from abi.obstacles.obstacle_set import ObstacleSet

_FINEST = 1e-3  # part of a leg: the nearest a point is put to a bend
_SHARE = 0.5  # part of the room at a bend that the spline may take


def place_control_points(
    points: FloatArray, degree: int, obstacles: ObstacleSet, clearance: float
) -> tuple[FloatArray, BoolArray]:
    """Place control points on the segments of a path, dense at bends and sparser away from them.

    Where control points with the spacing h bend by an angle φ, a uniform spline of degree p cuts
    the corner by about h·φ·√((p + 1) / 24π): its basis functions are nearly normal distributions of
    variance (p + 1) / 12 (Unser, Aldroubi and Eden, IEEE Trans. Information Theory 38, 1992). That
    gives the h for which the cut takes half the room. From a bend the points stand at h, 2h, 4h,
    and so on up to the middle of the leg.

    Args:
        points: (k, 3) the path, k >= 2, [unit], world.
        degree: p, at least 1.
        obstacles: to keep clear of.
        clearance: distance to keep from them, [unit].

    Returns:
        At least p + 1 points (n, 3), which include those of the path, and flags of the others (n,).
    """
    points = arguments.polyline("points", points)
    legs = np.diff(points, axis=0)
    lengths = np.sqrt((legs**2).sum(axis=1))
    unit = legs / np.maximum(lengths, 1e-300)[:, None]
    turns = np.sqrt((np.diff(unit, axis=0) ** 2).sum(axis=1))
    room = np.maximum(_room(points, obstacles, clearance), 0.0)
    cut = math.sqrt((degree + 1) / (24 * math.pi))
    at_points = np.full(len(points), math.inf)
    np.divide(_SHARE * room, cut * turns, out=at_points[1:-1], where=turns > 0)
    spacing = at_points.tolist()
    shares = [
        [*_doubled(first / length), *(1 - share for share in _doubled(last / length)[::-1])]
        if length > 0
        else []
        for first, last, length in zip(spacing[:-1], spacing[1:], lengths.tolist(), strict=True)
    ]
    while len(points) + sum(map(len, shares)) <= degree:
        widest = int(np.argmax(lengths / [1 + len(inner) for inner in shares]))
        count = len(shares[widest]) + 1
        shares[widest] = [k / (count + 1) for k in range(1, count + 1)]
    # k + share on leg k; the vertices are at the whole numbers
    positions = np.array([k + share for k, inner in enumerate(shares) for share in (0.0, *inner)])
    leg = positions.astype(int)
    inner = points[leg] + (positions - leg)[:, None] * legs[leg]
    added = np.append(positions != leg, False)
    return np.concatenate([inner, points[-1:]]), added


def _room(points: FloatArray, obstacles: ObstacleSet, clearance: float) -> FloatArray:
    """Free distance around the inner vertices and half of their segments, (k - 2,), [unit]."""
    middles = (points[1:] + points[:-1]) / 2
    bends = np.stack([middles[:-1], points[1:-1], middles[1:]], axis=1)
    return obstacles.polyline_clearances(bends) - clearance


def _doubled(first: float) -> list[float]:
    """Fractions of a segment up to its middle, each twice the one before."""
    shares, share = [], max(first, _FINEST)
    while share < 0.5:
        shares.append(share)
        share *= 2
    return shares

"""Distance of a curve to obstacles that need not be convex: triangle meshes among them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from abi.arrays import BoolArray, FloatArray, read_only
from abi.clearance.bezier import Bezier
from abi.clearance.curve_clearance_kernels import MOST_HALVINGS, MOST_PIECES, Measured
from abi.obstacles.obstacle_set import ObstacleSet


@dataclass(frozen=True, eq=False)
class _Pieces:
    """Bézier pieces of the curve, in no order, and the distances at their ends.

    Attributes:
        control: control points (n, degree + 1, 3), [unit].
        start: first parameter (n,).
        end: last parameter (n,).
        at_start: signed distance at the first point (n,), [unit].
        at_end: signed distance at the last point (n,), [unit].
    """

    control: FloatArray
    start: FloatArray
    end: FloatArray
    at_start: FloatArray
    at_end: FloatArray

    def halved(self, chosen: BoolArray, middle: FloatArray, at_middle: FloatArray) -> _Pieces:
        """Both halves of some pieces, given the parameters and distances at all middles."""
        first, second = _halving(self.control.shape[1] - 1)
        control = self.control[chosen]
        middle, at_middle = middle[chosen], at_middle[chosen]
        return _Pieces(
            np.concatenate([first @ control, second @ control]),
            np.concatenate([self.start[chosen], middle]),
            np.concatenate([middle, self.end[chosen]]),
            np.concatenate([self.at_start[chosen], at_middle]),
            np.concatenate([at_middle, self.at_end[chosen]]),
        )


def measure_by_halving(
    curve: Bezier,
    parts: int,
    obstacles: ObstacleSet,
    required: float,
    tolerance: float,
    finest: float,
) -> Measured:
    """Measure among any obstacles, as ``measure_curve`` of the kernels does among convex ones.

    Args:
        curve: the curve.
        parts: equal parts that each polynomial is first cut into.
        obstacles: at least one.
        required: distance to keep, [unit]; nearer stretches are returned.
        tolerance: largest excess of the nearest sample over the bound, [unit].
        finest: length of stretches, in the parameter, that are not halved for their ends alone.
    """
    pieces, at, nearest, obstacle = _first_pieces(curve, parts, obstacles)
    distance = nearest
    stretches = [(0.0, 0.0)]
    line = required - 1e-9
    for halvings in range(MOST_HALVINGS + 1):
        at_middle, whose, bound = _sample(pieces.control, obstacles)
        middle = (pieces.start + pieces.end) / 2
        k = int(at_middle.argmin())
        if at_middle[k] < nearest:
            at, nearest, obstacle = float(middle[k]), float(at_middle[k]), int(whose[k])

        samples = np.stack([pieces.at_start, at_middle, pieces.at_end])
        violating = samples.min(axis=0) < line
        partly = violating & (samples.max(axis=0) >= line)
        wide = pieces.end - pieces.start > finest
        undecided = (bound < nearest - tolerance) | (~violating & (bound < required - tolerance))
        undecided |= partly & wide
        if halvings == MOST_HALVINGS or 2 * undecided.sum() > MOST_PIECES:
            undecided[:] = False

        done = ~undecided
        distance = min(distance, nearest, float(bound[done].min(initial=math.inf)))
        near = done & violating
        stretches += zip(pieces.start[near].tolist(), pieces.end[near].tolist(), strict=True)
        if done.all():
            break
        pieces = pieces.halved(undecided, middle, at_middle)
    return distance, at, nearest, obstacle, stretches


def _first_pieces(
    curve: Bezier, parts: int, obstacles: ObstacleSet
) -> tuple[_Pieces, float, float, int]:
    """Even pieces of each polynomial; parameter, distance and obstacle of their nearest end."""
    breaks = curve.breaks
    cuts = np.linspace(breaks[:-1], breaks[1:], parts, endpoint=False, axis=1).ravel()
    cuts = np.append(cuts, breaks[-1])
    control = _cut(curve.points, parts)
    ends = np.concatenate([control[:, 0], control[-1:, -1]])
    least, whose = obstacles.nearest(ends)
    k = int(least.argmin())
    pieces = _Pieces(control, cuts[:-1], cuts[1:], least[:-1], least[1:])
    return pieces, float(cuts[k]), float(least[k]), int(whose[k])


def _cut(control: FloatArray, parts: int) -> FloatArray:
    """De Casteljau: equal parts (s parts, degree + 1, 3) of polynomials (s, degree + 1, 3)."""
    cut = []
    rest = control
    for k in range(parts):
        ratio = 1 / (parts - k)
        first, last, inner = [rest[:, 0]], [rest[:, -1]], rest
        while inner.shape[1] > 1:
            inner = (1 - ratio) * inner[:, :-1] + ratio * inner[:, 1:]
            first.append(inner[:, 0])
            last.append(inner[:, -1])
        cut.append(np.stack(first, axis=1))
        rest = np.stack(last[::-1], axis=1)
    return np.stack(cut, axis=1).reshape(-1, *control.shape[1:])


def _sample(
    control: FloatArray, obstacles: ObstacleSet
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Distance at each piece's middle, its obstacle, and a lower bound along the piece, (n,)."""
    first, _ = _halving(control.shape[1] - 1)
    middle = first[-1] @ control
    offsets = control - middle[:, None]
    distances = np.empty((len(obstacles), len(middle)))
    bounds = np.empty_like(distances)
    for k, primitive in zip(obstacles.primitive_numbers, obstacles.primitives, strict=True):
        distances[k] = primitive.signed_distance(middle)
        rise = np.einsum("nij,nj->ni", offsets, primitive.gradient(middle)).min(axis=1)
        bounds[k] = distances[k] + rise
    for k, mesh in zip(obstacles.mesh_numbers, obstacles.meshes, strict=True):
        distances[k] = mesh.signed_distance(middle)
        bounds[k] = distances[k] - np.linalg.norm(offsets, axis=2).max(axis=1)
    return distances.min(axis=0), distances.argmin(axis=0), bounds.min(axis=0)


@lru_cache(maxsize=16)
def _halving(degree: int) -> tuple[FloatArray, FloatArray]:
    """De Casteljau's matrices (degree + 1, degree + 1) for the first and the second half."""
    first = np.array(
        [[math.comb(i, j) / 2**i for j in range(degree + 1)] for i in range(degree + 1)]
    )
    return read_only(first), read_only(first[::-1, ::-1].copy())

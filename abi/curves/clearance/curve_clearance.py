"""Clearance of a curve: its distance to the obstacles, measured and proven."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from abi import arguments
from abi.arrays import ShortRepr, flat
from abi.curves.bezier import Bezier
from abi.curves.clearance.certificate import Certificate, certify
from abi.curves.clearance.curve_clearance_kernels import measure_curve, measure_curve_near_meshes
from abi.curves.curve import Curve
from abi.obstacles.obstacle_set import ObstacleSet

# Distances that differ by less are the same, [unit]: rounding, not a violation.
ROUNDING = 1e-9

_FIRST_PIECES = 64
_FINEST_STRETCH = 512
_MESH_TOLERANCE = 1e-3  # of the curve's extent: of its distance to a mesh


@dataclass(frozen=True, eq=False, repr=False)
class Clearance(ShortRepr):
    """Distance of a curve to the obstacles.

    Attributes:
        distance: lower bound of the curve's distance to the obstacles, [unit]; inf without
            obstacles. Proven when there is a certificate; otherwise measured in floating point,
            its rounding not accounted for.
        at: parameter of the nearest sample.
        nearest: signed distance of the nearest sample, [unit]; negative inside an obstacle.
        obstacle: index of the obstacle it is nearest to, -1 without obstacles.
        violations: disjoint parameter intervals (from, to), in order, that contain every sample
            nearer than required by more than 1e-9; empty exactly if there is none.
        certificate: the proof of ``distance``; None when it was only measured.
    """

    distance: float
    at: float
    nearest: float
    obstacle: int
    violations: tuple[tuple[float, float], ...]
    certificate: Certificate | None = None

    @property
    def certified(self) -> bool:
        """Whether ``distance`` is proven."""
        return self.certificate is not None

    def keeps(self, required: float) -> bool:
        """Check if the distance is proven to be nowhere below ``required``, up to 1e-9."""
        return self.certified and self.distance >= required - ROUNDING


def curve_clearance(
    curve: Curve | Bezier, obstacles: ObstacleSet, required: float = 0.0, tolerance: float = 1e-3
) -> Clearance:
    """Measure the clearance of a curve, and find where it is below ``required``.

    The curve is halved into Bézier pieces. Each is sampled in its middle m, where an obstacle's
    distance d has the subgradient g. If the obstacle is convex, so is d, and a piece stays in
    the convex hull of its control points P_i (Farin, Curves and Surfaces for CAGD, section 4.3):

        d >= d(m) + min_i g . (P_i - m)    along the whole piece.

    That is never below the bound from d being 1-Lipschitz, d(m) - max_i |P_i - m|, and its error
    falls with the square of the piece's length instead of with the length. For a mesh, which need
    not be convex, the balls of free space around the piece's ends and middle bound it, with an
    error that falls as fast (:mod:`abi.curves.clearance.mesh_clearance_kernels`).

    Args:
        curve: continuous, a polynomial between its breaks.
        obstacles: primitives and meshes.
        required: distance to keep, [unit].
        tolerance: largest ``nearest - distance``, [unit], at least 1e-9. No point nearer than
            ``required - tolerance`` is left out of ``violations``.

    Halving stops at 200,000 pieces or 40 halvings, which only a tolerance far below the curve's
    size needs: ``distance`` is then a looser bound, and ``violations`` rest on the samples taken.
    """
    required = arguments.number("required", required, infinite=True)
    tolerance = arguments.number("tolerance", tolerance, 0.0, math.inf)
    pieces = curve.bezier()
    breaks = pieces.breaks
    if not obstacles:
        return Clearance(math.inf, float(breaks[0]), math.inf, -1, ())
    tolerance = max(tolerance, ROUNDING)
    parts = -(-_FIRST_PIECES // (len(breaks) - 1))
    finest = float(breaks[-1] - breaks[0]) / _FINEST_STRETCH
    curve_of_pieces = flat(pieces.points), flat(breaks), parts, obstacles.packed
    demand = float(required), tolerance, finest
    if obstacles.meshes:
        measured = measure_curve_near_meshes(*curve_of_pieces, obstacles.surfaces, demand)
    else:
        measured = measure_curve(*curve_of_pieces, demand)
    distance, at, nearest, row, stretches = measured
    obstacle = int(obstacles.rows[row])
    return Clearance(float(distance), at, float(nearest), obstacle, _joined(stretches[1:]))


def proven_clearance(
    curve: Curve | Bezier, obstacles: ObstacleSet, required: float, tolerance: float = 1e-3
) -> Clearance:
    """Measure the clearance of a curve, and prove as much of it as possible.

    Distances just below the measured one are tried, from the largest down to the required one.
    There is no certificate for a curve that enters an obstacle, nor for one that is measured to
    keep the required distance but cannot be certified to.

    If the required distance is 0 a curve may touch a primitive. Then it is proven to enter it by
    less than 1e-9, unless a primitive is too thin for that to mean anything.

    Args:
        curve: continuous, a polynomial between its breaks.
        obstacles: primitives and meshes.
        required: distance to keep, at least 0, [unit].
        tolerance: as in :func:`curve_clearance`, and the proven distance is below the measured one
            by at least an eighth of it, [unit]; near a mesh by up to a thousandth of the curve's
            extent.
    """
    required = arguments.number("required", required, infinite=True)
    tolerance = arguments.number("tolerance", tolerance, 0.0, math.inf)
    pieces = curve.bezier()
    fine = tolerance
    if not obstacles.all_convex:
        extent = np.linalg.norm(np.ptp(pieces.points.reshape(-1, 3), axis=0))
        fine = max(tolerance, _MESH_TOLERANCE * float(extent))
    measured = curve_clearance(pieces, obstacles, required, fine)
    nearest = measured.nearest
    for margin in _margins(measured, obstacles, required, max(tolerance, ROUNDING) / 8):
        if margin > nearest:
            continue
        result = certify(pieces, obstacles, margin)
        if isinstance(result, Certificate):
            return replace(measured, distance=result.margin, certificate=result)
        if result.decided:
            nearest = min(nearest, result.distance)
    return measured


def _margins(
    measured: Clearance, obstacles: ObstacleSet, required: float, step: float
) -> list[float]:
    """Candidate margins to prove, descending, [unit]."""
    if not obstacles:
        return [math.inf]
    lowest = required - ROUNDING
    if lowest < 0:
        thick = obstacles.all_convex and obstacles.least_depth > 4 * ROUNDING
        lowest = lowest if thick else 0.0
    tries = {required, required - ROUNDING, measured.distance - step}
    while measured.nearest - step > measured.distance:
        tries.add(measured.nearest - step)
        step *= 4
    if measured.distance < required:
        tries.add(measured.distance - step)
        lowest = min(lowest, 0.0)
    return sorted((margin for margin in tries if margin >= lowest), reverse=True)


def _joined(stretches: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Sort disjoint intervals, and join those that touch."""
    joined: list[tuple[float, float]] = []
    for start, end in sorted(stretches):
        if joined and start <= joined[-1][1]:
            joined[-1] = joined[-1][0], end
        else:
            joined.append((start, end))
    return tuple(joined)

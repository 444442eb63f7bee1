"""Clearance of a curve: its distance to the obstacles, measured by sampling, and proven."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from abi.arrays import flat
from abi.clearance import curve_clearance_kernels
from abi.clearance.bezier import Bezier, PolynomialCurve
from abi.clearance.certificate import Certificate, certify
from abi.clearance.mesh_clearance import measure_by_halving
from abi.obstacles.obstacle_set import ObstacleSet

# Distances that differ by less are the same, [unit]: rounding, not a violation.
ROUNDING = 1e-9

_FIRST_PIECES = 64
_FINEST_STRETCH = 512
_COARSE = 1e-3  # of the curve's extent: how finely its distance to a mesh is measured


@dataclass(frozen=True, eq=False)
class Clearance:
    """Distance of a curve to the obstacles.

    Attributes:
        distance: what the curve's distance to the obstacles does not go below, [unit]; inf without
            obstacles. Proven when there is a certificate; otherwise measured in floating point,
            its rounding not accounted for.
        at: parameter of the nearest sample.
        nearest: signed distance of the nearest sample, [unit]; negative inside an obstacle.
        obstacle: index of the obstacle it is nearest to, -1 without obstacles.
        violations: parameter intervals (from, to), in order and apart, that hold every place found
            nearer than asked by over 1e-9; empty exactly when there is none.
        certificate: the proof of ``distance``; None when it was only measured.
    """

    distance: float
    at: float
    nearest: float
    obstacle: int
    violations: tuple[tuple[float, float], ...]
    certificate: Certificate | None = None

    @property
    def holds(self) -> bool:
        """Whether no sample is nearer than asked."""
        return not self.violations

    @property
    def certified(self) -> bool:
        """Whether ``distance`` is proven."""
        return self.certificate is not None

    def keeps(self, asked: float) -> bool:
        """Whether it is proven that the distance is nowhere less than ``asked``, but for 1e-9."""
        return self.certified and self.distance >= asked - ROUNDING


def curve_clearance(
    curve: PolynomialCurve, obstacles: ObstacleSet, asked: float = 0.0, tolerance: float = 1e-3
) -> Clearance:
    """Measure how near a curve comes to the obstacles, and where nearer than ``asked``.

    The curve is halved into Bézier pieces. Each is sampled in its middle m, where an obstacle's
    distance d has the subgradient g. If the obstacle is convex, so is d, and a piece stays in
    the convex hull of its control points P_i (Farin, Curves and Surfaces for CAGD, section 4.3):

        d >= d(m) + min_i g . (P_i - m)    along the whole piece.

    That is never below the bound from d being 1-Lipschitz, d(m) - max_i |P_i - m|, and its error
    falls with the square of the piece's length instead of with the length. For a mesh, which need
    not be convex, the Lipschitz bound is what there is.

    Args:
        curve: continuous, a polynomial between its breaks.
        obstacles: the solids and meshes.
        asked: distance the curve should keep, [unit].
        tolerance: largest ``nearest - distance``, [unit]; 1e-9 where less is given. No place
            nearer than ``asked - tolerance`` is left out of ``violations``.

    Past 200,000 pieces or 40 halvings, for a tolerance far below the curve's size, halving stops:
    ``distance`` still bounds, if less tightly, and ``violations`` rest on the samples taken.
    """
    pieces = curve.bezier()
    breaks = pieces.breaks
    if not obstacles:
        return Clearance(math.inf, float(breaks[0]), math.inf, -1, ())
    tolerance = max(tolerance, ROUNDING)
    parts = -(-_FIRST_PIECES // (len(breaks) - 1))
    finest = float(breaks[-1] - breaks[0]) / _FINEST_STRETCH
    if obstacles.all_convex:
        measured = curve_clearance_kernels.measure_curve(
            *(flat(pieces.points), flat(breaks), parts, obstacles.packed),
            *(float(asked), tolerance, finest),
        )
    else:
        measured = measure_by_halving(pieces, parts, obstacles, asked, tolerance, finest)
    distance, at, nearest, obstacle, stretches = measured
    return Clearance(distance, at, nearest, obstacle, _joined(stretches[1:]))


def prove(
    curve: PolynomialCurve, obstacles: ObstacleSet, asked: float, tolerance: float = 1e-3
) -> Clearance:
    """Measure how near a curve comes to the obstacles, then prove as much of it as can be.

    Distances just under the measured one are tried from the largest down, to what was asked for.
    A curve that enters an obstacle, or is measured to keep what is asked for and cannot be
    certified to, gets no certificate.

    A curve that is to keep no distance may touch a solid: then it is proven that it goes in by
    less than 1e-9, unless a solid is so thin that this means nothing.

    Args:
        curve: continuous, a polynomial between its breaks.
        obstacles: the solids and meshes.
        asked: distance the curve should keep, at least 0, [unit].
        tolerance: as in :func:`curve_clearance`, and an eighth of it is the least that the proven
            distance is below the measured one, [unit]. Near a mesh up to a thousandth of the
            curve's extent may be lost.
    """
    pieces = curve.bezier()
    fine = tolerance if obstacles.all_convex else max(tolerance, _coarse(pieces))
    found = curve_clearance(pieces, obstacles, asked, fine)
    nearest = found.nearest
    for margin in _margins(found, obstacles, asked, max(tolerance, ROUNDING) / 8):
        if margin > nearest:
            continue
        result = certify(pieces, obstacles, margin)
        if isinstance(result, Certificate):
            return replace(found, distance=result.margin, certificate=result)
        if result.decided:
            nearest = min(nearest, result.distance)
    return found


def _margins(found: Clearance, obstacles: ObstacleSet, asked: float, step: float) -> list[float]:
    """Distances to try to prove, falling, [unit]."""
    if not obstacles:
        return [math.inf]
    lowest = asked - ROUNDING
    if lowest < 0:
        depth = [
            -float(solid.signed_distance(np.array([solid.position]))[0])
            for solid in obstacles.primitives
        ]
        depth += [0.0] * len(obstacles.meshes)
        lowest = lowest if min(depth) > 4 * ROUNDING else 0.0
    tries = {asked, asked - ROUNDING, found.distance - step}
    while found.nearest - step > found.distance:
        tries.add(found.nearest - step)
        step *= 4
    if found.distance < asked:
        tries.add(found.distance - step)
        lowest = min(lowest, 0.0)
    return sorted((margin for margin in tries if margin >= lowest), reverse=True)


def _coarse(curve: Bezier) -> float:
    """Tolerance of a measurement near a mesh, [unit]."""
    extent = np.ptp(curve.points.reshape(-1, 3), axis=0)
    return _COARSE * float(np.linalg.norm(extent))


def _joined(stretches: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Sort intervals that do not overlap, and join those that touch."""
    joined: list[tuple[float, float]] = []
    for start, end in sorted(stretches):
        if joined and start <= joined[-1][1]:
            joined[-1] = joined[-1][0], end
        else:
            joined.append((start, end))
    return tuple(joined)

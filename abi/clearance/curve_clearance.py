"""How clear of the obstacles a curve is: measured by adaptive sampling, and proven."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import cast

import numpy as np

from abi.arrays import BoolArray, FloatArray, flat, read_only
from abi.clearance import curve_clearance_kernels as curve_clearance
from abi.clearance.bezier import PolynomialCurve, bezier
from abi.clearance.certificate import Certificate, certify
from abi.curves.curve import Curve
from abi.obstacles.obstacle_set import ObstacleSet

# Distances that differ by less are the same, [unit]: rounding, not a violation.
ROUNDING = 1e-9

_FIRST_PIECES = 64
_FINEST_STRETCH = 512
_MOST_PIECES = 200_000
_MOST_HALVINGS = 40
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

    def halved(self, rows: BoolArray, middle: FloatArray, at_middle: FloatArray) -> _Pieces:
        """Both halves of the pieces ``rows``, whose mid parameters and distances are given."""
        first, second = _halving(self.control.shape[1] - 1)
        control = self.control[rows]
        middle, at_middle = middle[rows], at_middle[rows]
        return _Pieces(
            np.concatenate([first @ control, second @ control]),
            np.concatenate([self.start[rows], middle]),
            np.concatenate([middle, self.end[rows]]),
            np.concatenate([self.at_start[rows], at_middle]),
            np.concatenate([at_middle, self.at_end[rows]]),
        )


def measure(
    curve: Curve, obstacles: ObstacleSet, asked: float = 0.0, tolerance: float = 1e-3
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
        curve: polynomial between its breaks, continuous.
        obstacles: the solids and meshes.
        asked: distance the curve should keep, [unit].
        tolerance: largest ``nearest - distance``, [unit]; 1e-9 where less is given. No place
            nearer than ``asked - tolerance`` is left out of ``violations``.

    Past 200,000 pieces or 40 halvings, for a tolerance far below the curve's size, halving stops:
    ``distance`` still bounds, if less tightly, and ``violations`` rest on the samples taken.
    """
    if not obstacles:
        return Clearance(math.inf, float(curve.interval[0]), math.inf, -1, ())
    tolerance = max(tolerance, ROUNDING)
    if obstacles.all_convex:
        return _measured(*_polynomials(curve), obstacles, asked, tolerance)
    pieces, at, nearest, obstacle = _first_pieces(curve, obstacles)
    distance = nearest
    stretches: list[tuple[float, float]] = []
    finest = (curve.interval[1] - curve.interval[0]) / _FINEST_STRETCH
    for halvings in range(_MOST_HALVINGS + 1):
        at_middle, whose, bound = _sample(pieces.control, obstacles)
        middle = (pieces.start + pieces.end) / 2
        k = int(at_middle.argmin())
        if at_middle[k] < nearest:
            at, nearest, obstacle = float(middle[k]), float(at_middle[k]), int(whose[k])

        samples = np.stack([pieces.at_start, at_middle, pieces.at_end])
        violating = samples.min(axis=0) < asked - ROUNDING
        partly = violating & (samples.max(axis=0) >= asked - ROUNDING)
        wide = pieces.end - pieces.start > finest
        unsure = (bound < nearest - tolerance) | (~violating & (bound < asked - tolerance))
        unsure |= partly & wide
        if halvings == _MOST_HALVINGS or 2 * unsure.sum() > _MOST_PIECES:
            unsure[:] = False

        done = ~unsure
        distance = min(distance, nearest, float(bound[done].min(initial=math.inf)))
        kept = done & violating
        stretches += zip(pieces.start[kept].tolist(), pieces.end[kept].tolist(), strict=True)
        if done.all():
            break
        pieces = pieces.halved(unsure, middle, at_middle)
    return Clearance(distance, at, nearest, obstacle, _joined(stretches))


def _measured(
    breaks: FloatArray,
    control: FloatArray,
    obstacles: ObstacleSet,
    asked: float,
    tolerance: float,
) -> Clearance:
    """:func:`measure` of Bézier pieces (s, degree + 1, 3) among convex solids alone."""
    parts = -(-_FIRST_PIECES // max(len(breaks) - 1, 1))
    finest = float(breaks[-1] - breaks[0]) / _FINEST_STRETCH
    distance, at, nearest, obstacle, stretches = curve_clearance.curve(
        *(flat(control), flat(breaks), parts, obstacles.packed),
        *(float(asked), tolerance, finest),
    )
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
        curve: has ``knots`` and ``control_points``, or quadratic ``pieces``; continuous.
        obstacles: the solids and meshes.
        asked: distance the curve should keep, at least 0, [unit].
        tolerance: as in :func:`measure`, and an eighth of it is the least that the proven distance
            is below the measured one, [unit]. Near a mesh up to a thousandth of the curve's
            extent may be lost.
    """
    pieces = bezier(curve)
    if not obstacles.all_convex:
        extent = np.ptp(pieces.points.reshape(-1, 3), axis=0)
        fine = max(tolerance, _COARSE * float(np.linalg.norm(extent)))
        found = measure(curve, obstacles, asked, fine)
    elif obstacles:
        fine = max(tolerance, ROUNDING)
        found = _measured(pieces.breaks, pieces.points, obstacles, asked, fine)
    else:
        found = measure(curve, obstacles)
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


@lru_cache(maxsize=16)
def _shares(degree: int) -> FloatArray:
    return read_only(np.linspace(0, 1, degree + 1))


@lru_cache(maxsize=16)
def _from_samples(degree: int) -> FloatArray:
    """Matrix that turns degree + 1 evenly spaced points of a piece into its control points."""
    v = np.linspace(0, 1, degree + 1)[:, None]
    i = np.arange(degree + 1)
    choose = np.array([math.comb(degree, k) for k in i])
    bernstein = choose * v**i * (1 - v) ** (degree - i)
    return read_only(np.asarray(np.linalg.inv(bernstein), dtype=np.float64))


@lru_cache(maxsize=16)
def _halving(degree: int) -> tuple[FloatArray, FloatArray]:
    """De Casteljau's matrices (degree + 1, degree + 1) for the first and the second half."""
    first = np.array(
        [[math.comb(i, j) / 2**i for j in range(degree + 1)] for i in range(degree + 1)]
    )
    return read_only(first), read_only(first[::-1, ::-1].copy())


def _first_pieces(curve: Curve, obstacles: ObstacleSet) -> tuple[_Pieces, float, float, int]:
    """Cut the curve evenly between its breaks; also the nearest end of a piece and whose it is."""
    breaks = np.unique(curve.breaks)
    parts = -(-_FIRST_PIECES // max(len(breaks) - 1, 1))
    cuts = np.linspace(breaks[:-1], breaks[1:], parts, endpoint=False, axis=1).ravel()
    cuts = np.append(cuts, breaks[-1])
    start, end = cuts[:-1], cuts[1:]
    control = _bezier_points(curve, start, end)
    ends = np.concatenate([control[:, 0], control[-1:, -1]])
    least, whose = obstacles.nearest(ends)
    k = int(least.argmin())
    pieces = _Pieces(control, start, end, least[:-1], least[1:])
    return pieces, float(cuts[k]), float(least[k]), int(whose[k])


def _polynomials(curve: Curve) -> tuple[FloatArray, FloatArray]:
    """A curve's breaks (s + 1,), and the control points (s, degree + 1, 3) between them."""
    if hasattr(curve, "knots") or hasattr(curve, "pieces"):
        pieces = bezier(cast(PolynomialCurve, curve))
        return pieces.breaks, pieces.points
    breaks = np.unique(curve.breaks)
    return breaks, _bezier_points(curve, breaks[:-1], breaks[1:])


def _bezier_points(curve: Curve, start: FloatArray, end: FloatArray) -> FloatArray:
    """Control points (n, degree + 1, 3) of the curve from ``start`` (n,) to ``end``, no breaks."""
    degree = max(curve.degree, 1)
    parameters = start[:, None] + (end - start)[:, None] * _shares(degree)
    return _from_samples(degree) @ curve(parameters.ravel()).reshape(len(start), degree + 1, 3)


def _sample(
    control: FloatArray, obstacles: ObstacleSet
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Distance at each piece's middle, whose it is, and a lower bound along the piece, (n,)."""
    first, _ = _halving(control.shape[1] - 1)
    middle = first[-1] @ control
    offsets = control - middle[:, None]
    distances = np.empty((len(obstacles), len(middle)))
    bounds = np.empty_like(distances)
    for k, solid in zip(obstacles.primitive_numbers, obstacles.primitives, strict=True):
        distances[k] = solid.signed_distance(middle)
        rise = np.einsum("nij,nj->ni", offsets, solid.gradient(middle)).min(axis=1)
        bounds[k] = distances[k] + rise
    for k, mesh in zip(obstacles.mesh_numbers, obstacles.meshes, strict=True):
        distances[k] = mesh.signed_distance(middle)
        bounds[k] = distances[k] - np.linalg.norm(offsets, axis=2).max(axis=1)
    return distances.min(axis=0), distances.argmin(axis=0), bounds.min(axis=0)


def _joined(stretches: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Sort intervals that do not overlap, and join those that touch."""
    joined: list[tuple[float, float]] = []
    for start, end in sorted(stretches):
        if joined and start <= joined[-1][1]:
            joined[-1] = joined[-1][0], end
        else:
            joined.append((start, end))
    return tuple(joined)

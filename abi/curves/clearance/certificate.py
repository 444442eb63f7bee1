"""Proofs that a whole curve keeps its distance from every obstacle.

Theorem. Let P_0 … P_p be points whose convex hull holds a piece of a curve, let O be a compact
convex set with the support function h(n) = max n·x over O, and let abs(n) = 1. If
min n·P_i - h(n) > m, then the piece's signed distance to O is above m.

Proof. Points B of the piece are convex combinations of the P_i, so n·B >= min n·P_i > h(n) + m,
and for x in O abs(B - x) >= n·(B - x) > m. (The signed distance to a convex set is the greatest
n·B - h(n) over all n, so this holds for m < 0 too.)

The theorem holds for any n, so n may be guessed: here the direction from the obstacle to a point
in the middle of the piece. A piece that it does not separate is halved. When the clearance is
above m + e, pieces smaller than e are separated, so this ends; halving stops at 2^-36 of the
largest coordinate, and what is then left is undecided, which counts as not certified.

Rounding. With u = 2^-53, S the sum of the largest coordinates of curve and obstacle, p the degree
and k the halvings: turning into the body frame and the direction back, the products and the
support take at most 128 u S, the Bézier points 16 p u S, each halving 12 p u S, and abs(n) is
within 64 u of 1. A piece is separated when that much more than m is found: so the claim holds for
the curve, the obstacles and the directions as the numbers say, in exact arithmetic.
:mod:`abi.verify.verify` checks that, and ``tests/abi/test_proof_constants.py`` derives the numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from abi import arguments
from abi.arrays import BoolArray, FloatArray, IntArray, ShortRepr, flat, read_only
from abi.curves.bezier import Bezier
from abi.curves.clearance.certify_curve_kernels import separate_from_mesh, separate_from_primitives
from abi.curves.clearance.separation_kernels import CERTIFIED, MOST_HALVINGS, REFUTED, Outcome
from abi.curves.curve import Curve
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import rotation
from abi.obstacles.primitive_kernels import BOUNDS, WIDTH
from abi.obstacles.triangle_mesh.bvh import tree_of

_MOST_TRIES = 20_000  # for each obstacle, and 64 for each polynomial
_CHORDS = 8  # of each polynomial, to see which meshes it may be near
_PLACED = 1e-10  # of a mesh's coordinates: more than the error of its place and of its box's


@dataclass(frozen=True, eq=False, repr=False)
class Certificate(ShortRepr):
    """Directions that separate a curve, or an arm along a whole curve or motion, from obstacles.

    Of an arm they separate its capsules; of a motion that was planned elsewhere convex bodies.

    Attributes:
        margin: distance from every obstacle that is kept, [unit]; inf when there are no obstacles.
            From floor and column an arm keeps more than 0.
        pieces: first and last parameter of the piece for each direction, shape (k, 2).
        obstacle: number of the obstacle of each, or of what an arm's collision world has besides,
            shape (k,). From a mesh it separates only some triangles; together, those of a mesh
            separate all of them.
        directions: unit vectors from the obstacle to the curve or capsule, shape (k, 3), world.
        poses: parameter, within the piece, of the arm's pose around which each holds, shape (k,);
            of a curve alone the piece's first.
        capsule: number of the capsule of each, shape (k,); -1 of a curve alone.
        positions: joint positions that the parameters count, shape (m, n), [rad] or [unit], with
            straight motion between them; None if the parameters are a curve's.
        closer: whether a direction separates the hull in the capsule, not the capsule, (k,); None
            where there are no hulls.
    """

    margin: float
    pieces: FloatArray
    obstacle: IntArray
    directions: FloatArray
    poses: FloatArray
    capsule: IntArray
    positions: FloatArray | None = None
    closer: BoolArray | None = None


@dataclass(frozen=True, eq=False)
class Refutation:
    """A place that prevents a certificate of a curve, or of an arm along it.

    Attributes:
        parameter: where on the curve.
        obstacle: number of the obstacle that is too near there, or of what an arm's collision world
            has besides.
        decided: whether it is certain to be nearer than the margin there, or out of the arm's
            reach; otherwise it is so close to the margin that halving did not decide.
        capsule: number of the arm's capsule; -1 of a curve alone, and where the arm does not reach
            the place.
        distance: signed distance of a curve from the obstacle there, [unit]; nan where it is not
            measured, as that of an arm.
    """

    parameter: float
    obstacle: int
    decided: bool
    capsule: int = -1
    distance: float = math.nan


def certify(
    curve: Curve | Bezier, obstacles: ObstacleSet, margin: float
) -> Certificate | Refutation:
    """Prove that a curve keeps more than ``margin`` from every obstacle, or find where it fails.

    A curve that starts outside a closed mesh and keeps clear of its surface stays outside. From a
    primitive a negative margin can be proven: the curve goes no deeper than that. A mesh needs a
    margin of at least 0.

    Args:
        curve: continuous, a polynomial between its breaks.
        obstacles: primitives and meshes.
        margin: finite, [unit].

    Raises:
        ArgumentError: the margin is not finite.
    """
    margin = arguments.number("margin", margin, infinite=not obstacles)
    pieces = curve.bezier()
    if not obstacles:
        return _certificate(math.inf, [])
    tables: list[FloatArray] = []
    if obstacles.primitives:
        numbers = obstacles.primitive_numbers
        status, at, which, distance, planes = _separate(pieces, obstacles.packed, margin)
        if status != CERTIFIED:
            number = int(numbers[which])
            return Refutation(at, number, status == REFUTED, distance=distance)
        planes[:, 2] = numbers[planes[:, 2].astype(int)]
        tables.append(planes)
    near = np.ones(len(obstacles.meshes), dtype=np.bool_)
    if len(near) > 1 and margin >= 0:
        near, planes = _behind_boxes(pieces, obstacles, margin)
        tables.append(planes)
    for k in np.flatnonzero(near).tolist():
        number = int(obstacles.mesh_numbers[k])
        result = _against_mesh(pieces, obstacles.meshes[k], number, margin)
        if isinstance(result, Refutation):
            return result
        tables.append(result)
    return _certificate(margin, tables)


def _behind_boxes(
    curve: Bezier, obstacles: ObstacleSet, margin: float
) -> tuple[BoolArray, FloatArray]:
    """Separate a curve from the boxes of distant meshes, and so from the meshes.

    Returns:
        Which meshes (m,) are left, and the planes for the others.
    """
    points, away = curve.chords(_CHORDS)
    starts, ends = points[:, :-1].reshape(-1, 3), points[:, 1:].reshape(-1, 3)
    # a box and its mesh are placed with roundings of their own
    sides = obstacles.packed_mesh_boxes.reshape(-1, WIDTH)[:, BOUNDS : BOUNDS + 6]
    beyond = margin + _PLACED * float(np.abs(sides).max())
    limits = np.full(len(starts), beyond + away)
    found = [number for number, _, _ in obstacles.near_meshes(starts, ends, limits)]
    near = np.isin(obstacles.mesh_numbers, found)
    boxes = obstacles.packed_mesh_boxes.reshape(-1, WIDTH)[~near]
    if not len(boxes):
        return near, np.empty((0, 7))
    status, *_, planes = _separate(curve, boxes.ravel(), beyond)
    if status != CERTIFIED:
        return np.ones_like(near), np.empty((0, 7))
    planes[:, 2] = obstacles.mesh_numbers[~near][planes[:, 2].astype(int)]
    return near, planes


def _separate(curve: Bezier, primitives: FloatArray, margin: float) -> Outcome:
    """Separate a curve from packed primitives."""
    outcome: Outcome = separate_from_primitives(
        flat(curve.points),
        flat(curve.breaks),
        _buffer(curve),
        primitives,
        curve.size,
        float(margin),
        _MOST_TRIES + 64 * len(curve.points),
    )
    return outcome


def _against_mesh(
    curve: Bezier, mesh: MeshShape, index: int, margin: float
) -> FloatArray | Refutation:
    """Planes that separate the curve from all triangles of one mesh."""
    first = float(curve.breaks[0])
    if margin < 0:
        return Refutation(first, index, False)
    tree = tree_of(mesh.surface)
    axes, position, factor = rotation(mesh.wxyz), np.array(mesh.position), mesh.factor
    points = _buffer(curve)
    points[: curve.points.size] = ((curve.points - position) @ axes / factor).ravel()
    scale = (curve.size + float(np.abs(position).max())) / factor + 2 * tree.size
    status, at, _, distance, planes = separate_from_mesh(
        points,
        curve.breaks.copy(),
        curve.degree,
        tree,
        scale,
        margin / factor,
        10 * _MOST_TRIES + 64 * len(curve.points),
    )
    if status != CERTIFIED:
        return Refutation(at, index, status == REFUTED, distance=distance * factor)
    start = curve.points[0, :1]
    # bounds first: far from a large mesh the nearest triangle takes long to find
    if mesh.closed and mesh.distance_bounds(start)[0][0] <= 0:
        at_start = float(mesh.signed_distance(start)[0])
        if at_start <= 0:
            return Refutation(first, index, True, distance=at_start)
    planes[:, 2] = index
    planes[:, 3:6] = planes[:, 3:6] @ axes.T
    return planes


def _buffer(curve: Bezier) -> FloatArray:
    """Buffer for the points of the curve and of its halves, see ``separate_from_primitives``."""
    pieces = len(curve.points) + 2 * MOST_HALVINGS + 2
    return np.zeros(3 * pieces * (curve.degree + 1))


def _certificate(margin: float, tables: list[FloatArray]) -> Certificate:
    table = tables[0] if len(tables) == 1 else np.concatenate([np.empty((0, 7)), *tables])
    return Certificate(
        margin=margin,
        pieces=read_only(table[:, :2].copy()),
        obstacle=read_only(table[:, 2].astype(np.int32)),
        directions=read_only(table[:, 3:6].copy()),
        poses=read_only(table[:, 0].copy()),
        capsule=read_only(np.full(len(table), -1, dtype=np.int32)),
    )

"""Distances to convex shapes in numpy, by formulas of their own: what the kernels must find.

Points are (n, 3), [unit], world.
"""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.convex_shape import ConvexShape
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.pose import rotation
from abi.obstacles.primitives import Cylinder


def signed_distance(shape: Obstacle | ConvexShape, points: FloatArray) -> FloatArray:
    """Euclidean distance (n,) to the surface, [unit]; negative inside."""
    if isinstance(shape, MeshShape):
        return shape.signed_distance(points)
    return _distance(shape, _to_body(shape, points))


def gradient(shape: Obstacle | ConvexShape, points: FloatArray) -> FloatArray:
    """Unit vectors (n, 3), world, along which the signed distance grows fastest."""
    if isinstance(shape, MeshShape):
        return shape.signed_distance_gradient(points)[1]
    return np.asarray(_gradient(shape, _to_body(shape, points)) @ rotation(shape.wxyz).T)


def segment_distance(shape: Obstacle | ConvexShape, p: FloatArray, q: FloatArray) -> FloatArray:
    """Least signed distance (n,) along the segments from p to q, [unit].

    Exact up to rounding (cylinder: the place to 2^-50 of the segment); p may equal q.
    """
    if isinstance(shape, MeshShape):
        return shape.segment_distance(p, q)
    a, b = _to_body(shape, p), _to_body(shape, q)
    d = b - a
    least = _distance(shape, a + _nearest_parameter(shape, a, d)[:, None] * d)
    return np.minimum(least, np.minimum(_distance(shape, a), _distance(shape, b)))


def _to_body(shape: ConvexShape, points: FloatArray) -> FloatArray:
    return np.asarray((points - np.array(shape.position)) @ rotation(shape.wxyz))


def _half(shape: ConvexShape) -> FloatArray:
    """Half sizes (3,) of the core."""
    return np.array(shape.core()[:3])


def _excess(shape: ConvexShape, x: FloatArray) -> FloatArray:
    """Excess (n, k) of the coordinates over the half sizes; a cylinder's are radial and axial."""
    if isinstance(shape, Cylinder):
        radial = np.hypot(x[:, 0], x[:, 1]) - shape.radius
        return np.stack([radial, np.abs(x[:, 2]) - shape.height / 2], axis=1)
    return np.asarray(np.abs(x) - _half(shape))


def _distance(shape: ConvexShape, x: FloatArray) -> FloatArray:
    """Signed distance (n,) of body points (n, 3)."""
    return _excess_distance(_excess(shape, x)) - shape.core().radius


def _gradient(shape: ConvexShape, x: FloatArray) -> FloatArray:
    """A unit subgradient (n, 3) of the signed distance at body points (n, 3)."""
    excess = _excess(shape, x)
    nearest_face = np.eye(excess.shape[1])[excess.argmax(axis=1)]
    direction = _unit_vectors(np.maximum(excess, 0), nearest_face)
    if isinstance(shape, Cylinder):
        radial = _unit_vectors(x[:, :2], np.array([1.0, 0.0])) * direction[:, :1]
        return np.concatenate([radial, np.copysign(direction[:, 1:], x[:, 2:])], axis=1)
    return np.copysign(direction, x)


def _nearest_parameter(shape: ConvexShape, p: FloatArray, d: FloatArray) -> FloatArray:
    """Parameter (n,) in [0, 1] of the least signed distance along p + t d, body (n, 3)."""
    if isinstance(shape, Cylinder):
        return _bisected(shape, p, d)
    half = _half(shape)
    t = _nearest_to_box(p, d, half)
    inside = np.flatnonzero(_excess_distance(np.abs(p + t[:, None] * d) - half) <= 0)
    t[inside] = _deepest_in_box(p[inside], d[inside], half)
    return t


def _bisected(shape: Cylinder, p: FloatArray, d: FloatArray) -> FloatArray:
    """Past the rim the minimum is the root of a quartic; bisection on the slope needs no case."""
    low, high = np.zeros(len(p)), np.ones(len(p))
    for _ in range(50):
        t = (low + high) / 2
        rising = _dot(_gradient(shape, p + t[:, None] * d), d) > 0
        low, high = np.where(rising, low, t), np.where(rising, t, high)
    return np.asarray((low + high) / 2)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Products (...,) of vectors (..., k)."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def _unit_vectors(vectors: FloatArray, otherwise: FloatArray) -> FloatArray:
    """Unit vectors (n, k) along ``vectors``; ``otherwise``, unit too, where these are zero."""
    largest = np.abs(vectors).max(axis=1, keepdims=True)
    # Scaling first keeps the squares of the smallest vectors from vanishing.
    scaled = np.where(largest > 0, vectors / np.where(largest > 0, largest, 1), otherwise)
    return np.asarray(scaled / np.sqrt(_dot(scaled, scaled))[:, None])


def _excess_distance(excess: FloatArray) -> FloatArray:
    """Signed distance (n,) from the coordinates' excess (n, k) over the solid's half sizes."""
    outside = np.maximum(excess, 0)
    return np.asarray(np.sqrt(_dot(outside, outside)) + np.minimum(excess.max(axis=1), 0))


def _nearest_to_box(p: FloatArray, d: FloatArray, half: FloatArray) -> FloatArray:
    """Parameter (n,) in [0, 1] at which p + t d is nearest to the box of half sizes ``half``.

    Half the derivative of the squared distance, sum (x_i - clip x_i) d_i, is continuous, never
    falls and is linear between the crossings of the six face planes: its zero is exact.
    """
    t = np.zeros((len(p), 8))
    for column, faces in ((1, -half), (4, half)):
        with np.errstate(over="ignore"):
            np.divide(faces - p, d, out=t[:, column : column + 3], where=d != 0)
    t[:, 7] = 1
    t = np.sort(np.clip(t, 0, 1), axis=1)
    x = p[:, None] + t[..., None] * d[:, None]
    slope = _dot(x - np.clip(x, -half, half), d[:, None])
    rows = np.arange(len(p))
    k = np.clip((slope <= 0).sum(axis=1) - 1, 0, 6)
    a, b = slope[rows, k], slope[rows, k + 1]
    share = np.clip(-a / np.where(b > a, b - a, 1), 0, 1)
    return np.asarray(t[rows, k] + share * (t[rows, k + 1] - t[rows, k]))


def _deepest_in_box(p: FloatArray, d: FloatArray, half: FloatArray) -> FloatArray:
    """Parameter (n,) in [0, 1] at which p + t d, which meets the box, lies deepest in it.

    Inside, the signed distance is the greatest of six functions linear in t, one for each face.
    The lowest point of such an envelope is an end or where two of them are equal.
    """
    distance = np.concatenate([p - half, -p - half], axis=1)
    slope = np.concatenate([d, -d], axis=1)
    i, j = np.triu_indices(6, 1)
    closing = slope[:, i] - slope[:, j]
    t = np.zeros((len(p), len(i) + 2))
    t[:, 1] = 1
    with np.errstate(over="ignore"):
        np.divide(distance[:, j] - distance[:, i], closing, out=t[:, 2:], where=closing != 0)
    t = np.clip(t, 0, 1)
    greatest = (distance[:, None] + t[..., None] * slope[:, None]).max(axis=2)
    return np.asarray(t[np.arange(len(p)), greatest.argmin(axis=1)])

"""Convex shapes placed in the world, their signed distance and their distance to segments.

Each is convex, so its signed distance is a convex function of the point
(Boyd and Vandenberghe, Convex Optimization, 2004, section 3.2.5 and exercise 8.5). Two things rest
on that: along a segment it has no local minimum but the global one, and every tangent bounds it
from below. Triangle meshes (:mod:`abi.obstacles.mesh_shape`) need not be convex. Lengths are in the
scene's [unit]; arrays of points are in the world frame unless named body.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Self

import numpy as np

from abi.arrays import FloatArray, IntArray, read_only
from abi.obstacles.pose import Posed, Vec3, rotation
from abi.obstacles.primitive_kernels import Core


class ConvexShape(Posed):
    """A convex solid and its pose.

    A child says its core, its surface and its first size. The distances here are those of a box
    with a radius around it; a child that is no such solid has its own. They are in the body frame,
    and the public methods in the world's.
    """

    convex: ClassVar[bool] = True

    shape: str

    @abstractmethod
    def core(self) -> Core:
        """The shape as the numbers that the kernels take, body."""

    @abstractmethod
    def surface(self, sides: int) -> tuple[FloatArray, IntArray]:
        """Triangles to draw, whose corners lie on the surface.

        Args:
            sides: of the polygon that stands for a circle.

        Returns:
            Vertices (v, 3), [unit], body, and their numbers in each triangle (m, 3).
        """

    @classmethod
    @abstractmethod
    def of_length(cls, length: float, position: Vec3) -> Self:
        """A shape about as long as ``length``, [unit], at a position, [unit], world."""

    def parts(self) -> tuple[ConvexShape, ...]:
        """Shapes whose union this is, for programs that know boxes, spheres and cylinders only."""
        return (self,)

    def triangles(self, sides: int = 24) -> FloatArray:
        """Triangles (m, 3, 3) of the surface, [unit], world."""
        vertices, faces = self.surface(sides)
        return np.asarray((vertices @ rotation(self.wxyz).T + np.array(self.position))[faces])

    def half_extents(self, rotation: FloatArray) -> FloatArray:
        """Half extents (3,) of the solid, turned by a rotation (3, 3), along the axes, [unit]."""
        return np.asarray(np.abs(rotation) @ self._half() + self.core().radius)

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Low and high corner, each (3,), of the tightest axis-parallel box, [unit], world."""
        half = self.half_extents(rotation(self.wxyz))
        return read_only(self.position - half), read_only(self.position + half)

    def signed_distance(self, points: FloatArray) -> FloatArray:
        """Euclidean distance (n,) of points (n, 3) to the surface, [unit]; negative inside."""
        return self._distance(self._to_body(points))

    def gradient(self, points: FloatArray) -> FloatArray:
        """Unit vectors (n, 3) along which the signed distance of points (n, 3) grows fastest.

        Where that direction is not unique (on the medial axis, at edges) it is one of the valid
        ones, hence always a subgradient: d(x) >= d(p) + gradient(p) . (x - p) for all x.
        """
        return np.asarray(self._gradient(self._to_body(points)) @ rotation(self.wxyz).T)

    def signed_distance_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Signed distance (n,) of points (n, 3), [unit], and its gradient (n, 3), world."""
        return self.signed_distance(points), self.gradient(points)

    def segment_distance(self, p: FloatArray, q: FloatArray) -> FloatArray:
        """Least signed distance (n,) along the segments from p (n, 3) to q (n, 3), [unit].

        Exact up to rounding (cylinder: the place to 2^-50 of the segment); p may equal q.
        """
        a, b = self._to_body(p), self._to_body(q)
        d = b - a
        least = self._distance(a + self._nearest_parameter(a, d)[:, None] * d)
        return np.minimum(least, np.minimum(self._distance(a), self._distance(b)))

    def _half(self) -> FloatArray:
        """Half sizes (3,) of the core."""
        return np.array(self.core()[:3])

    def _distance(self, x: FloatArray) -> FloatArray:
        """Signed distance (n,) of body points (n, 3)."""
        return excess_distance(np.abs(x) - self._half()) - self.core().radius

    def _gradient(self, x: FloatArray) -> FloatArray:
        """A unit subgradient (n, 3) of the signed distance at body points (n, 3)."""
        return np.copysign(excess_direction(np.abs(x) - self._half()), x)

    def _nearest_parameter(self, p: FloatArray, d: FloatArray) -> FloatArray:
        """Parameter (n,) in [0, 1] of the least signed distance along p + t d, body (n, 3)."""
        half = self._half()
        t = _nearest_to_box(p, d, half)
        inside = np.flatnonzero(excess_distance(np.abs(p + t[:, None] * d) - half) <= 0)
        t[inside] = _deepest_in_box(p[inside], d[inside], half)
        return t


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Products (...,) of vectors (..., k)."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def unit_vectors(vectors: FloatArray, otherwise: FloatArray) -> FloatArray:
    """Unit vectors (n, k) along ``vectors``; ``otherwise``, unit too, where these are zero."""
    largest = np.abs(vectors).max(axis=1, keepdims=True)
    # Scaling first keeps the squares of the smallest vectors from vanishing.
    scaled = np.where(largest > 0, vectors / np.where(largest > 0, largest, 1), otherwise)
    return np.asarray(scaled / np.sqrt(dot(scaled, scaled))[:, None])


def excess_distance(excess: FloatArray) -> FloatArray:
    """Signed distance (n,) from the coordinates' excess (n, k) over the solid's half sizes."""
    outside = np.maximum(excess, 0)
    return np.asarray(np.sqrt(dot(outside, outside)) + np.minimum(excess.max(axis=1), 0))


def excess_direction(excess: FloatArray) -> FloatArray:
    """Unit vectors (n, k) along which ``excess_distance`` grows fastest."""
    nearest_face = np.eye(excess.shape[1])[excess.argmax(axis=1)]
    return unit_vectors(np.maximum(excess, 0), nearest_face)


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
    slope = dot(x - np.clip(x, -half, half), d[:, None])
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

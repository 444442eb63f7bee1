"""Convex primitives placed in the world, their signed distance and their distance to segments.

Each is convex, so its signed distance is a convex function of the point
(Boyd and Vandenberghe, Convex Optimization, 2004, section 3.2.5 and exercise 8.5). Two things rest
on that: along a segment it has no local minimum but the global one, and every tangent bounds it
from below. Triangle meshes (:mod:`abi.obstacles.mesh_shape`) need not be convex. Lengths are in the
scene's [unit]; arrays of points are in the world frame unless named body.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Literal

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.pose import Length, Posed, rotation


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...i,...i->...", a, b))


def _unit(vectors: FloatArray, otherwise: FloatArray) -> FloatArray:
    """Unit vectors (n, k) along ``vectors``; ``otherwise``, unit too, where these are zero."""
    largest = np.abs(vectors).max(axis=1, keepdims=True)
    # Scaling first keeps the squares of the smallest vectors from vanishing.
    scaled = np.where(largest > 0, vectors / np.where(largest > 0, largest, 1), otherwise)
    return np.asarray(scaled / np.sqrt(_dot(scaled, scaled))[:, None])


def _excess_distance(excess: FloatArray) -> FloatArray:
    """Signed distance (n,) from the coordinates' excess (n, k) over the solid's half sizes."""
    outside = np.maximum(excess, 0)
    return np.asarray(np.sqrt(_dot(outside, outside)) + np.minimum(excess.max(axis=1), 0))


def _excess_direction(excess: FloatArray) -> FloatArray:
    """Unit vectors (n, k) along which ``_excess_distance`` grows fastest."""
    nearest_face = np.eye(excess.shape[1])[excess.argmax(axis=1)]
    return _unit(np.maximum(excess, 0), nearest_face)


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


class _Primitive(Posed):
    """A convex solid and its pose. Children answer in the body frame, this class in the world."""

    convex: ClassVar[bool] = True

    @abstractmethod
    def _distance(self, x: FloatArray) -> FloatArray:
        """Signed distance (n,) of body points (n, 3)."""

    @abstractmethod
    def _gradient(self, x: FloatArray) -> FloatArray:
        """A unit subgradient (n, 3) of the signed distance at body points (n, 3)."""

    @abstractmethod
    def _nearest_parameter(self, p: FloatArray, d: FloatArray) -> FloatArray:
        """Parameter (n,) in [0, 1] of the least signed distance along p + t d, body (n, 3)."""

    @abstractmethod
    def _half_extents(self, rotation: FloatArray) -> FloatArray:
        """Half extents (3,) of the solid along the world's axes."""

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Low and high corner, each (3,), of the tightest axis-parallel box, [unit], world."""
        half = self._half_extents(rotation(self.wxyz))
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


class Box(_Primitive):
    """A box; ``size`` is its full extent along the body's x, y, z, [unit]."""

    shape: Literal["box"] = "box"
    size: tuple[Length, Length, Length]

    def _distance(self, x: FloatArray) -> FloatArray:
        return _excess_distance(np.abs(x) - np.array(self.size) / 2)

    def _gradient(self, x: FloatArray) -> FloatArray:
        direction = _excess_direction(np.abs(x) - np.array(self.size) / 2)
        return np.copysign(direction, x)

    def _nearest_parameter(self, p: FloatArray, d: FloatArray) -> FloatArray:
        half = np.array(self.size) / 2
        t = _nearest_to_box(p, d, half)
        inside = np.flatnonzero(self._distance(p + t[:, None] * d) <= 0)
        t[inside] = _deepest_in_box(p[inside], d[inside], half)
        return t

    def _half_extents(self, rotation: FloatArray) -> FloatArray:
        return np.asarray(np.abs(rotation) @ (np.array(self.size) / 2))


class _Rounded(_Primitive):
    """All points within ``radius`` of a core, which is a point or a segment of the z axis."""

    radius: Length

    @abstractmethod
    def _core(self) -> FloatArray:
        """Half sizes (3,) of the core."""

    def _distance(self, x: FloatArray) -> FloatArray:
        return _excess_distance(np.abs(x) - self._core()) - self.radius

    def _gradient(self, x: FloatArray) -> FloatArray:
        core = self._core()
        return _unit(x - np.clip(x, -core, core), np.array([1.0, 0.0, 0.0]))

    def _nearest_parameter(self, p: FloatArray, d: FloatArray) -> FloatArray:
        return _nearest_to_box(p, d, self._core())

    def _half_extents(self, rotation: FloatArray) -> FloatArray:
        return np.asarray(np.abs(rotation) @ self._core() + self.radius)


class Sphere(_Rounded):
    """A ball; ``radius`` in [unit]."""

    shape: Literal["sphere"] = "sphere"

    def _core(self) -> FloatArray:
        return np.zeros(3)


class Capsule(_Rounded):
    """A cylinder with round caps along the body's z; ``height`` between the cap centres, [unit]."""

    shape: Literal["capsule"] = "capsule"
    height: Length

    def _core(self) -> FloatArray:
        return np.array([0.0, 0.0, self.height / 2])


class Cylinder(_Primitive):
    """A cylinder with flat ends along the body's z, centred; ``radius``, ``height`` in [unit]."""

    shape: Literal["cylinder"] = "cylinder"
    radius: Length
    height: Length

    def _excess(self, x: FloatArray) -> FloatArray:
        radial = np.hypot(x[:, 0], x[:, 1]) - self.radius
        return np.stack([radial, np.abs(x[:, 2]) - self.height / 2], axis=1)

    def _distance(self, x: FloatArray) -> FloatArray:
        return _excess_distance(self._excess(x))

    def _gradient(self, x: FloatArray) -> FloatArray:
        direction = _excess_direction(self._excess(x))
        radial = _unit(x[:, :2], np.array([1.0, 0.0])) * direction[:, :1]
        return np.concatenate([radial, np.copysign(direction[:, 1:], x[:, 2:])], axis=1)

    def _nearest_parameter(self, p: FloatArray, d: FloatArray) -> FloatArray:
        # Past the rim the minimum is the root of a quartic; bisection on the slope's sign is as
        # exact and needs no case.
        low, high = np.zeros(len(p)), np.ones(len(p))
        for _ in range(50):
            t = (low + high) / 2
            rising = _dot(self._gradient(p + t[:, None] * d), d) > 0
            low, high = np.where(rising, low, t), np.where(rising, t, high)
        return np.asarray((low + high) / 2)

    def _half_extents(self, rotation: FloatArray) -> FloatArray:
        radial = np.hypot(rotation[:, 0], rotation[:, 1])
        return np.asarray(np.abs(rotation[:, 2]) * self.height / 2 + radial * self.radius)


Primitive = Box | Sphere | Cylinder | Capsule

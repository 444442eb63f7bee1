"""Vectors in three dimensions for the kernels: tuples of numbers, which cost nothing to pass.

Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable

Vec3 = tuple[float, float, float]
"""A point or a direction."""
Triangle = tuple[Vec3, Vec3, Vec3]
"""Its corners."""


@jitable
def vec3_at(flat: FloatArray | list[float], i: int) -> Vec3:
    """The three entries of ``flat`` from i."""
    return (flat[i], flat[i + 1], flat[i + 2])


@jitable
def triangle_at(corners: FloatArray, number: int) -> Triangle:
    """The triangle of that number; ``corners`` are nine numbers of each."""
    k = 9 * number
    return vec3_at(corners, k), vec3_at(corners, k + 3), vec3_at(corners, k + 6)


@jitable
def add(a: Vec3, b: Vec3) -> Vec3:
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@jitable
def sub(a: Vec3, b: Vec3) -> Vec3:
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@jitable
def axpy(t: float, x: Vec3, y: Vec3) -> Vec3:
    """t x + y."""
    return (y[0] + t * x[0], y[1] + t * x[1], y[2] + t * x[2])


@jitable
def dot(a: Vec3, b: Vec3) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@jitable
def cross(a: Vec3, b: Vec3) -> Vec3:
    """Vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@jitable
def norm(a: Vec3) -> float:
    """Length."""
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@jitable
def distance(a: Vec3, b: Vec3) -> float:
    """Distance of two points."""
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@jitable
def point_to_box(x: Vec3, boxes: FloatArray, k: int) -> float:
    """Squared distance of a point and the box whose low and high corner are at ``boxes[k:]``."""
    a: float = max(boxes[k] - x[0], x[0] - boxes[k + 3], 0.0)
    b: float = max(boxes[k + 1] - x[1], x[1] - boxes[k + 4], 0.0)
    c: float = max(boxes[k + 2] - x[2], x[2] - boxes[k + 5], 0.0)
    return a * a + b * b + c * c

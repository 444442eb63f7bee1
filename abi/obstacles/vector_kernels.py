"""Vectors of three for the compiled kernels."""

from __future__ import annotations

from numba.extending import register_jitable

from abi.arrays import FloatArray

Vector = tuple[float, float, float]


@register_jitable
def point(flat: FloatArray, i: int) -> Vector:
    """The three entries of ``flat`` from i."""
    return (flat[i], flat[i + 1], flat[i + 2])


@register_jitable
def less(a: Vector, b: Vector) -> Vector:
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@register_jitable
def along(a: Vector, b: Vector, t: float) -> Vector:
    """a + t b."""
    return (a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2])


@register_jitable
def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@register_jitable
def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])

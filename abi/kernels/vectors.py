"""Vectors of three for the compiled kernels.

numba does not see a change here in what it has cached of the kernels that call these: touch those
files too.
"""

from __future__ import annotations

import numba

from abi.arrays import FloatArray

Vector = tuple[float, float, float]


@numba.njit(cache=True, nogil=True)
def point(flat: FloatArray, i: int) -> Vector:
    """The three entries of ``flat`` from i."""
    return (flat[i], flat[i + 1], flat[i + 2])


@numba.njit(cache=True, nogil=True)
def less(a: Vector, b: Vector) -> Vector:
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@numba.njit(cache=True, nogil=True)
def along(a: Vector, b: Vector, t: float) -> Vector:
    """a + t b."""
    return (a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2])


@numba.njit(cache=True, nogil=True)
def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@numba.njit(cache=True, nogil=True)
def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])

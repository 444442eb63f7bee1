"""The smallest capsule around points."""

from __future__ import annotations

import math
from operator import attrgetter
from typing import NamedTuple

import numpy as np
import scipy

from abi.arrays import FloatArray, read_only

_STEPS = 60


class BoundingCapsule(NamedTuple):
    """All points within ``radius`` of a segment, [m].

    Attributes:
        low, high: ends of the segment in the link's frame, shape (3,).
        radius: of the capsule.
    """

    low: FloatArray
    high: FloatArray
    radius: float

    @property
    def volume(self) -> float:
        """Volume, [m³]."""
        length = float(np.linalg.norm(self.high - self.low))
        return math.pi * self.radius**2 * (length + 4 / 3 * self.radius)


def smallest_capsule(points: FloatArray) -> BoundingCapsule:
    """The smallest of the capsules around points along their principal axes."""
    hull = _corners(points)
    capsules = (_capsule_along_axis(hull, axis) for axis in principal_axes(hull))
    return min(capsules, key=attrgetter("volume"))


def _capsule_along_axis(points: FloatArray, axis: FloatArray) -> BoundingCapsule:
    """Capsule along ``axis`` around points (n, 3)."""
    across = points - np.outer(points @ axis, axis)
    centre = across.mean(axis=0)
    # the least circle around them, by steps towards the farthest (Bădoiu and Clarkson, 2003)
    for step in range(1, _STEPS):
        farthest = int(np.einsum("ij,ij->i", across - centre, across - centre).argmax())
        centre = centre + (across[farthest] - centre) / (step + 1)
    radial = np.linalg.norm(across - centre, axis=1)
    radius = float(radial.max())
    cap = np.sqrt(np.maximum(radius**2 - radial**2, 0.0))  # both squares round on their own
    low, high = float((points @ axis + cap).min()), float((points @ axis - cap).max())
    if low > high:
        low = high = (low + high) / 2
    ends = read_only(centre + low * axis), read_only(centre + high * axis)
    return BoundingCapsule(*ends, radius * (1 + 1e-9) + 1e-12)


def principal_axes(points: FloatArray) -> FloatArray:
    """Unit vectors (3, 3), the direction of the largest spread first."""
    return np.asarray(np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2])


def _corners(points: FloatArray) -> FloatArray:
    """Corners of the convex hull; all points where it is flat."""
    try:
        return np.asarray(points[scipy.spatial.ConvexHull(points).vertices])
    except scipy.spatial.QhullError:
        return points

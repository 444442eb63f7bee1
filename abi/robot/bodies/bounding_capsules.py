"""The smallest capsule around points."""

from __future__ import annotations

import math

import numpy as np
import scipy

from abi.arrays import FloatArray, read_only

_STEPS = 60


def smallest_capsule(points: FloatArray) -> tuple[FloatArray, float]:
    """The smallest of the capsules around points (n, 3) along their principal axes.

    Returns:
        Ends of its segment (2, 3), and its radius.
    """
    hull = _corners(points)
    capsules = (_capsule_along_axis(hull, axis) for axis in principal_axes(hull))
    return min(capsules, key=lambda one: capsule_volume(*one))


def capsule_volume(ends: FloatArray, radius: float) -> float:
    """Volume of all that is within a radius of a segment with ends (2, 3)."""
    length = float(np.linalg.norm(ends[1] - ends[0]))
    return math.pi * radius**2 * (length + 4 / 3 * radius)


def _capsule_along_axis(points: FloatArray, axis: FloatArray) -> tuple[FloatArray, float]:
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
    ends = read_only(np.stack([centre + low * axis, centre + high * axis]))
    return ends, radius * (1 + 1e-9) + 1e-12


def principal_axes(points: FloatArray) -> FloatArray:
    """Unit vectors (3, 3), the direction of the largest spread first."""
    return np.asarray(np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2])


def _corners(points: FloatArray) -> FloatArray:
    """Corners of the convex hull; all points where it is flat."""
    try:
        return np.asarray(points[scipy.spatial.ConvexHull(points).vertices])
    except scipy.spatial.QhullError:
        return points

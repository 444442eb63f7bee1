"""Smooth joint-space curves near a path whose edges are proven clear."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import scipy

from abi import arguments
from abi.arm_planning.certificates.chain_certificate import chain_refutation
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arrays import FloatArray, read_only

DEGREE = 4
"""Of the polynomials."""
_ROUNDS = 40
"""Most refinements that bring a curve nearer to its path."""
_SAMPLES = 401
"""Number of samples, between which the joints move straight, when a curve is tested."""


JointSpline: TypeAlias = "scipy.interpolate.BSpline"
"""A clamped uniform B-spline of joint positions on [0, 1]."""


def joint_spline(control_points: FloatArray) -> JointSpline:
    """A clamped uniform B-spline of joint positions on [0, 1].

    It stays in the convex hull of its control points, and so within the joints' limits.

    Args:
        control_points: joint positions (k, n), k > ``DEGREE``, [rad] or [unit].
    """
    inner = np.linspace(0.0, 1.0, len(control_points) - DEGREE + 1)
    return scipy.interpolate.BSpline(
        np.concatenate([[0.0] * DEGREE, inner, [1.0] * DEGREE]), control_points, DEGREE
    )


def sampled(spline: JointSpline) -> FloatArray:
    """Joint positions (m, n) between which the joints move straight when a curve is tested."""
    return read_only(np.asarray(spline(np.linspace(0.0, 1.0, _SAMPLES))))


def _nearer(spline: JointSpline, parameter: float) -> JointSpline:
    """A curve nearer to its control polygon there: the edges that count are halved."""
    points = spline.c
    span = int(np.searchsorted(spline.t, parameter, side="right")) - 1
    last = min(max(span, DEGREE), len(points) - 1)
    edges = np.arange(last - DEGREE, last)
    edges = edges[(points[edges] != points[edges + 1]).any(axis=1)]
    middles = (points[edges] + points[edges + 1]) / 2
    return joint_spline(np.insert(points, edges + 1, middles, axis=0))


Lack = Callable[[JointSpline], float | None]
"""Function that finds a parameter at which a curve misses a requirement; None if it meets all."""


def spline_near(
    space: JointSpace, path: FloatArray, lack: Lack | None = None
) -> JointSpline | None:
    """A smooth curve near a path along which the arm is proven clear; None if none was found.

    Args:
        space: the arm and what it keeps clear of.
        path: joint positions (k, n), k >= 2, whose edges are proven clear, [rad] or [unit].
        lack: finds where a curve that is clear is not near enough to the path all the same.
    """
    path = arguments.numbers("path", path, (-1, len(space.weights)))
    while len(path) <= DEGREE:  # every edge is halved
        middles = (path[1:] + path[:-1]) / 2
        path = np.insert(path, np.arange(1, len(path)), middles, axis=0)
    spline = joint_spline(path)
    for _ in range(_ROUNDS):
        fault = chain_refutation(space.arm, sampled(spline), space.collision_world, space.margin)
        at = None if fault is None else fault.parameter / (_SAMPLES - 1)
        if at is None and lack is not None:
            at = lack(spline)
        if at is None:
            return spline
        spline = _nearer(spline, at)
    return None

"""Smooth joint-space curves near a path whose edges are proven clear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from abi import arguments
from abi.arm_planning.certificates.chain_certificate import chain_refutation
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arrays import FloatArray, ShortRepr, read_only

DEGREE = 4
_ROUNDS = 40
"""Most refinements that bring a curve nearer to its path."""
_SAMPLES = 401
"""Number of samples, between which the joints move straight, when a curve is tested."""


@dataclass(frozen=True, eq=False, repr=False)
class JointSpline(ShortRepr):
    """A clamped uniform B-spline of joint positions on [0, 1].

    It stays in the convex hull of its control points, and so within the joints' limits.

    Attributes:
        control_points: joint positions (k, n), k > degree, [rad] or [unit].
        degree: of its polynomials, at least 1.
    """

    control_points: FloatArray
    degree: int = DEGREE

    def __post_init__(self) -> None:
        points = arguments.numbers("control_points", self.control_points, (-1, -1))
        arguments.integer("degree", self.degree, 1, max(len(points) - 1, 1))
        arguments.keep(self, control_points=points)

    @cached_property
    def knots(self) -> FloatArray:
        """Knots from 0 to 1, (k + degree + 1,)."""
        inner = np.linspace(0.0, 1.0, len(self.control_points) - self.degree + 1)
        return read_only(np.concatenate([[0.0] * self.degree, inner, [1.0] * self.degree]))

    @cached_property
    def _spline(self) -> Any:
        return scipy.interpolate.BSpline(self.knots, self.control_points, self.degree)

    def __call__(self, parameter: FloatArray, order: int = 0) -> FloatArray:
        """Joint positions (m, n) at parameters (m,), or their derivative of that order."""
        return np.asarray(self._spline(parameter, order))

    @cached_property
    def sampled(self) -> FloatArray:
        """Joint positions (k, n) between which the joints move straight when it is tested."""
        return read_only(self(np.linspace(0.0, 1.0, _SAMPLES)))

    def nearer_at(self, parameter: float) -> JointSpline:
        """A curve nearer to its control polygon there: the edges that count are halved."""
        points, p = self.control_points, self.degree
        span = int(np.searchsorted(self.knots, parameter, side="right")) - 1
        last = min(max(span, p), len(points) - 1)
        edges = np.arange(last - p, last)
        edges = edges[(points[edges] != points[edges + 1]).any(axis=1)]
        middles = (points[edges] + points[edges + 1]) / 2
        return JointSpline(np.insert(points, edges + 1, middles, axis=0), p)


Lack = Callable[[JointSpline], float | None]
"""Function that finds a parameter at which a curve misses a requirement; None if it meets all."""


def spline_near(
    space: JointSpace, path: FloatArray, degree: int = DEGREE, lack: Lack | None = None
) -> JointSpline | None:
    """A smooth curve near a path along which the arm is proven clear; None if none was found.

    Args:
        space: the arm and what it keeps clear of.
        path: joint positions (k, n), k >= 2, whose edges are proven clear, [rad] or [unit].
        degree: of the curve.
        lack: finds where a curve that is clear is not near enough to the path all the same.
    """
    path = arguments.numbers("path", path, (-1, len(space.weights)))
    while len(path) <= degree:  # every edge is halved
        middles = (path[1:] + path[:-1]) / 2
        path = np.insert(path, np.arange(1, len(path)), middles, axis=0)
    spline = JointSpline(path, degree)
    for _ in range(_ROUNDS):
        fault = chain_refutation(space.arm, spline.sampled, space.collision_world, space.margin)
        at = None if fault is None else fault.parameter / (_SAMPLES - 1)
        if at is None and lack is not None:
            at = lack(spline)
        if at is None:
            return spline
        spline = spline.nearer_at(at)
    return None

"""Motion of the tool along its curve: where it is, how fast, and in which direction."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from abi import arguments
from abi.arrays import FloatArray
from abi.curves.cubic_profile import PathProfile
from abi.curves.curve import ArcLength, Curve


def tool_motion(
    curve: Curve, arc: ArcLength, profile: PathProfile, time: ArrayLike, order: int = 0
) -> FloatArray:
    """Position, velocity or acceleration of the tool.

    With the unit tangent T and the curvature vector κN of the curve P(u) at the travelled distance
    s(t): velocity = T·s', acceleration = T·s'' + κN·s'². Where the curve rests (P' = 0) T is the
    direction in which it goes on, or by which it came, and κN is taken as 0.

    Args:
        curve: path of the tool, [unit], world.
        arc: its arc length.
        profile: the motion along it.
        time: [s], a number or shape (n,); clamped to the motion.
        order: 0, 1 or 2.

    Returns:
        Shape (3,) for a number, (n, 3) for an array; [unit/s**order], world.

    Raises:
        ValueError: an order above 2.
    """
    order = arguments.integer("order", order, 0, 2)
    times = arguments.number_or_numbers("time", time)
    parameter = arc.parameter(profile(times))
    if order == 0:
        return curve(parameter)
    tangent = _tangent(curve, arc, np.atleast_1d(parameter)).reshape(*times.shape, 3)
    along: FloatArray = tangent * profile(times, order)[..., None]
    if order == 1:
        return along
    first, second = curve(parameter, 1), curve(parameter, 2)
    squared = np.sum(first**2, axis=-1, keepdims=True)
    low, high = curve.interval
    moving = squared * (high - low) ** 2 > (1e-6 * arc.length) ** 2
    across = second - tangent * np.sum(tangent * second, axis=-1, keepdims=True)
    curvature = np.divide(across, squared, out=np.zeros_like(across), where=moving)
    return np.asarray(along + curvature * profile(times, 1)[..., None] ** 2)


def tool_samples(
    curve: Curve, arc: ArcLength, profile: PathProfile, time: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Positions, unit tangents and velocities of the tool at times (n,), [s].

    Returns:
        Each of shape (n, 3); [unit], 1 and [unit/s], world; the tangents are 0 for a point.
    """
    time = arguments.numbers("time", time, (-1,))
    parameter = arc.parameter(profile(time))
    tangent = _tangent(curve, arc, parameter)
    return curve(parameter), tangent, tangent * profile(time, 1)[:, None]


def _tangent(curve: Curve, arc: ArcLength, parameter: FloatArray) -> FloatArray:
    """Unit tangents (n, 3) of a curve at parameters (n,)."""
    direction = curve(parameter, 1)
    size = _lengths(direction)
    low, high = curve.interval
    resting = size * (high - low) <= 1e-6 * arc.length
    if resting.any():
        # A chord of a thousandth of the interval, forwards unless the curve ends before.
        start = np.minimum(parameter[resting], high - 1e-3 * (high - low))
        direction = np.array(direction)
        direction[resting] = curve(start + 1e-3 * (high - low)) - curve(start)
        size = _lengths(direction)
    return np.asarray(direction / np.where(size > 0, size, 1)[:, None])


def _lengths(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("ni,ni->n", vectors, vectors)))

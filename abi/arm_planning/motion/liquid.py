"""Tilt of the liquid in a cup carried by the tool."""

from __future__ import annotations

import numpy as np

from abi import arguments
from abi.arm_planning.motion.tool_motion import tool_motion
from abi.arrays import FloatArray
from abi.curves.cubic_profile import PathProfile
from abi.curves.curve import ArcLength, Curve
from abi.obstacles.pose import METRES
from abi.robot.kinematics.inverse_dynamics import GRAVITY

_SAMPLES, _NEAR = 801, 65
"""Numbers of times along the whole motion, and around the worst one."""


def largest_tilt(curve: Curve, arc: ArcLength, profile: PathProfile, unit: str) -> float:
    """Largest tilt of a liquid's surface in a cup that is held upright, [rad].

    The surface is perpendicular to the gravity felt in the cup, g minus the cup's acceleration, so
    it tilts by the angle between that and the vertical. Sloshing is ignored.

    Args:
        curve: path of the tool, [unit].
        arc: its arc length.
        profile: the motion along it.
        unit: of lengths.
    """
    even = np.linspace(0.0, profile.duration, _SAMPLES)
    # a tight bend may pass between two of these, but not between the Gauss points of the curve
    bends = np.interp(arc.passed, profile(even), even)
    # just before the acceleration jumps, too
    jumps = np.concatenate([profile.jumps, np.nextafter(profile.jumps, 0.0)])
    times = np.unique(np.concatenate([even, bends, jumps]))
    found = tilts(tool_motion(curve, arc, profile, times, 2), unit)
    worst = int(found.argmax())
    before, after = times[max(worst - 1, 0)], times[min(worst + 1, len(times) - 1)]
    near = np.linspace(before, after, _NEAR)
    return float(max(found[worst], tilts(tool_motion(curve, arc, profile, near, 2), unit).max()))


def tilts(accelerations: FloatArray, unit: str) -> FloatArray:
    """Tilt of the surface at accelerations (n, 3) of the cup, [unit/s²], z up; (n,), [rad]."""
    accelerations = arguments.points("accelerations", accelerations)
    x, y, z = accelerations.T * METRES[unit]
    return np.asarray(np.arctan2(np.hypot(x, y), GRAVITY + z))

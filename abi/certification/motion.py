"""A motion that was planned elsewhere: joint positions at waypoints."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, ShortRepr
from abi.certification.stated_object import StatedObject
from abi.errors import AbiError, short

MOST_WAYPOINTS = 20_000
"""Largest number of waypoints of a motion."""
_LARGEST = 1e6
_LEAST_STEP = 5e-10
"""Between two waypoints, [s]: messages count nanoseconds."""
_ONE = {"positions": "position", "velocities": "velocity", "accelerations": "acceleration"}

Interpolation = Literal["linear", "cubic", "quintic"]


class RobotState(NamedTuple):
    """Where a motion's file says that the robot stands before it.

    Attributes:
        joints: positions by name, also of joints that the motion does not move, [rad] or [m].
        objects: that it holds by a message; None if the file does not say what is held.
        base: where its root stands in the world, x, y, z [m], and its quaternion x, y, z, w; None
            if that is not said.
        root: name of the link that stands there, empty for the root of its file; None if that is
            not said.
        attached: unit of length of a scene, and the object that it holds, as that has it; None if
            no scene says so.
        rests: whether joints that are not named rest nearest to 0.
        tip: name of the link of its scene's tool, which holds that object; None for the usual one.
        obstacles: how many its scene has; 0 if it is of none.
    """

    joints: Mapping[str, float]
    objects: tuple[StatedObject, ...] | None = None
    base: tuple[float, ...] | None = None
    root: str | None = None
    attached: tuple[str, Mapping[str, Any]] | None = None
    rests: bool = False
    tip: str | None = None
    obstacles: int = 0


@dataclass(frozen=True, eq=False, repr=False)
class Motion(ShortRepr):
    """Positions of n joints at m >= 2 waypoints, and their derivatives if they are known.

    Attributes:
        joints: names of the joints.
        times: of the waypoints, (m,), increasing, [s]; their numbers from 0 if no time is known.
        positions: shape (m, n), [rad], of sliding joints [m].
        velocities: shape (m, n), [rad/s] or [m/s]; None if they are not known.
        accelerations: shape (m, n), [rad/s²] or [m/s²]; None if they are not known.
        timed: whether ``times`` are in seconds.
        notes: sentences on how the file was read.
        start: of the robot, as far as the file says.

    Raises:
        AbiError: fewer than two waypoints, a joint named twice, another number of values than
            joints, a number that is not finite, times that do not increase, or velocities without
            times, which leave open how the joints get from one waypoint to the next.
    """

    joints: tuple[str, ...]
    times: FloatArray
    positions: FloatArray
    velocities: FloatArray | None = None
    accelerations: FloatArray | None = None
    timed: bool = True
    notes: tuple[str, ...] = ()
    start: RobotState = field(default=RobotState({}))

    def __post_init__(self) -> None:
        _check_names(self.joints)
        named = ("times", "positions", "velocities", "accelerations")
        given = {name: getattr(self, name) for name in named}
        arguments.keep(
            self, **{name: _array(name, one) for name, one in given.items() if one is not None}
        )
        rows = len(self.times)
        if not 2 <= rows <= MOST_WAYPOINTS:
            raise AbiError(
                f"The motion has {rows} waypoint{'s' * (rows != 1)}.",
                f"Give 2 to {MOST_WAYPOINTS:,} of them.",
            )
        for name in ("positions", "velocities", "accelerations"):
            values = getattr(self, name)
            if values is not None:
                self._check(name, values)
        if self.accelerations is not None and self.velocities is None:
            raise AbiError("The motion has accelerations but no velocities.", "Give both.")
        if self.velocities is not None and not self.timed:
            raise AbiError(
                "The motion has velocities but no times, so how its joints get from one waypoint "
                "to the next is not known.",
                "Give the times in seconds, or positions alone.",
            )
        self._check_times()

    @property
    def interpolation(self) -> Interpolation:
        """How the joints move between waypoints, as ROS 2's joint trajectory controller has it.

        Straight where only positions are known, by cubic polynomials with velocities, too, and by
        quintic ones with accelerations.
        """
        if self.velocities is None:
            return "linear"
        return "cubic" if self.accelerations is None else "quintic"

    def to_dict(self) -> dict[str, Any]:
        """The motion as plain data, as its own reader takes it."""
        named = ("times", "positions", "velocities", "accelerations")
        tables = {name: getattr(self, name) for name in named}
        return {
            "joints": list(self.joints),
            "timed": self.timed,
            **{name: None if one is None else one.tolist() for name, one in tables.items()},
        }

    def from_zero(self) -> Motion:
        """The motion with its first waypoint at 0 s, wherever its times count from."""
        first = float(self.times[0])
        if first == 0:
            return self
        note = f"Times count from the first waypoint, which the file has at {first:.6g} s."
        return replace(self, times=self.times - first, notes=(*self.notes, note))

    def _check(self, name: str, values: FloatArray) -> None:
        """Raise where values (m, n) of the joints are not finite numbers of that shape."""
        if values.shape != (len(self.times), len(self.joints)):
            raise AbiError(
                f"The motion's {name} are of shape {values.shape}, not one number for each of its "
                f"{len(self.times)} waypoints and {len(self.joints)} joints."
            )
        wrong = ~(np.abs(values) <= _LARGEST)
        if wrong.any():
            row, joint = (int(k) for k in np.argwhere(wrong)[0])
            raise AbiError(
                f"In row {row + 1} the {_ONE[name]} of {self.joints[joint]} is "
                f"{values[row, joint]:g}, not a number up to {_LARGEST:g}.",
            )

    def _check_times(self) -> None:
        times = self.times
        if times.shape != (len(times),) or not np.isfinite(times).all():
            row = int(np.flatnonzero(~np.isfinite(times.reshape(-1)))[0]) if times.ndim == 1 else 0
            raise AbiError(f"In row {row + 1} the time is no number of seconds.")
        late = np.flatnonzero(np.diff(times) < _LEAST_STEP)
        if len(late):
            row = int(late[0]) + 1
            raise AbiError(
                f"Times must increase: row {row + 1} is at {times[row]:.9g} s, and row {row} at "
                f"{times[row - 1]:.9g} s.",
                "Remove the row, or correct its time.",
            )


def _array(name: str, values: Any) -> FloatArray:
    """Values as an array of numbers, not yet checked otherwise; times may be numpy's or pandas'."""
    with suppress(TypeError, ValueError, OverflowError):
        array = np.asarray(values)
        if name == "times" and array.dtype.kind == "m":
            array = array / np.timedelta64(1, "s")
        numbers = array.dtype.kind in "fiu" or (
            array.dtype.kind == "O"
            and all(
                isinstance(one, int | float) and not isinstance(one, bool) for one in array.flat
            )
        )
        if numbers and not np.ma.is_masked(values):
            return np.ascontiguousarray(array, dtype=np.float64)
    raise AbiError(f"The motion's {name} are {short(values)}, which are no numbers.")


def _check_names(joints: tuple[str, ...]) -> None:
    """Raise where a joint has no name, or is named twice."""
    if not joints or not all(isinstance(name, str) and name for name in joints):
        raise AbiError("The motion does not name its joints.", "Give the name of each.")
    name, count = Counter(joints).most_common(1)[0]
    if count > 1:
        raise AbiError(f"The motion names the joint {name} {count} times.", "Name each joint once.")

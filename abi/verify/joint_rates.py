"""Check that a motion keeps the limits of its joints' speeds and accelerations.

They are differences of its samples, here in exact numbers.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from abi.scene.scene import Scene
from abi.verify.exact.chain import ExactChain
from abi.verify.fault import Fault
from abi.verify.plan_fields import finite, list_of, mapping, number_of

_LET_PASS = Fraction(1001, 1000)
"""Factor by which differences may be larger than a limit, as :mod:`abi.arm_planning.motion_law` has
it."""
_ROUNDED = Fraction(1, 1 << 46)
"""Accepted rounding error of a position, over the largest and 1; of a limit, over itself."""
_PASSED = "arm.limits_passed"


def check_rates(
    section: dict[str, Any],
    duration: float,
    rows: Sequence[Sequence[Fraction]],
    chain: ExactChain,
    scene: Scene,
) -> None:
    """Check the stated limits, and that no joint passes one without a word.

    Args:
        section: the plan's ``arm``.
        duration: of the motion, [s].
        rows: positions of the joints at all samples, evenly in time, (m, n), [rad] or [unit].
        chain: the joints.
        scene: with the robot, and the acceleration that it asks for.

    Raises:
        Fault: another limit is stated, or a joint passes one.
        SceneError: a field has the wrong form.
    """
    speeds = {joint.name: joint.speed for joint in scene.robot.joints}
    told = dict(map(_told, list_of(_PASSED, section.get("limits_passed"))))
    step = Fraction(duration) / (len(rows) - 1)
    columns, count = [*zip(*rows, strict=True)], len(chain.coordinates)
    units = [chain.units if slides else Fraction(1) for slides in chain.slides]
    asked = Fraction(scene.motion.joint_acceleration)
    for number, (name, unit, column) in enumerate(
        zip(chain.coordinates, units, columns, strict=True)
    ):
        speed = number_of(speeds[name])
        limits = {"speed": None if speed is None else speed * unit, "acceleration": asked * unit}
        error = _ROUNDED * max(1, *map(abs, column))
        steps = max(abs(after - before) for before, after in itertools.pairwise(column))
        ways = {"speed": steps, "acceleration": _largest_turn(column)}
        fastest = _stated(section, "peak_joint_speed", number, count)
        if fastest is not None and fastest * step > (steps + 2 * error) * _LET_PASS:
            raise Fault(f"the speed of {name} is nowhere as large as its stated peak")
        for quantity, limit in limits.items():
            order = 1 if quantity == "speed" else 2
            _check_stated(section, f"joint_{quantity}_limits", number, count, limit)
            peak = _stated(section, f"peak_joint_{quantity}", number, count)
            way = ways[quantity] - 2 * order * error
            if peak is not None and way > peak * step**order * _LET_PASS:
                raise Fault(f"the {quantity} of {name} is larger than its stated peak")
            most = told.get((name, quantity), limit)
            if most is not None and way > most * step**order * _LET_PASS:
                raise Fault(f"{name} passes its limit of {quantity} farther than is told")


def _told(entry: Any) -> tuple[tuple[object, object], Fraction]:
    """Joint and quantity of a limit that is said to be passed, and the value there."""
    one = mapping(_PASSED, entry)
    return (one.get("joint"), one.get("quantity")), abs(
        Fraction(finite(f"{_PASSED}.value", one.get("value")))
    )


def _largest_turn(column: Sequence[Fraction]) -> Fraction:
    """Largest second difference, and the ways beside both ends, where joints are at rest.

    An acceleration from rest is twice such a way; half of that is asked, as it may grow less.
    """
    parts = zip(column, column[1:], column[2:], strict=False)
    inner = (abs(after - 2 * here + before) for before, here, after in parts)
    return max(abs(column[1] - column[0]), abs(column[-1] - column[-2]), *inner)


def _stated(section: dict[str, Any], name: str, number: int, count: int) -> Fraction | None:
    """A number for a joint, of so many; None where there is none."""
    values = list_of(f"arm.{name}", section.get(name))
    if len(values) != count:
        raise Fault(f"its joints have not one number each in {name}")
    value = values[number]
    return None if value is None else Fraction(finite(f"arm.{name}", value))


def _check_stated(
    section: dict[str, Any], name: str, number: int, count: int, limit: Fraction | None
) -> None:
    """Raise where a stated limit of a joint is another than the robot or the scene has."""
    stated = _stated(section, name, number, count)
    if (stated is None) != (limit is None) or (
        stated is not None and limit is not None and abs(stated - limit) > _ROUNDED * limit
    ):
        raise Fault(f"{name} are not those of the robot and the scene")

"""Exceptions of the package.

::

    AbiError
    ├── ArgumentError     a function was called with what it does not take
    │   └── SceneError    the input is not a scene: names the field, the value and what would work
    └── StageError        the scene is valid but a stage has no result; ends the chain of stages
        └── those of the arm, in ``arm_planning/arm_errors.py``

Where sentences about a plan are chosen and put together for the page is ``explain``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any, Self

import numpy as np

from abi.arrays import FloatArray, IntArray, lock, read_only
from abi.length_text import format_setting, with_minus

UNIT = " [unit]"
"""Placeholder after every length in a sentence until the unit is known."""


class AbiError(Exception):
    """Base class of all errors of this package; ``str(error)`` is one sentence for the user.

    Attributes:
        message: what is wrong, in one sentence.
        hint: what to try, in one sentence; empty if there is no advice.
        choices: names of the first of several robots or trajectories in a file, of which one is to
            be named; empty where something else is wrong.
    """

    def __init__(self, message: str, hint: str = "", choices: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint
        self.choices = choices

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy by attributes, since the errors' arguments differ from those of an exception."""
        return _of_kind, (type(self), self.args, vars(self))


class Described:
    """Stands in an error for a value of which its ``repr`` says nothing: that is ``text``."""

    def __init__(self, text: str) -> None:
        self._text = text

    def __repr__(self) -> str:
        return self._text


MISSING = Described("missing")
"""Stands for a value that was not given."""


class ArgumentError(AbiError):
    """Error for a wrong argument of a function.

    Args:
        field: name of the argument, or of the part of it that is wrong.
        value: the value given.
        expected: end of the sentence "expected …", which says what would work.
    """

    def __init__(self, field: str, value: object, expected: str) -> None:
        super().__init__(f"{field} is {short(value)}; expected {expected}.")
        self.field = field
        self.value = value
        self.expected = expected


class SceneError(ArgumentError):
    """Error for a wrong field of a scene; the name is, for example, ``obstacles[0].size``."""


class StageError(AbiError):
    """Error of a stage that has no result for a valid scene; kept in ``plan.error``.

    Args:
        stage: name of the stage: mesh, graph, search, bspline, quadratic, timing or arm.
        kind: a short identifier that scripts can compare.
        message: one sentence on what is wrong.
        hint: one sentence on what to try.
        obstacle: index of the obstacle that is in the way, from 0, or the name of what else is;
            None if it is no single one.

    Attributes:
        reached: of :func:`no_path` ids of the nodes that the start can reach, shape (k,); else
            none.
    """

    reached: IntArray = read_only(np.zeros(0, dtype=np.int32))

    def __init__(
        self, stage: str, kind: str, message: str, hint: str, obstacle: int | str | None = None
    ) -> None:
        self._sentences = message, hint
        super().__init__(*in_unit(self._sentences, ""))
        self.stage = stage
        self.kind = kind
        self.obstacle = obstacle

    def in_unit(self, unit: str) -> Self:
        """A copy with the unit after the lengths in message and hint."""
        copy = type(self).__new__(type(self))
        copy.__dict__.update(self.__dict__)
        copy.message, copy.hint = in_unit(self._sentences, unit)
        copy.args = (copy.message,)
        return copy

    def renumbered(self, number: Callable[[int], int]) -> Self:
        """A copy whose sentences, and ``obstacle``, count obstacles as another scene does.

        Args:
            number: the number there, from 0, of an obstacle by its number here.
        """

        def again(sentence: str) -> str:
            parts = re.split(r"(?<=\bobstacle )(\d+)", sentence)
            parts[1::2] = (str(number(int(one) - 1) + 1) for one in parts[1::2])
            return "".join(parts)

        copy = type(self).__new__(type(self))
        copy.__dict__.update(self.__dict__)
        message, hint = self._sentences
        copy._sentences = again(message), again(hint)
        copy.message, copy.hint = again(self.message), again(self.hint)
        copy.args = (copy.message,)
        if isinstance(self.obstacle, int):
            copy.obstacle = number(self.obstacle)
        return copy


NO_PATH = "no_path"
"""Kind of :func:`no_path`."""


def no_path(reached: IntArray, total: int, pitch: float) -> StageError:
    """Error if no free edges join start and goal.

    Args:
        reached: ids of the nodes that the start can reach, shape (k,).
        total: number of nodes that are not excluded, start and goal included.
        pitch: pitch of the mesh, [unit].
    """
    error = StageError(
        "search",
        NO_PATH,
        f"No path: the start reaches {len(reached):,} of the graph's {total:,} nodes, and the "
        "goal is not among them.",
        "Move an obstacle out of the way, lower the clearance, or put nodes nearer than "
        f"{format_length(pitch)} to each other if there is a gap.",
    )
    error.reached = read_only(np.array(reached))
    return error


BLOCKED = ("start_blocked", "goal_blocked")
"""Kinds of :func:`point_blocked`."""


def point_blocked(
    which: str,
    obstacle: int,
    distance: float,
    clearance: float,
    nearest: FloatArray | None,
) -> StageError:
    """Error if start or goal is inside an obstacle or nearer to it than the clearance.

    Args:
        which: ``start`` or ``goal``.
        obstacle: index in the scene's list, from 0.
        distance: signed distance of the point to that obstacle, [unit]; negative inside.
        clearance: the clearance required, [unit].
        nearest: the nearest free point found, shape (3,), [unit], world; None when there is none.
    """
    name = f"obstacle {obstacle + 1}"
    place = (
        f"{format_length(-distance)} inside {name}"
        if distance < 0
        else f"only {format_length(distance)} from {name}, "
        f"the clearance is {format_length(clearance)}"
    )
    hint = "Move it out of the obstacle" + (", or lower the clearance" if clearance else "")
    if nearest is not None:
        hint += f"; the nearest free point is {format_point(np.round(nearest, 2))}"
    return StageError("graph", f"{which}_blocked", f"The {which} is {place}.", f"{hint}.", obstacle)


NOT_HELD = "clearance_not_held"
"""Kind of :func:`clearance_not_held`."""


def clearance_not_held(clearance: float, reached: float) -> StageError:
    """Error for a curve that could not be kept clear of the obstacles.

    Args:
        clearance: the clearance required, [unit].
        reached: the best distance proven, [unit]; negative when the curve enters an obstacle.
    """
    lack = max(clearance - reached, 0.0)
    fault = f"lacks {format_length(lack)}"
    if reached < 0:
        fault = f"enters an obstacle by {format_length(-reached)}"
    return StageError(
        "bspline",
        NOT_HELD,
        "The B-spline is not proven to keep the clearance of "
        f"{format_length(clearance)}: it {fault}.",
        "Lower the clearance or the degree, or make the node spacing finer.",
    )


def _of_kind(
    kind: type[AbiError], arguments: tuple[object, ...], attributes: dict[str, object]
) -> AbiError:
    """A copy of an error; see :meth:`AbiError.__reduce__`."""
    copy = kind.__new__(kind, *arguments)
    lock(attributes.values())
    copy.__dict__.update(attributes)
    return copy


def short(value: object) -> str:
    """Text of a value, shortened in the middle if it is long."""
    try:
        text = repr(value)
    except ValueError:  # a whole number, or one in the value, has more digits than Python writes
        holder = "" if isinstance(value, int) else f"{type(value).__name__} with a "
        return f"a {holder}number of thousands of digits"
    return text if len(text) <= 90 else f"{text[:40]} … {text[-40:]}"


def format_length(length: float) -> str:
    """Text of a length, with the placeholder of its unit."""
    return f"{format_setting(length, digits=3)}{UNIT}"


def format_point(point: Sequence[float] | FloatArray) -> str:
    """Text of a point, with the placeholder of its unit."""
    x, y, z = (number + 0.0 for number in point)  # a zero has no sign
    return with_minus(f"({x:g}, {y:g}, {z:g})") + UNIT


def in_unit(sentences: tuple[str, str], unit: str) -> tuple[str, str]:
    """Message and hint with ``unit`` after every length, or without units if it is empty."""
    message, hint = (text.replace(UNIT, f" {unit}" if unit else "") for text in sentences)
    return message, hint

"""Exceptions of the package.

::

    AbiError
    ├── ArgumentError     a function was called with what it does not take
    │   └── SceneError    the input is not a scene: names the field, the value and what would work
    ├── MotionError       a motion to certify is not one of the robot: names row, joint and unit
    ├── ExportError       a format cannot hold the plan, or the file cannot be written
    └── StageError        the scene is valid but a stage has no result; ends the chain of stages
        ├── PointBlocked      start or goal lies inside an obstacle or its clearance
        ├── NoPath            no path joins start and goal on this mesh
        ├── ClearanceNotHeld  a curve could not be kept clear of the obstacles
        ├── OutOfReach        the paper's arm cannot follow the curve all the way
        ├── NotFollowed       an arm that a URDF describes cannot follow it
        ├── ArmNotClear       no motion was found on which the whole arm keeps clear
        ├── TooSlow           the joints' limits make the motion many times as long as it should be
        └── TooManySamples    the time step is too small for the motion
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np

from abi.arrays import FloatArray, IntArray, lock, read_only
from abi.length_text import format_setting, with_minus

UNIT = " [unit]"
"""Placeholder after every length in a sentence, until the unit is known."""


class AbiError(Exception):
    """Base class of all errors of this package; ``str(error)`` is one sentence for people.

    Attributes:
        message: what is wrong, in one sentence.
        hint: what to try, in one sentence; empty if there is no advice.
    """

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy by attributes: the arguments of a kind of error are not those of an exception."""
        return _of_kind, (type(self), self.args, vars(self))


class Missing:
    """Stands in an error for a value that was not given."""

    def __repr__(self) -> str:
        return "missing"


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


class MotionError(AbiError):
    """Error for a motion that cannot be certified because it is wrong or incomplete.

    Args:
        message: one sentence that names row, joint and unit where they matter.
        hint: what would work, in one sentence.
        row: number of the waypoint from 1; None if it is no single one.
        joint: name of the joint; empty if it is no single one.
    """

    def __init__(
        self, message: str, hint: str = "", row: int | None = None, joint: str = ""
    ) -> None:
        super().__init__(message, hint)
        self.row = row
        self.joint = joint


class SeveralTrajectoriesError(MotionError):
    """Error for a bag with several trajectories, of which one is to be named.

    Args:
        message: how many there are.
        hint: how one is named.
        choices: names of the first of them.
    """

    def __init__(self, message: str, hint: str, choices: tuple[str, ...]) -> None:
        super().__init__(message, hint)
        self.choices = choices


class ExportError(AbiError):
    """Error for a plan that a file format cannot hold, or a file that cannot be written."""


class StageError(AbiError):
    """Error of a stage that has no result for a valid scene; a plan keeps it in ``plan.error``.

    Args:
        stage: name of the stage: mesh, graph, search, bspline, quadratic, timing or arm.
        kind: a short identifier that scripts can compare.
        message: one sentence on what is wrong.
        hint: one sentence on what to try.
    """

    def __init__(self, stage: str, kind: str, message: str, hint: str) -> None:
        self._sentences = message, hint
        super().__init__(*in_unit(self._sentences, ""))
        self.stage = stage
        self.kind = kind

    def in_unit(self, unit: str) -> Self:
        """A copy with the unit after the lengths in message and hint."""
        copy = type(self).__new__(type(self))
        copy.__dict__.update(self.__dict__)
        copy.message, copy.hint = in_unit(self._sentences, unit)
        copy.args = (copy.message,)
        return copy


class PointBlocked(StageError):
    """Error if start or goal is inside an obstacle or nearer to it than the clearance.

    Args:
        which: ``start`` or ``goal``.
        obstacle: index in the scene's list, from 0.
        distance: signed distance of the point to that obstacle, [unit]; negative inside.
        clearance: the clearance required, [unit].
        nearest: the nearest free point found, shape (3,), [unit], world; None when there is none.
    """

    def __init__(
        self,
        which: str,
        obstacle: int,
        distance: float,
        clearance: float,
        nearest: FloatArray | None,
    ) -> None:
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
        super().__init__("graph", f"{which}_blocked", f"The {which} is {place}.", f"{hint}.")
        self.which = which
        self.obstacle = obstacle
        self.distance = distance
        self.nearest = nearest


class NoPath(StageError):
    """Error if no free edges join start and goal.

    Args:
        reached: ids of the nodes that the start can reach, shape (k,).
        total: number of nodes that are not excluded, start and goal included.
        pitch: pitch of the mesh, [unit].
    """

    def __init__(self, reached: IntArray, total: int, pitch: float) -> None:
        super().__init__(
            "search",
            "no_path",
            f"No path: the start reaches {len(reached):,} of the graph's {total:,} nodes, and the "
            "goal is not among them.",
            "Move an obstacle out of the way, lower the clearance, or put nodes nearer than "
            f"{format_length(pitch)} to each other if there is a gap.",
        )
        self.reached = read_only(np.array(reached))
        self.total = total


class ClearanceNotHeld(StageError):
    """Error for a curve that could not be kept clear of the obstacles.

    Args:
        clearance: the clearance required, [unit].
        reached: the best distance proven, [unit]; negative when the curve enters an obstacle.
    """

    def __init__(self, clearance: float, reached: float) -> None:
        lack = max(clearance - reached, 0.0)
        fault = f"lacks {format_length(lack)}"
        if reached < 0:
            fault = f"enters an obstacle by {format_length(-reached)}"
        super().__init__(
            "bspline",
            "clearance_not_held",
            "The B-spline is not proven to keep the clearance of "
            f"{format_length(clearance)}: it {fault}.",
            "Lower the clearance or the degree, or make the node spacing finer.",
        )
        self.clearance = clearance
        self.reached = reached


class OutOfReach(StageError):
    """Error for a stretch of the curve that the arm cannot reach.

    Args:
        first: time of the first point out of reach, [s].
        last: time of the last point out of reach, [s].
        shortfall: the largest distance missing, [unit].
        too_near: True when the worst point is too near to the shoulder rather than too far.
        slide: extension of the slide q5 at that time and its limit, [unit], if it is past the limit
            and so makes the forearm too long or too short.
    """

    def __init__(
        self,
        first: float,
        last: float,
        shortfall: float,
        too_near: bool,
        slide: tuple[float, float] | None = None,
    ) -> None:
        place = "too near to the shoulder" if too_near else "too far away"
        hint = (
            "Move the base away from the curve, or make the upper arm as long as forearm and slide "
            "together."
            if too_near
            else "Move the base nearer, or lengthen upper arm, forearm or slide."
        )
        if slide is not None:
            extension, limit = slide
            hint = (
                f"The slide would run to {format_length(extension)}, and it ends at "
                f"{format_length(limit)}: go faster, or set the slide's force to 0."
            )
        super().__init__(
            "arm",
            "out_of_reach",
            f"The arm cannot reach the curve from {first:.2f} s to {last:.2f} s: it is {place}, "
            f"by up to {format_length(shortfall)}.",
            hint,
        )
        self.first = first
        self.last = last
        self.shortfall = shortfall
        self.slide = slide


class LinkContact(NamedTuple):
    """What a link's shapes, as they are given, do where the convex pieces around it come too near.

    Attributes:
        touches: whether they touch the other.
        depth: how far they are in it, at least, [unit].
        distance: from it, at most, [unit], where they do not touch.
        clearance: distance that is to be kept from it, [unit].
    """

    touches: bool
    depth: float
    distance: float
    clearance: float


def _touched(
    link: str, obstacle: int | str, contact: LinkContact | None, at: str = "", exact: bool = False
) -> str:
    """Clause on a link that is in the way at start or goal.

    Args:
        link: its name.
        obstacle: index of what it touches, from 0, or its name.
        contact: of its shapes; None where that is not known.
        at: where that is, to stand behind the name of the obstacle.
        exact: whether what is known without ``contact`` is of the link itself.
    """
    name = f"obstacle {obstacle + 1}" if isinstance(obstacle, int) else f"the {obstacle}"
    name, link = f"{name}{at}", f"the {link.replace('_', ' ')}"
    if contact is None:
        return f"{link} {'touches' if exact else 'may touch'} {name}"
    if contact.touches:
        deep = f", {format_length(contact.depth)} deep" if contact.depth > 0 else ""
        return f"{link} touches {name}{deep}"
    away = f"{link} does not touch {name}"
    if contact.distance < contact.clearance:
        asked = f"the clearance is {format_length(contact.clearance)}"
        return f"{away} but is at most {format_length(contact.distance)} from it, {asked}"
    at_most = f", at most {format_length(contact.distance)} away" if contact.distance > 0 else ""
    return f"{away}{at_most}, but the convex pieces that contain it come too near"


class ArmNotClear(StageError):
    """Error if no motion was found on which the whole arm is proven clear; the tool has one.

    Args:
        branch: branch of the arm that was searched, as the beginning of a sentence.
        where: ``start`` or ``goal`` if the arm is not clear there; ``path`` if the mesh has no
            clear path; ``curve`` if no curve near the path is clear.
        link: link that is in the way at start or goal; empty if the arm is out of reach there.
        obstacle: index of what it touches, from 0, or its name; None if out of reach.
        sentences: message to use instead of the one that follows from the other arguments.
        has_elbow: whether the branches are the two sides of an elbow.
        why: why start or goal cannot be taken, with joint, limit or distance, as a predicate.
        contact: whether the link itself touches that; None where it is not known.
    """

    def __init__(
        self,
        branch: str,
        where: str,
        link: str = "",
        obstacle: int | str | None = None,
        sentences: str = "",
        has_elbow: bool = True,
        why: str = "",
        contact: LinkContact | None = None,
    ) -> None:
        message = {
            "path": f"{branch}, no path was found that keeps the whole arm clear.",
            "curve": f"{branch}, the arm is clear along a path, but it is not proven "
            "clear along any curve found near it.",
        }.get(where)
        if message is None:
            fault = f"the arm cannot reach the {where} within its joint limits"
            if why:
                fault = f"the arm {why} at the {where}"
            if obstacle is not None:
                # bodies of other arms than the paper's are a little larger than their links
                fault = _touched(link, obstacle, contact, f" at the {where}", has_elbow)
            message = f"{branch}, {fault}."
        other = "let the elbow be auto" if has_elbow else "leave the direction of the gripper free"
        super().__init__(
            "arm",
            "arm_not_clear",
            sentences or message,
            "The plan shown is for the tool tip alone. Move an obstacle or the arm's base, or "
            f"{other}.",
        )
        self.branch = branch
        self.where = where
        self.link = link
        self.obstacle = obstacle
        self.has_elbow = has_elbow

    @classmethod
    def of_all(
        cls, faults: Sequence[ArmNotClear], others: Sequence[ArmNotClear] = (), note: str = ""
    ) -> ArmNotClear:
        """Combine the errors of all branches; for start poses, the one that got farthest counts.

        Args:
            faults: errors of the branches, at least one.
            others: errors of branches with redundant joints drawn elsewhere.
            note: sentence on why there are no such branches.
        """
        order = ("start", "goal", "path", "curve")
        first = faults[0]
        text = " ".join(fault._sentences[0] for fault in faults)
        if not first.has_elbow:
            first = max((*faults, *others), key=lambda fault: order.index(fault.where))
            tried = ""
            if len(faults) > 1 or others:
                poses = "one pose" if len(faults) == 1 else f"{len(faults)} poses"
                tried = f"The arm was tried from {poses} at the start"
            if others:
                ways = "one other way" if len(others) == 1 else f"{len(others)} other ways"
                tried += f", and held in {ways}"
            text = " ".join(filter(None, (f"{tried}." if tried else "", first._sentences[0], note)))
        return cls(first.branch, first.where, first.link, first.obstacle, text, first.has_elbow)

    def nor_in_joints(self, fault: NoJointMotion) -> ArmNotClear:
        """A copy whose text adds why there is no motion in the space of the joints, either."""
        text = " ".join(self._sentences[:1] + fault._sentences[:1])
        return ArmNotClear(self.branch, self.where, self.link, self.obstacle, text, self.has_elbow)

    def along_tool(self, touched: str) -> ArmNotClear:
        """A copy whose text adds what the arm touches along the curve of the tool alone."""
        text = f"{self._sentences[0]} Along the curve of the tool tip alone {touched}."
        return ArmNotClear(self.branch, self.where, self.link, self.obstacle, text, self.has_elbow)


class NoJointMotion(StageError):
    """Error if no motion of the arm was found in the space of its joints.

    Args:
        where: ``start`` or ``goal`` if the arm has no clear pose there, ``path`` if the search has
            found none in its time, ``curve`` if no smooth curve near its path is clear, ``same`` if
            the joints are at the goal already.
        link: link that is in the way at start or goal; empty if no pose was found there.
        obstacle: index of what it touches, from 0, or its name.
        poses: number of poses that were tried there.
        samples: number of random positions that were searched towards.
        contact: whether the link itself touches that; None where it is not known.
    """

    def __init__(
        self,
        where: str,
        link: str = "",
        obstacle: int | str | None = None,
        poses: int = 0,
        samples: int = 0,
        contact: LinkContact | None = None,
    ) -> None:
        message = {
            "path": "No motion was found in the space of the joints, towards "
            f"{samples:,} random positions of them.",
            "curve": "A path was found in the space of the joints, but no smooth curve near it "
            "along which the arm is proven clear.",
            "same": "The joints are at the goal already.",
        }.get(where)
        if message is None:
            message = f"No joint positions were found for what is asked at the {where}."
            if obstacle is not None:
                tried = "In the first of the" if poses > 1 else "In the"
                poses_there = f"{poses} poses found" if poses > 1 else "pose asked for"
                touched = _touched(link, obstacle, contact)
                message = f"{tried} {poses_there} at the {where} {touched}."
        hint = "Move an obstacle or the arm's base, or ask for another start or goal."
        super().__init__("arm", "no_joint_motion", message, hint)
        self.where = where


class DirectionNotHeld(StageError):
    """Error if no motion of the arm keeps the direction of its tool where that is asked for.

    Args:
        where: ``start`` or ``goal`` if the tool is turned otherwise there, ``path`` if no motion
            was found.
        tolerance: angle within which the direction is to be kept, [rad].
        part: shares of the motion's time between which it is.
        angle: by how much it is off at start or goal, at least, [rad].
    """

    def __init__(
        self, where: str, tolerance: float, part: tuple[float, float], angle: float = 0.0
    ) -> None:
        within = f"{math.degrees(tolerance):.3g}°"
        begin, end = (f"{100 * share:.3g} %" for share in part)
        message = (
            f"No motion was found that keeps the tool within {within} of its direction from "
            f"{begin} to {end} of its time."
        )
        hint = "Allow a larger tolerance (arm.axis.tolerance), or a shorter part of the motion."
        if where != "path":
            message = (
                f"At the {where} the tool is {math.degrees(angle):.3g}° off the direction that it "
                f"has to keep within {within} there."
            )
            name = "from" if where == "start" else "to"
            hint = f"Turn the tool at the {where}, or let arm.axis.{name} leave the {where} out."
        super().__init__("arm", "direction_not_held", message, hint)
        self.where = where


class NotFollowed(StageError):
    """Error for a stretch of the curve that a URDF arm cannot follow.

    Args:
        first: time of the first point it misses, [s].
        last: time of the last point it misses, [s].
        shortfall: the largest distance by which it misses the curve, [unit].
    """

    def __init__(self, first: float, last: float, shortfall: float) -> None:
        super().__init__(
            "arm",
            "out_of_reach",
            f"From t = {first:.2f} s to {last:.2f} s the arm cannot follow the curve: out of reach "
            f"or past a joint's limit by up to {format_length(shortfall)}.",
            "Move the base nearer, or leave the direction of the gripper free.",
        )
        self.first = first
        self.last = last
        self.shortfall = shortfall


class TooSlow(StageError):
    """Error for a motion that takes many times as long as its way should.

    Args:
        duration: of the motion, [s].
        length: of the tool's way, [unit].
        enough: time that would be enough, [s].
        worst: name of the joint that is nearest to its limits, and when it is, [s].
    """

    def __init__(
        self, duration: float, length: float, enough: float, worst: tuple[str, float]
    ) -> None:
        joint, moment = worst
        super().__init__(
            "timing",
            "too_slow",
            f"Within the joints' limits the motion would take {duration:.0f} s for a way of "
            f"{format_length(length)}, for which {enough:.2g} s should be enough: at "
            f"t = {moment:.3g} s {joint.replace('_', ' ')} has to turn faster than anywhere else.",
            "Choose the law time_optimal, which slows down only there, or move the way from where "
            "the arm is nearly stretched out or its wrist straight.",
        )
        self.duration = duration


class TooManySamples(StageError):
    """Error for a time step that divides a motion into too many samples.

    Args:
        count: of the samples that it would take.
        most: largest number that there may be.
        duration: of the motion, [s].
    """

    def __init__(self, count: int, most: int, duration: float) -> None:
        step = duration / (most - 1)
        super().__init__(
            "timing",
            "too_many_samples",
            f"With this time step a motion of {duration:.3g} s has {count:,} samples, and "
            f"{most:,} may be planned.",
            f"Choose a motion.time_step of at least {math.ceil(step * 1e6) / 1e6:.6f} s.",
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
    """Text of a value given, without the middle if it is long."""
    text = repr(value)
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

"""Errors of an arm without a motion: out of reach, not clear, or unable to meet a request."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from abi.errors import StageError, format_length


def beyond_reach(
    shortfall: float, joint: str = "", limit: float = 0.0, slides: bool = False
) -> str:
    """Predicate of a sentence on an arm that is too far from a point, or too near to it.

    Args:
        shortfall: distance by which the point is out of reach, [unit]: > 0 too far, < 0 too near to
            the shoulder.
        joint: name of a joint that is at its limit; empty for none.
        limit: of that joint, [rad] or [unit].
        slides: whether it slides.
    """
    near = ", too near to its shoulder," if shortfall < 0 else ""
    position = format_length(limit) if slides else f"{math.degrees(limit):.1f}°"
    at_limit = f", with {joint} at its limit of {position}," if joint else ""
    return f"is out of reach by {format_length(abs(shortfall))}{near}{at_limit}"


def past_limit(joint: str, value: float, limit: float, slides: bool) -> str:
    """Clause on a joint that a motion takes past its limit, [rad] or [unit]."""
    far, most = (
        format_length(one) if slides else f"{math.degrees(one):.0f}°" for one in (value, limit)
    )
    return f"{joint} goes to {far} on it, past its limit of {most}"


def beyond_limit(joint: str, part: str, angle: float, limit: float, room: float) -> str:
    """Predicate of a sentence on an arm of which a joint would have to turn too far.

    Args:
        joint: its name.
        part: of the arm, where it is, for people who do not know its name.
        angle: that it would need, [rad].
        limit: its limit, [rad].
        room: angle that it has to keep from the limit, [rad].
    """
    side = "past its limit of"
    if abs(angle) <= abs(limit):
        side = f"which leaves less than {math.degrees(room):.1f}° to its limit of"
    needed, most = (f"{math.degrees(one):.1f}°" for one in (angle, limit))
    return f"would need {joint} (the {part}) at {needed}, {side} {most},"


OUT_OF_REACH = "out_of_reach"
"""Kind of :func:`out_of_reach`."""


def out_of_reach(
    first: float,
    last: float,
    shortfall: float,
    too_near: bool | None,
    slide: tuple[float, float] | None = None,
) -> StageError:
    """Error for a stretch of the curve that the arm cannot reach or follow.

    Args:
        first: time of the first point out of reach, [s].
        last: time of the last point out of reach, [s].
        shortfall: the largest distance missing, [unit].
        too_near: True when the worst point is too near to the shoulder rather than too far; None
            where a joint's limit may be the cause as well.
        slide: extension of the slide q5 at that time and its limit, [unit], if it is past the limit
            and so makes the forearm too long or too short.
    """
    times, far = f"{first:.2f} s to {last:.2f} s", f"by up to {format_length(shortfall)}"
    place = "too near to the shoulder" if too_near else "too far away"
    message = f"The arm cannot reach the curve from {times}: it is {place}, {far}."
    hint = (
        "Move the base away from the curve, or make the upper arm as long as forearm and slide "
        "together."
        if too_near
        else "Move the base nearer, or lengthen upper arm, forearm or slide."
    )
    if too_near is None:
        message = (
            f"From t = {times} the arm cannot follow the curve: out of reach or past a joint's "
            f"limit {far}."
        )
        hint = "Move the base nearer, or leave the direction of the gripper free."
    elif slide is not None:
        extension, limit = slide
        hint = (
            f"The slide would run to {format_length(extension)}, and it ends at "
            f"{format_length(limit)}: go faster, or set the slide's force to 0."
        )
    return StageError("arm", OUT_OF_REACH, message, hint)


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
        why: clause on why start or goal cannot be taken, with joint, limit or distance; for
            ``curve`` on what else is wrong where the arm is proven clear along one.

    Attributes:
        explain: makes the error that tells what the link itself does, which takes a while; None
            where this one does.
    """

    explain: Callable[[], ArmNotClear] | None = None

    def __init__(
        self,
        branch: str,
        where: str,
        link: str = "",
        obstacle: int | str | None = None,
        sentences: str = "",
        has_elbow: bool = True,
        why: str = "",
    ) -> None:
        message = {
            "path": f"{branch}, no path was found that keeps the whole arm clear.",
            "curve": f"{branch}, the arm is clear along a path, but it is not proven "
            "clear along any curve found near it.",
        }.get(where)
        if where == "curve" and why:
            message = f"{branch}, the arm is proven clear along a curve, but {why}."
        if message is None:
            fault = f"the arm cannot reach the {where} within its joint limits"
            if obstacle is not None:
                # bodies of other arms than the paper's are a little larger than their links
                fault = touching(link, obstacle, None, at=f" at the {where}", exact=has_elbow)
            message = f"{branch}, {why or fault}."
        other = "let the elbow be auto" if has_elbow else "leave the direction of the gripper free"
        way_out = f"Move an obstacle or the arm's base, or {other}."
        if where == "curve" and why:
            way_out = "Let it move faster, which takes less time, or set smaller arm.forces."
        super().__init__(
            "arm",
            "arm_not_clear",
            sentences or message,
            f"The plan shown is for the tool tip alone. {way_out}",
        )
        self.branch = branch
        self.where = where
        self.link = link
        self.obstacle = obstacle
        self.has_elbow = has_elbow
        self.why = why

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
        return first._saying(text)

    def nor_in_joints(self, fault: NoJointMotion) -> ArmNotClear:
        """A copy whose text adds why there is no motion in joint space either."""
        text = " ".join(self._sentences[:1] + fault._sentences[:1])
        return self._saying(text)

    def along_tool(self, touched: str) -> ArmNotClear:
        """A copy whose text adds what the arm touches along the curve of the tool alone."""
        text = f"{self._sentences[0]} Along the curve of the tool tip alone {touched}."
        return self._saying(text)

    def _saying(self, text: str) -> ArmNotClear:
        """A copy with another text."""
        place = self.branch, self.where, self.link, self.obstacle
        return ArmNotClear(*place, text, self.has_elbow, self.why)


class NoJointMotion(StageError):
    """Error if no motion of the arm was found in joint space.

    Args:
        where: ``start`` or ``goal`` if the arm has no pose there that will do, ``path`` if the
            search has found none in its time, ``curve`` if no smooth curve near its path is clear,
            ``same`` if the joints are at the goal already.
        message: one sentence on what is wrong.
        hint: one sentence on what to try.
        obstacle: index of what a link touches, from 0, or its name.
        kind: of the error; ``DIRECTION_NOT_HELD`` where the tool's direction is why there is none.
    """

    def __init__(
        self,
        where: str,
        message: str,
        hint: str,
        obstacle: int | str | None = None,
        kind: str = "no_joint_motion",
    ) -> None:
        super().__init__("arm", kind, message, hint, obstacle)
        self.where = where


def no_joint_motion(
    where: str,
    link: str = "",
    obstacle: int | str | None = None,
    poses: int = 0,
    samples: int = 0,
    gap: float | None = None,
    clearance: float = 0.0,
) -> NoJointMotion:
    """Error if no motion was found in joint space, whatever the tool's direction.

    Args:
        where: as of :class:`NoJointMotion`.
        link: link that is in the way at start or goal; empty if no pose was found there.
        obstacle: index of what it touches, from 0, or its name.
        poses: number of poses that were tried there.
        samples: number of random positions that were searched towards.
        gap, clearance: of the link, as for :func:`touching`.
    """
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
            touched = touching(link, obstacle, gap, clearance)
            message = f"{tried} {poses_there} at the {where} {touched}."
    hint = "Move an obstacle or the arm's base, or ask for another start or goal."
    return NoJointMotion(where, message, hint, obstacle)


DIRECTION_NOT_HELD = "direction_not_held"
"""Kind of :func:`direction_not_held`."""


def direction_not_held(
    where: str, tolerance: float, part: tuple[float, float], angle: float = 0.0
) -> NoJointMotion:
    """Error if no motion of the arm keeps the direction of its tool as required.

    Args:
        where: ``start`` or ``goal`` if the tool is turned otherwise there, ``path`` if no motion
            was found.
        tolerance: angle within which the direction is to be kept, [rad].
        part: shares of the motion's time between which it is.
        angle: by how much it is off at start or goal, at least, [rad].
    """
    within = f"{math.degrees(tolerance):.3g}°"
    begin, end = (f"{100 * share:.3g} %" for share in part)
    message = (
        f"No motion was found that keeps the gripper within {within} of its direction from "
        f"{begin} to {end} of its time."
    )
    hint = "Allow a larger tolerance (arm.axis.tolerance), or a shorter part of the motion."
    if where != "path":
        message = (
            f"At the {where} the gripper is {math.degrees(angle):.3g}° off the direction that "
            f"it has to keep within {within} there."
        )
        name = "from" if where == "start" else "to"
        hint = f"Turn the gripper at the {where}, or let arm.axis.{name} leave the {where} out."
    return NoJointMotion(where, message, hint, kind=DIRECTION_NOT_HELD)


def touching(
    link: str,
    obstacle: int | str,
    gap: float | None,
    clearance: float = 0.0,
    at: str = "",
    exact: bool = False,
) -> str:
    """Clause on the link that is in the way at start or goal.

    Args:
        link: its name.
        obstacle: index of what it touches, from 0, or its name.
        gap: distance of its shapes from that, at most, or where they touch, at most 0, how far they
            are in it, at least, as a negative number, [unit]; None where that is not known.
        clearance: distance that is to be kept from obstacles, [unit].
        at: where that is, to stand behind the name of the obstacle.
        exact: whether what is known without ``gap`` is of the link itself.
    """
    name = f"obstacle {obstacle + 1}" if isinstance(obstacle, int) else f"the {obstacle}"
    name, link = f"{name}{at}", f"the {link.replace('_', ' ')}"
    if gap is None:
        return f"{link} {'touches' if exact else 'may touch'} {name}"
    if gap <= 0:
        deep = f", {format_length(-gap)} deep" if gap < 0 else ""
        return f"{link} touches {name}{deep}"
    away, at_most = f"{link} does not touch {name}", f"at most {format_length(gap)}"
    if isinstance(obstacle, int) and gap < clearance:
        return f"{away} but is {at_most} from it, the clearance is {format_length(clearance)}"
    return f"{away}, {at_most} away, but the convex pieces that contain it come too near"

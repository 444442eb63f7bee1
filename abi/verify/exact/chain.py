"""A chain of joints in exact numbers, for :mod:`abi.verify.joint_motion`.

Sines and cosines are not rational, so positions are multiples of 2^-200 with an error bound. The
matrices of a URDF, read as floating-point numbers, are only nearly rotations; they are taken as
they are, and checked not to change any length by more than 2^-40 of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from abi.robot.urdf.couplings import require_followed
from abi.robot.urdf.held_joints import NOT_HELD, held_in_metres
from abi.robot.urdf.joint import Joint
from abi.robot.urdf.robot import Robot, joints_to
from abi.verify.exact.solids import Vec3, in_body, sqrt_bounds
from abi.verify.fault import Fault

BITS = 200
ONE = 1 << BITS
_LARGEST_ANGLE = 64
_NEARLY = Fraction(1, 1 << 45)
WIDER = 1 + Fraction(3, 1 << 38)
"""Bound of how much nearly-rotations may lengthen a vector over a whole chain."""

Exact = NDArray[np.object_]  # of exact numbers, such as a matrix in 2^-200


class ExactTransform(NamedTuple):
    """Rotation (3, 3) and origin (3,), as fractions."""

    turn: Exact
    origin: Exact


class ExactFrame(NamedTuple):
    """A frame in the world: rotation and origin in 2^-200, and bounds of the errors of both."""

    turn: Exact
    origin: Exact
    turn_error: int
    origin_error: int

    def place(self, point: Vec3) -> tuple[Vec3, Fraction]:
        """A point of the frame in the world, and a bound of its error along each axis."""
        whole = wholes(np.array(point, dtype=object))
        size = abs(whole).max() + 1
        x, y, z = (self.turn @ whole >> BITS) + self.origin
        error = 3 * (size * self.turn_error // ONE + 1) + 6 + 1 + self.origin_error
        return (Fraction(x, ONE), Fraction(y, ONE), Fraction(z, ONE)), Fraction(error, ONE)


@dataclass(frozen=True, eq=False)
class ExactChain:
    """Joints between a robot's root and its tip, lengths in [unit].

    Attributes:
        joints: the joints that move: those to the tip, from the base on, then those beside them
            that follow one of the coordinates, parents before children.
        before: number of the joint behind which each stands, and the tip; -1 for the world.
        origins: pose of each joint and of the tip in the frame before it, exact.
        coordinates: names of the joints that the others follow.
        frames: number of the joint that moves each link of the robot, -1 where none does.
        places: pose of each link in that frame, in the world where none does.
        units: [unit] in one metre.
        limits: of the coordinates, [rad] or [unit].
        slides: which of them are lengths.
    """

    joints: tuple[Joint, ...]
    before: tuple[int, ...]
    origins: tuple[ExactTransform, ...]
    coordinates: tuple[str, ...]
    frames: dict[str, int]
    places: dict[str, ExactTransform]
    units: Fraction
    limits: tuple[tuple[Fraction, Fraction], ...]
    slides: tuple[bool, ...]

    def place(self, positions: Sequence[Fraction]) -> list[ExactFrame]:
        """Frames behind each joint, and of the tip, at positions (n,), [rad] or [unit]."""
        still, unmoved = ONE * np.eye(3, dtype=object), np.zeros(3, dtype=object)
        world = ExactFrame(still, unmoved, 0, 0)
        found: list[ExactFrame] = []
        for joint, before, origin in zip(self.joints, self.before, self._wholes, strict=False):
            frame = found[before] if before >= 0 else world
            frame = _behind(frame, *origin, 1)
            value = self.value(joint, positions)
            if joint.kind == "prismatic":
                frame = _behind(frame, still, wholes(_fractions(joint.axis) * value), 1)
            else:
                turn, error = _turned(joint, value)
                frame = _behind(frame, turn, unmoved, error)
            found.append(frame)
        return [*found, _behind(found[self.before[-1]], *self._wholes[-1], 1)]

    @cached_property
    def _wholes(self) -> list[tuple[Exact, Exact]]:
        """Rotation and origin of each pose of ``origins``, in 2^-200."""
        return [(wholes(turn), wholes(origin)) for turn, origin in self.origins]

    def within(self, limits: tuple[tuple[Fraction, Fraction], ...]) -> ExactChain:
        """The chain with other limits of its coordinates, [rad] or [unit]."""
        return replace(self, limits=limits)

    def value(self, joint: Joint, positions: Sequence[Fraction]) -> Fraction:
        """Position of a joint, [rad] or [unit], at those of the coordinates."""
        number = self._coordinate(joint)
        value = positions[number]
        if joint.mimic is not None:
            metres = value / self.units if self.slides[number] else value
            value = Fraction(joint.mimic.factor) * metres + Fraction(joint.mimic.offset)
            value *= self.units if joint.kind == "prismatic" else 1
        return value

    def levers(self, ends: Sequence[Vec3], frame: int, behind: int) -> list[Fraction]:
        """Bound of how far a segment in a joint's frame moves per unit of each coordinate, (n,).

        Args:
            ends: of the segment, in that frame, [unit].
            frame: number of the joint.
            behind: only joints behind this one count, which is ``frame`` or moves it; -1 for all.
        """
        found = [Fraction(0)] * len(self.coordinates)
        far = max(_length(end) for end in ends)
        for k in self.above(frame):
            if k == behind:
                break
            joint = self.joints[k]
            number = self._coordinate(joint)
            factor = abs(Fraction(joint.mimic.factor)) if joint.mimic else Fraction(1)
            slides = joint.kind == "prismatic"
            rate = factor * (self.units if slides else far)
            found[number] += rate / (self.units if self.slides[number] else 1)
            far += _length(self.origins[k].origin)
            if slides:
                far += max(self._stroke(joint, number, end) for end in self.limits[number])
        return [WIDER * lever for lever in found]

    def above(self, frame: int) -> list[int]:
        """Numbers of the joints that move a frame, from the last one to the first."""
        found = []
        while frame >= 0:
            found.append(frame)
            frame = self.before[frame]
        return found

    def meeting(self, first: int, second: int) -> int:
        """Number of the last joint that moves two frames, -1 if none moves both."""
        common = {*self.above(first)} & {*self.above(second)}
        return next((k for k in self.above(first) if k in common), -1)

    def _stroke(self, joint: Joint, number: int, value: Fraction) -> Fraction:
        """Stroke of a sliding joint at a value of its coordinate, [unit]."""
        positions = [Fraction(0)] * len(self.coordinates)
        positions[number] = value
        return abs(self.value(joint, positions))

    def _coordinate(self, joint: Joint) -> int:
        return self.coordinates.index(joint.mimic.joint if joint.mimic else joint.name)


def exact_chain(
    robot: Robot,
    tip: str,
    base: Sequence[float],
    units: int,
    wxyz: Sequence[float] = (1, 0, 0, 0),
    held: Mapping[str, float] = NOT_HELD,
) -> ExactChain:
    """The chain from a robot's root, which stands at ``base`` [unit], to a tip.

    Args:
        robot: the robot.
        tip: name of a link.
        base: position of the root, [unit], world.
        units: [unit] in one metre.
        wxyz: rotation of the root, as a quaternion of any length but zero.
        held: positions of joints beside the chain, [rad] or [unit]; the others rest nearest to 0.

    Raises:
        Fault: a matrix is no rotation, or an axis no unit vector.
        SceneError: links move otherwise than they are posed.
    """
    return _exact_tree(robot, _moving_joints(robot, tip), tip, (base, wxyz), units, held)


def exact_joints(
    robot: Robot,
    names: tuple[str, ...],
    base: Sequence[float],
    units: int,
    wxyz: Sequence[float] = (1, 0, 0, 0),
    held: Mapping[str, float] = NOT_HELD,
) -> ExactChain:
    """All joints that move with those of some names, as of two arms; the last has the tip's frame.

    Args:
        robot: the robot.
        names: joints that move by themselves.
        base: position of the root, [unit], world.
        units: [unit] in one metre.
        wxyz: rotation of the root, as a quaternion of any length but zero.
        held: positions of other joints, [rad] or [unit]; the others rest nearest to 0.

    Raises:
        Fault: a matrix is no rotation, or an axis no unit vector.
        SceneError: links move otherwise than they are posed.
    """
    joints = tuple(
        joint for joint in robot.joints if joint.kind != "fixed" and joint.coordinate in names
    )
    tip = joints[-1].child
    return _exact_tree(robot, (joints, names), tip, (base, wxyz), units, held)


def _exact_tree(
    robot: Robot,
    moving: tuple[tuple[Joint, ...], tuple[str, ...]],
    tip: str,
    stands: tuple[Sequence[float], Sequence[float]],
    units: int,
    held: Mapping[str, float],
) -> ExactChain:
    (joints, names), (base, wxyz) = moving, stands
    by_name = {joint.name: joint for joint in robot.joints}
    require_followed(robot, names, held_in_metres(robot, held, 1 / units))
    positions = _at_rest(robot, names, held, units)
    axes, zero = _fractions(np.eye(3)), _fractions(np.zeros(3))
    turned = np.array([in_body(axis, wxyz) for axis in axes])
    frames = {robot.root: (-1, ExactTransform(turned, _fractions(np.array(base))))}
    before, origins = [-1] * len(joints), [frames[robot.root][1]] * len(joints)
    for joint in robot.joints:
        frame, pose = frames[joint.parent]
        turn, place = _matrix(joint, units)
        pose = ExactTransform(pose.turn @ turn, pose.turn @ place + pose.origin)
        if joint in joints:
            axis = _fractions(joint.axis)
            if abs(axis @ axis - 1) > _NEARLY:
                raise Fault(f"the axis of {joint.name} is no direction")
            number = joints.index(joint)
            before[number], origins[number] = frame, pose
            frame, pose = number, ExactTransform(axes, zero)
        elif joint.kind != "fixed":
            pose = _moved(pose, joint, positions[joint.name], units)
        frames[joint.child] = frame, pose
    last, pose = frames[tip]
    coordinates = [by_name[name] for name in names]
    slides = tuple(joint.kind == "prismatic" for joint in coordinates)
    limits = tuple(
        (scale * Fraction(joint.low), scale * Fraction(joint.high))
        for joint, scale in ((j, units if j.kind == "prismatic" else 1) for j in coordinates)
    )
    return ExactChain(
        *(joints, (*before, last), (*origins, pose), names),
        {link: frame for link, (frame, _) in frames.items()},
        {link: place for link, (_, place) in frames.items()},
        *(Fraction(units), limits, slides),
    )


def _moving_joints(robot: Robot, tip: str) -> tuple[tuple[Joint, ...], tuple[str, ...]]:
    """Joints that move with the coordinates of a tip, and the names of these."""
    way = tuple(joint for joint in joints_to(robot, tip) if joint.kind != "fixed")
    names = {(joint.mimic.joint if joint.mimic else joint.name): None for joint in way}
    beside = [
        joint
        for joint in robot.joints
        if joint.kind != "fixed" and joint not in way
        if (joint.mimic.joint if joint.mimic else joint.name) in names
    ]
    return (*way, *beside), (*names,)


def _at_rest(
    robot: Robot, names: Collection[str], held: Mapping[str, float], units: int
) -> dict[str, Fraction]:
    """Positions of the joints that stand still, [rad] or [m]."""
    found: dict[str, Fraction] = {}
    for joint in robot.joints:
        if joint.mimic is None and joint.name not in names:
            found[joint.name] = Fraction(min(max(0.0, joint.low), joint.high))
            if joint.name in held:
                scale = units if joint.kind == "prismatic" else 1
                found[joint.name] = Fraction(held[joint.name]) / scale
    for joint in robot.joints:
        mimic = joint.mimic
        if mimic is not None and mimic.joint in found:
            at = found[mimic.joint]
            found[joint.name] = Fraction(mimic.factor) * at + Fraction(mimic.offset)
    return found


def _moved(pose: ExactTransform, joint: Joint, position: Fraction, units: int) -> ExactTransform:
    """A pose behind a joint that stands still, whose turn is rounded as those in a URDF are."""
    if joint.kind == "prismatic":
        slid = pose.turn @ (_fractions(joint.axis) * position * units)
        return pose._replace(origin=pose.origin + slid)
    return pose._replace(turn=pose.turn @ _rounded(_turned(joint, position)[0]))


def _matrix(joint: Joint, units: int) -> ExactTransform:
    origin = _fractions(joint.origin)
    turn = origin[:3, :3]
    if (abs(turn @ turn.T - np.eye(3, dtype=object)) > _NEARLY).any():
        raise Fault(f"the origin of {joint.name} is no rotation")
    return ExactTransform(turn, units * origin[:3, 3])


def _behind(frame: ExactFrame, turn: Exact, origin: Exact, error: int) -> ExactFrame:
    """A frame after a transform whose numbers are wrong by at most ``error`` in 2^-200.

    No entry of a rotation exceeds 2. A product of three terms is wrong by what each factor is,
    times the other, and by one for rounding.
    """
    size = max(abs(origin)) + error
    return ExactFrame(
        frame.turn @ turn >> BITS,
        (frame.turn @ origin >> BITS) + frame.origin,
        6 * (frame.turn_error + error) + 3 * (frame.turn_error * error // ONE + 1) + 1,
        frame.origin_error + 3 * (size * frame.turn_error // ONE + 1) + 6 * error + 1,
    )


def _turned(joint: Joint, angle: Fraction) -> tuple[Exact, int]:
    """Rotation about a joint's axis (Rodrigues' formula), and a bound of its error, in 2^-200."""
    if abs(angle) > _LARGEST_ANGLE:
        raise Fault(f"{joint.name} turns by more than {_LARGEST_ANGLE} rad")
    sine, cosine, error = sine_and_cosine(angle)
    # in whole numbers: a fraction for each entry would take ten times as long
    scale = math.lcm(*(part.denominator for part in _fractions(joint.axis)))
    x, y, z = axis = np.array([int(part * scale) for part in _fractions(joint.axis)], dtype=object)
    across = scale * np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=object)
    turn = ((ONE - cosine) * np.outer(axis, axis) + sine * across) // scale**2
    turn[np.diag_indices(3)] += cosine
    return turn, 4 * error + 1


def sine_and_cosine(angle: Fraction) -> tuple[int, int, int]:
    """Sine and cosine in 2^-200, and a bound of the error of both, by Taylor's series.

    Once a term is below the last digit, so are all that follow, each at most half the one before.
    """
    x = _whole(angle)
    sums = [ONE, 0]  # terms of even and of odd order, without their signs
    term, order = ONE, 0
    error, errors = 0, 2
    while term or order <= 2 * abs(angle):
        order += 1
        term = (term * x >> BITS) // order
        # the term before is wrong by `error`, the angle by 1, and both divisions round
        error = (error * (abs(x) + 1) >> BITS) // order + abs(term) // ONE + 4
        errors += error
        sums[order % 2] += term if order % 4 < 2 else -term
    return sums[1], sums[0], errors + error


def nearly_sine_and_cosine(angle: Fraction) -> tuple[Fraction, Fraction]:
    """Sine and cosine, wrong by far less than the last digit of a floating-point number."""
    sine, cosine, _ = sine_and_cosine(angle)
    return Fraction(sine, ONE), Fraction(cosine, ONE)


def _nearest_float(whole: int) -> Fraction:
    """The floating-point number nearest to a number of 2^-200."""
    return Fraction(whole / ONE)


def _whole(number: Fraction) -> int:
    """Number of 2^-200 below it, less than one away."""
    return number.numerator * ONE // number.denominator


wholes: Callable[[Exact], Exact] = np.frompyfunc(_whole, 1, 1)
_fractions: Callable[[NDArray[Any]], Exact] = np.frompyfunc(Fraction, 1, 1)
_rounded: Callable[[Exact], Exact] = np.frompyfunc(_nearest_float, 1, 1)


def _length(vector: Vec3 | Exact) -> Fraction:
    """Upper bound of a length, with short digits."""
    above = sqrt_bounds(sum((part * part for part in vector), Fraction(0)))[1]
    return Fraction(_whole(above) + 1, ONE)

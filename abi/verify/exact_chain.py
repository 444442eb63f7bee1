"""A chain of joints in exact numbers, for :mod:`abi.verify.verify_chain`.

Sines and cosines are not rational, so positions are multiples of 2^-200 with an error bound. The
matrices of a URDF, read as floating-point numbers, are only nearly rotations; they are taken as
they are, and checked not to change any length by more than 2^-40 of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from abi.robot.robot import Joint, Robot, joints_to
from abi.verify.exact import Vec3, dot, in_body, sqrt_bounds, vector
from abi.verify.fault import Fault

_BITS = 200
_ONE = 1 << _BITS
_LARGEST_ANGLE = 64
_NEARLY = Fraction(1, 1 << 45)
WIDER = 1 + Fraction(1, 1 << 30)
"""Bound of how much nearly-rotations may lengthen a vector over a whole chain."""

Matrix = tuple[tuple[int, int, int], ...]
"""Rows of a matrix in 2^-200."""


class ExactFrame(NamedTuple):
    """A frame in the world: rotation and origin in 2^-200, and bounds of the errors of both."""

    turn: Matrix
    origin: tuple[int, int, int]
    turn_error: int
    origin_error: int

    def place(self, point: Vec3) -> tuple[Vec3, Fraction]:
        """A point of the frame in the world, and a bound of its error along each axis."""
        x, y, z = (_whole(number) for number in point)
        size = max(abs(x), abs(y), abs(z)) + 1
        placed = [
            Fraction(((row[0] * x + row[1] * y + row[2] * z) >> _BITS) + origin, _ONE)
            for row, origin in zip(self.turn, self.origin, strict=True)
        ]
        error = 3 * (size * self.turn_error // _ONE + 1) + 6 + 1 + self.origin_error
        return (placed[0], placed[1], placed[2]), Fraction(error, _ONE)


@dataclass(frozen=True, eq=False)
class ExactChain:
    """Joints between a robot's root and its tip, lengths in [unit].

    Attributes:
        joints: the joints that move, from the base on.
        origins: pose of each joint and of the tip in the frame before it, exact.
        coordinates: names of the joints that the others follow.
        frames: number of the joint that moves each link of the robot, -1 where none does.
        units: [unit] in one metre.
        limits: of the coordinates, [rad] or [unit].
        slides: which of them are lengths.
    """

    joints: tuple[Joint, ...]
    origins: tuple[tuple[tuple[Vec3, Vec3, Vec3], Vec3], ...]
    coordinates: tuple[str, ...]
    frames: dict[str, int]
    units: Fraction
    limits: tuple[tuple[Fraction, Fraction], ...]
    slides: tuple[bool, ...]

    def place(self, positions: Sequence[Fraction]) -> list[ExactFrame]:
        """Frames behind each joint, and of the tip, at positions (n,), [rad] or [unit]."""
        frame = ExactFrame(((_ONE, 0, 0), (0, _ONE, 0), (0, 0, _ONE)), (0, 0, 0), 0, 0)
        found = []
        for joint, origin in zip(self.joints, self.origins[:-1], strict=True):
            frame = _behind(frame, *_rounded(origin), 1)
            value = self.value(joint, positions)
            if joint.kind == "prismatic":
                way = tuple(_whole(Fraction(part) * value) for part in joint.axis)
                still = ((_ONE, 0, 0), (0, _ONE, 0), (0, 0, _ONE))
                frame = _behind(frame, still, (way[0], way[1], way[2]), 1)
            else:
                turn, error = _turned(joint, value)
                frame = _behind(frame, turn, (0, 0, 0), error)
            found.append(frame)
        return [*found, _behind(frame, *_rounded(self.origins[-1]), 1)]

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
            behind: only joints behind this one count.
        """
        found = [Fraction(0)] * len(self.coordinates)
        far = max(_length(end) for end in ends)
        for k in range(frame, behind, -1):
            joint = self.joints[k]
            number = self._coordinate(joint)
            factor = abs(Fraction(joint.mimic.factor)) if joint.mimic else Fraction(1)
            slides = joint.kind == "prismatic"
            rate = factor * (self.units if slides else far)
            found[number] += rate / (self.units if self.slides[number] else 1)
            far += _length(self.origins[k][1])
            if slides:
                far += max(self._stroke(joint, number, end) for end in self.limits[number])
        return [WIDER * lever for lever in found]

    def _stroke(self, joint: Joint, number: int, value: Fraction) -> Fraction:
        """Stroke of a sliding joint at a value of its coordinate, [unit]."""
        positions = [Fraction(0)] * len(self.coordinates)
        positions[number] = value
        return abs(self.value(joint, positions))

    def _coordinate(self, joint: Joint) -> int:
        return self.coordinates.index(joint.mimic.joint if joint.mimic else joint.name)


def exact_chain(
    robot: Robot, tip: str, base: Sequence[float], units: int, wxyz: Sequence[float] = (1, 0, 0, 0)
) -> ExactChain:
    """The chain from a robot's root, which stands at ``base`` [unit], to a tip.

    Args:
        robot: the robot.
        tip: name of a link.
        base: position of the root, [unit], world.
        units: [unit] in one metre.
        wxyz: rotation of the root, as a quaternion of any length but zero.

    Raises:
        Fault: a matrix is no rotation, or an axis no unit vector.
    """
    way = joints_to(robot, tip)
    joints = tuple(joint for joint in way if joint.kind != "fixed")
    by_name = {joint.name: joint for joint in robot.joints}
    names = tuple(dict.fromkeys(j.mimic.joint if j.mimic else j.name for j in joints))
    x, y, z = map(Fraction, base)
    one, zero = Fraction(1), Fraction(0)
    axes = (one, zero, zero), (zero, one, zero), (zero, zero, one)
    pose = (in_body(axes[0], wxyz), in_body(axes[1], wxyz), in_body(axes[2], wxyz)), (x, y, z)
    origins = []
    for joint in way:
        pose = _times(pose, _matrix(joint, units))
        if joint.kind != "fixed":
            _check_unit(joint)
            origins.append(pose)
            pose = axes, (zero, zero, zero)
    frames = {robot.root: -1}
    for joint in robot.joints:
        frames[joint.child] = joints.index(joint) if joint in joints else frames[joint.parent]
    moving = [by_name[name] for name in names]
    slides = tuple(joint.kind == "prismatic" for joint in moving)
    limits = tuple(
        (scale * Fraction(joint.low), scale * Fraction(joint.high))
        for joint, scale in ((j, units if j.kind == "prismatic" else 1) for j in moving)
    )
    return ExactChain(joints, (*origins, pose), names, frames, Fraction(units), limits, slides)


_Pose = tuple[tuple[Vec3, Vec3, Vec3], Vec3]


def _matrix(joint: Joint, units: int) -> _Pose:
    rows = [[Fraction(number) for number in row] for row in joint.origin.tolist()]
    a, b, c = ((row[0], row[1], row[2]) for row in rows[:3])
    for u, v, product in ((a, a, 1), (b, b, 1), (c, c, 1), (a, b, 0), (a, c, 0), (b, c, 0)):
        if abs(dot(u, v) - product) > _NEARLY:
            raise Fault(f"the origin of {joint.name} is no rotation")
    return (a, b, c), (units * rows[0][3], units * rows[1][3], units * rows[2][3])


def _check_unit(joint: Joint) -> None:
    axis = vector(joint.axis.tolist())
    if abs(dot(axis, axis) - 1) > _NEARLY:
        raise Fault(f"the axis of {joint.name} is no direction")


def _times(first: _Pose, second: _Pose) -> _Pose:
    columns = list(zip(*second[0], strict=True))
    rows = [tuple(dot(row, column) for column in columns) for row in first[0]]
    a, b, c = ((row[0], row[1], row[2]) for row in rows)
    x, y, z = (dot(row, second[1]) + part for row, part in zip(first[0], first[1], strict=True))
    return (a, b, c), (x, y, z)


def _rounded(pose: _Pose) -> tuple[Matrix, tuple[int, int, int]]:
    turn = tuple((_whole(row[0]), _whole(row[1]), _whole(row[2])) for row in pose[0])
    x, y, z = map(_whole, pose[1])
    return turn, (x, y, z)


def _behind(
    frame: ExactFrame, turn: Matrix, origin: tuple[int, int, int], error: int
) -> ExactFrame:
    """A frame after a transform whose numbers are wrong by at most ``error`` in 2^-200.

    No entry of a rotation exceeds 2. A product of three terms is wrong by what each factor is,
    times the other, and by one for rounding.
    """
    columns = list(zip(*turn, strict=True))
    turned = tuple(
        tuple(
            (row[0] * column[0] + row[1] * column[1] + row[2] * column[2]) >> _BITS
            for column in columns
        )
        for row in frame.turn
    )
    moved = tuple(
        ((row[0] * origin[0] + row[1] * origin[1] + row[2] * origin[2]) >> _BITS) + start
        for row, start in zip(frame.turn, frame.origin, strict=True)
    )
    size = max(map(abs, origin)) + error
    return ExactFrame(
        tuple((row[0], row[1], row[2]) for row in turned),
        (moved[0], moved[1], moved[2]),
        6 * (frame.turn_error + error) + 3 * (frame.turn_error * error // _ONE + 1) + 1,
        frame.origin_error + 3 * (size * frame.turn_error // _ONE + 1) + 6 * error + 1,
    )


def _turned(joint: Joint, angle: Fraction) -> tuple[Matrix, int]:
    """Rotation about a joint's axis (Rodrigues' formula), and a bound of its error, in 2^-200."""
    if abs(angle) > _LARGEST_ANGLE:
        raise Fault(f"{joint.name} turns by more than {_LARGEST_ANGLE} rad")
    sine, cosine, error = sine_and_cosine(angle)
    s, c = Fraction(sine, _ONE), Fraction(cosine, _ONE)
    x, y, z = (Fraction(part) for part in joint.axis)
    v = 1 - c
    rows = (
        (c + x * x * v, x * y * v - z * s, x * z * v + y * s),
        (y * x * v + z * s, c + y * y * v, y * z * v - x * s),
        (z * x * v - y * s, z * y * v + x * s, c + z * z * v),
    )
    matrix = tuple((_whole(row[0]), _whole(row[1]), _whole(row[2])) for row in rows)
    return matrix, 4 * error + 1


def sine_and_cosine(angle: Fraction) -> tuple[int, int, int]:
    """Sine and cosine in 2^-200, and a bound of the error of both, by Taylor's series.

    Once a term is below the last digit, so are all that follow, each at most half the one before.
    """
    x = _whole(angle)
    sums = [_ONE, 0]  # terms of even and of odd order, without their signs
    term, order = _ONE, 0
    error, errors = 0, 2
    while term or order <= 2 * abs(angle):
        order += 1
        term = (term * x >> _BITS) // order
        # the term before is wrong by `error`, the angle by 1, and both divisions round
        error = (error * (abs(x) + 1) >> _BITS) // order + abs(term) // _ONE + 4
        errors += error
        sums[order % 2] += term if order % 4 < 2 else -term
    return sums[1], sums[0], errors + error


def nearly_sine_and_cosine(angle: Fraction) -> tuple[Fraction, Fraction]:
    """Sine and cosine, wrong by far less than the last digit of a floating-point number."""
    sine, cosine, _ = sine_and_cosine(angle)
    return Fraction(sine, _ONE), Fraction(cosine, _ONE)


def _whole(number: Fraction) -> int:
    """Number of 2^-200 below it, less than one away."""
    return number.numerator * _ONE // number.denominator


def _length(vector: Vec3) -> Fraction:
    """Upper bound of a length, with short digits."""
    above = sqrt_bounds(dot(vector, vector))[1]
    return Fraction(_whole(above) + 1, _ONE)

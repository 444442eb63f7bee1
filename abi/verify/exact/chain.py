"""A chain of joints in exact numbers, for :mod:`abi.verify.joint_motion`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import numpy as np

from abi.robot.urdf.joint import Joint
from abi.verify.exact.frame import (
    ONE,
    Exact,
    ExactFrame,
    behind,
    fractions,
    turned,
    whole,
    wholes,
)
from abi.verify.exact.solids import Vec3, sqrt_bounds

WIDER = 1 + Fraction(3, 1 << 38)
"""Bound of how much nearly-rotations may lengthen a vector over a whole chain."""


@dataclass(frozen=True, eq=False)
class ExactChain:
    """Joints between a robot's root and its tip, lengths in [unit].

    Attributes:
        joints: the joints that move: those to the tip, from the base on, then those beside them
            that follow one of the coordinates, parents before children.
        before: number of the joint behind which each stands, and the tip; -1 for the world.
        origins: pose of each joint and of the tip in the frame before it, (4, 4), fractions.
        coordinates: names of the joints that the others follow.
        frames: number of the joint that moves each link of the robot, -1 where none does.
        places: pose of each link in that frame, in the world where none does, (4, 4), fractions.
        units: [unit] in one metre.
        limits: of the coordinates, [rad] or [unit].
        slides: which of them are lengths.
    """

    joints: tuple[Joint, ...]
    before: tuple[int, ...]
    origins: tuple[Exact, ...]
    coordinates: tuple[str, ...]
    frames: dict[str, int]
    places: dict[str, Exact]
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
            frame = behind(frame, *origin, 1)
            value = self.value(joint, positions)
            if joint.kind == "prismatic":
                frame = behind(frame, still, wholes(fractions(joint.axis) * value), 1)
            else:
                turn, error = turned(joint, value)
                frame = behind(frame, turn, unmoved, error)
            found.append(frame)
        return [*found, behind(found[self.before[-1]], *self._wholes[-1], 1)]

    @cached_property
    def _wholes(self) -> list[tuple[Exact, Exact]]:
        """Rotation and origin of each pose of ``origins``, in 2^-200."""
        return [(wholes(pose[:3, :3]), wholes(pose[:3, 3])) for pose in self.origins]

    def within(self, limits: tuple[tuple[Fraction, Fraction], ...]) -> ExactChain:
        """The chain with other limits of its coordinates, [rad] or [unit]."""
        return replace(self, limits=limits)

    def value(self, joint: Joint, positions: Sequence[Fraction]) -> Fraction:
        """Position of a joint, [rad] or [unit], at those of the coordinates."""
        number = self._coordinate(joint)
        value = positions[number]
        if joint.follows is not None:
            metres = value / self.units if self.slides[number] else value
            value = Fraction(joint.factor) * metres + Fraction(joint.offset)
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
            slides = joint.kind == "prismatic"
            rate = abs(Fraction(joint.factor)) * (self.units if slides else far)
            found[number] += rate / (self.units if self.slides[number] else 1)
            far += _length(self.origins[k][:3, 3])
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
        return self.coordinates.index(joint.coordinate)


def _length(vector: Vec3 | Exact) -> Fraction:
    """Upper bound of a length, with short digits."""
    above = sqrt_bounds(sum((part * part for part in vector), Fraction(0)))[1]
    return Fraction(whole(above) + 1, ONE)

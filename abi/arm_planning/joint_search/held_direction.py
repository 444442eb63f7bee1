"""A direction that an arm's tool keeps within a tolerance: its error, and how to reach it.

While the joints go straight and turn by w in all, the tip's z axis d turns at a rate of at most w,
and its second derivative is at most 3 w² / 2: the axis of each joint is turned by those before it,
which adds at most w² / 2 to the w² of a steady turn. So d · u, with u the direction, is nowhere
less than at the nearer end by more than an eighth of that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from abi import arguments
from abi.arrays import BoolArray, FloatArray, IntArray, ShortRepr, read_only
from abi.robot.any_arm import AnyArm
from abi.scene.held_axis import HeldAxis

_ROUNDS = 12
_DAMPING = 1e-6
_LARGEST_STEP = 0.3
_OPPOSITE = -1 + 1e-12
"""Cosine below which the tip points the other way."""
_NEAR, _WITHIN = 0.6, 0.8
"""Fractions of the tolerance within which joints are projected, and to which their motions keep."""
_PIECES = 16
"""Pieces of a joint motion that are bounded separately."""
_ROOM = 0.02
"""Part of the tolerance by which a motion may deviate more than at its ends."""
AT_RISK = 0.98
"""Part of the tolerance that a motion keeps: an exact check that bounds it otherwise succeeds."""


@dataclass(frozen=True, eq=False, repr=False)
class HeldDirection(ShortRepr):
    """A direction that the z axis of an arm's tip is held to during a part of a motion.

    Attributes:
        arm: the arm.
        direction: the direction, (3,), of any length but zero, world; kept as a unit vector.
        tolerance: largest angle between the two, above 0, [rad].
        begin: where the part begins, as a share of the motion's time.
        end: where it ends, above that.
    """

    arm: AnyArm
    direction: FloatArray
    tolerance: float
    begin: float = 0.0
    end: float = 1.0

    def __post_init__(self) -> None:
        direction = arguments.numbers("direction", self.direction, (3,))
        begin = arguments.number("begin", self.begin, 0.0, 1.0)
        arguments.keep(
            self,
            direction=direction / np.linalg.norm(direction),
            tolerance=arguments.number("tolerance", self.tolerance, 0.0, np.pi / 2),
            begin=begin,
            end=arguments.number("end", self.end, begin, 1.0),
        )

    @classmethod
    def of(cls, arm: AnyArm, axis: HeldAxis) -> Self:
        """The direction that a scene asks for."""
        return cls(arm, np.array(axis.direction), axis.tolerance, axis.begin, axis.end)

    def angles(self, positions: FloatArray) -> FloatArray:
        """Angles (k,) between the direction and the tip's z axis at joint positions (k, n)."""
        tip = self.arm.chain.poses(positions / self.arm.scales)[:, -1, :, 2]
        apart, along = tip - self.direction, tip + self.direction  # exact where either is small
        squares = (apart * apart).sum(axis=1), (along * along).sum(axis=1)
        return np.asarray(2 * np.arctan2(*map(np.sqrt, squares)))

    def largest_angles(self, positions: FloatArray) -> FloatArray:
        """Bounds (k - 1,) of that angle while the joints go straight between positions (k, n)."""
        angles = self.angles(positions)
        turned = np.abs(np.diff(positions, axis=0)) @ self._turns
        cosines = np.minimum(np.cos(angles[1:]), np.cos(angles[:-1])) - 3 / 16 * turned**2
        # the angle itself cannot grow faster than the joints turn
        steady = (angles[1:] + angles[:-1] + turned) / 2
        return np.asarray(np.minimum(np.arccos(np.maximum(cosines, -1.0)), steady))

    def excess(self, positions: FloatArray, part: float = AT_RISK) -> BoolArray:
        """Which straight joint motions (k - 1,) between positions (k, n) are not proven to hold it.

        Args:
            positions: of the joints.
            part: of the tolerance that may be used up.
        """
        return np.asarray(self.largest_angles(positions) > part * self.tolerance)

    def rows(self, samples: int) -> slice:
        """Uniform samples of a motion that are in the part, or next to it."""
        last = samples - 1
        return slice(math.floor(self.begin * last), math.ceil(self.end * last) + 1)

    def fault(self, positions: FloatArray) -> int | None:
        """Sample of joint positions (k, n) at uniform times after which it is held least.

        None where the direction is proven to be held throughout the part.
        """
        rows = self.rows(len(positions))
        inside = positions[rows]
        if not self.excess(inside).any():
            return None
        worst = int(self.largest_angles(inside).argmax())
        at = self.angles(inside[worst : worst + 2])
        return int(rows.start) + worst + int(at.argmax())

    def holds_way(self, start: FloatArray, end: FloatArray) -> bool:
        """Check whether a short straight joint motion, (n,) to (n,), holds it with a margin."""
        between = np.linspace(start, end, _PIECES + 1)
        ends = float(self.angles(between[[0, -1]]).max()) / self.tolerance
        return not self.excess(between, min(max(_WITHIN, ends + _ROOM), AT_RISK)).any()

    def brought_near(self, joints: FloatArray) -> FloatArray | None:
        """Project joint positions (n,) to ones that hold it with a margin; None if that fails."""
        chain, (turning, axes, rates) = self.arm.chain, self._turning
        low, high = chain.limits.T
        q = joints / self.arm.scales
        for _ in range(_ROUNDS):
            poses = chain.poses(q[None])[0]
            tip = poses[-1, :, 2]
            cosine = min(max(float(tip @ self.direction), -1.0), 1.0)
            angle = math.acos(cosine)
            if angle <= _NEAR * self.tolerance:
                return q * self.arm.scales
            # the tip's way to the direction along the great circle; where opposite, any way round
            aside = self.direction - cosine * tip
            if cosine < _OPPOSITE:
                aside = np.eye(3)[np.abs(tip).argmin()]
                aside = aside - (aside @ tip) * tip
            wanted = aside * ((angle - _NEAR / 2 * self.tolerance) / math.sqrt(aside @ aside))
            world = np.einsum("jrc,jc->jr", poses[turning, :, :3], axes)
            slopes = _across(world, tip).T @ rates
            step = slopes.T @ np.linalg.solve(slopes @ slopes.T + _DAMPING * np.eye(3), wanted)
            size = float(np.abs(step).max())
            q = np.clip(q + step * min(1.0, _LARGEST_STEP / max(size, 1e-12)), low, high)
        return None

    @cached_property
    def _turning(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Turning joints before the tip: numbers, axes, and turns per unit of each coordinate."""
        table = self.arm.chain.table
        turning = np.flatnonzero(~table.slides[: table.length]).astype(np.int32)
        rates = np.zeros((len(turning), len(self.arm.chain.names)))
        rates[np.arange(len(turning)), table.source[turning]] = table.factor[turning]
        return turning, table.axes.reshape(-1, 3)[turning], read_only(rates)

    @cached_property
    def _turns(self) -> FloatArray:
        """Largest turn of the tip per unit of each coordinate, (n,), [rad]."""
        return read_only(np.abs(self._turning[2]).sum(axis=0) / self.arm.scales)


def _across(axes: FloatArray, tip: FloatArray) -> FloatArray:
    """Rates (k, 3) of a unit vector that turns about axes (k, 3): cross products."""
    (a, b, c), (x, y, z) = axes.T, tip
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=1)

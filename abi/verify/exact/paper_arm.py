"""The arm in exact rational numbers, for :mod:`abi.verify.verify_paper_arm`.

The elbow's position contains square roots, so it is an interval. How far a link moves when the tool
moves by d and the slide by e is bounded as in ``abi.robot.paper_arm.pose_kernels``, but shares no
code with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal, NamedTuple

from abi.verify.exact.interval import Interval, enclose
from abi.verify.exact.solids import Vec3, dot

Vec3I = tuple[Interval, Interval, Interval]

Body = Literal["column", "upper_arm", "forearm", "slide"]


class ExactCapsule(NamedTuple):
    """All points within ``radius`` of a segment of a link's axis, from ``low`` to ``high``."""

    link: str
    body: Body
    low: Fraction
    high: Fraction
    radius: Fraction
    neighbour: bool
    grips: bool


@dataclass(frozen=True)
class ExactPose:
    """The arm near one pose: with the tool within ``tool`` of a point, the slide within ``slide``.

    Attributes:
        shoulder, elbow, at: positions of shoulder, elbow and tool, [unit], world.
        forearm: its length a6, between ``short`` and ``long`` nearby.
        rate: bound of the elbow's motion per motion of the tool.
        slide_rate: the same per motion of the slide.
        tool, slide: the distances, [unit].
    """

    shoulder: Vec3
    elbow: Vec3I
    at: Vec3
    forearm: Fraction
    short: Fraction
    long: Fraction
    rate: Fraction
    slide_rate: Fraction
    tool: Fraction
    slide: Fraction


@dataclass(frozen=True)
class ExactArm:
    """Lengths and place of the arm, [unit], and the side of its elbow.

    Attributes:
        base: position of its base.
        height: of the shoulder above the base.
        upper: a3.
        lower: a4 + a5.
        side: 1 or -1, the sign of q3.
    """

    base: Vec3
    height: Fraction
    upper: Fraction
    lower: Fraction
    side: int

    def near(self, at: Vec3, forearm: Interval, tool: Fraction) -> ExactPose | None:
        """The arm with its tool within ``tool`` of ``at``; None if it may be out of reach.

        Args:
            at: a position of the tool, [unit], world.
            forearm: lengths a6 that it has there, [unit].
            tool: distance, [unit].
        """
        middle, slide = (forearm.low + forearm.high) / 2, (forearm.high - forearm.low) / 2
        x, y = at[0] - self.base[0], at[1] - self.base[1]
        z = at[2] - self.base[2] - self.height
        across = enclose(x * x + y * y).sqrt()
        reach = enclose(x * x + y * y + z * z).sqrt()
        if forearm.low <= 0 or across.low <= tool or reach.low <= tool:
            return None
        cosine = self._cosine(reach.low - tool, reach.high + tool, forearm)
        if cosine >= 1:
            return None
        sine = enclose(1 - cosine * cosine).sqrt().low
        if sine <= 0:
            return None
        a3 = self.upper
        along = enclose(a3 * a3 - middle * middle).plus(reach.times(reach))
        along = along.over(enclose(Fraction(2))).over(reach)
        lift = enclose(a3 * a3).minus(along.times(along)).sqrt().times(enclose(Fraction(self.side)))
        height = enclose(z)
        out = along.times(across).minus(lift.times(height)).over(reach)
        up = along.times(height).plus(lift.times(across)).over(reach)
        share = out.over(across)
        elbow = (
            enclose(self.base[0]).plus(share.times(enclose(x))),
            enclose(self.base[1]).plus(share.times(enclose(y))),
            enclose(self.base[2] + self.height).plus(up),
        )
        rate = max(
            Fraction(1),
            1 / sine,
            (out.magnitude + (tool + slide) / sine) / (across.low - tool),
        )
        shoulder = (self.base[0], self.base[1], self.base[2] + self.height)
        return ExactPose(
            *(shoulder, elbow, at, middle, forearm.low, forearm.high),
            *(rate, 1 / sine, tool, slide),
        )

    def least(self, pose: ExactPose, capsule: ExactCapsule, normal: Vec3) -> Fraction:
        """Least product of a direction with the capsule's segment at the pose."""
        return min(self._product(pose, capsule, end, normal) for end in (capsule.low, capsule.high))

    def way(self, pose: ExactPose, capsule: ExactCapsule) -> Fraction:
        """Bound of how far the capsule's segment moves near the pose, [unit]."""
        if capsule.body == "column":
            return Fraction(0)
        ends = (capsule.low, capsule.high)
        if capsule.body == "upper_arm":
            share = max(map(abs, ends)) / self.upper
            return share * (pose.rate * pose.tool + pose.slide_rate * pose.slide)
        slides = capsule.body == "slide"
        by_tool = by_slide = Fraction(0)
        for forearm in (pose.short, pose.long):
            for end in ends:
                share = (end + (forearm - self.lower if slides else 0)) / forearm
                behind, ahead = abs(1 - share), abs(share)
                by_tool = max(by_tool, behind * pose.rate + ahead)
                extra = behind if slides else ahead
                by_slide = max(by_slide, behind * pose.slide_rate + extra)
        return by_tool * pose.tool + by_slide * pose.slide

    def _product(
        self, pose: ExactPose, capsule: ExactCapsule, end: Fraction, normal: Vec3
    ) -> Fraction:
        if capsule.body == "column":
            return dot(normal, self.base) + normal[2] * end
        of_elbow = enclose(Fraction(0))
        for part, place in zip(normal, pose.elbow, strict=True):
            of_elbow = of_elbow.plus(enclose(part).times(place))
        if capsule.body == "upper_arm":
            share, other = end / self.upper, dot(normal, pose.shoulder)
            return _mixed(other, of_elbow, share)
        slid = pose.forearm - self.lower if capsule.body == "slide" else Fraction(0)
        return _mixed(dot(normal, pose.at), of_elbow, 1 - (end + slid) / pose.forearm)

    def _cosine(self, near: Fraction, far: Fraction, forearm: Interval) -> Fraction:
        """Bound of the size of cos q3 for tools between two distances from the shoulder."""
        a3 = self.upper
        low = near * near - a3 * a3 - forearm.high**2
        high = far * far - a3 * a3 - forearm.low**2
        low /= 2 * a3 * (forearm.low if low < 0 else forearm.high)
        high /= 2 * a3 * (forearm.low if high > 0 else forearm.high)
        return max(abs(low), abs(high))


def _mixed(point: Fraction, of_elbow: Interval, share: Fraction) -> Fraction:
    """Lower bound of a product with (1 - share) of a point and a share of the elbow."""
    return (1 - share) * point + min(share * of_elbow.low, share * of_elbow.high)

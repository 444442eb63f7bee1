"""Check that curves and motion of a plan are those of its scene, in exact rational numbers.

A curve must lead from start to goal. The tool of the paper's arm, from the joint positions as
written, must pass along the curve in order, on the side of the elbow and with the slide for which
the certificate holds.
"""

from __future__ import annotations

import itertools
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from abi.scene.scene import Scene
from abi.verify.exact import ExactCurve, Vec3, sub, vector
from abi.verify.exact_arm import ExactArm
from abi.verify.exact_chain import nearly_sine_and_cosine
from abi.verify.exact_slide import ExactSlide
from abi.verify.fault import Fault
from abi.verify.plan_fields import finite, list_of, numbers_of

_ROUNDING = Fraction(1, 10**9)
"""Error at start and goal that is let pass, over the largest coordinate of the workspace."""
_REACHED = Fraction(1, 10**7)
"""Error of the tool that is let pass, over the length of the arm."""
_LARGEST_ANGLE = 1e4
_PARTS = 32  # of each polynomial
_STEPS = 6
_JOINTS = 6


def check_ends(curve: ExactCurve, scene: Scene) -> None:
    """Check that a curve leads from the scene's start to its goal, up to rounding.

    Raises:
        Fault: it does not.
    """
    box = scene.workspace
    allowed = _ROUNDING * Fraction(max(map(abs, (*box.min, *box.max))))
    first, _, _ = curve.spans[0]
    _, last, _ = curve.spans[-1]
    for name, at, point in (("start", first, scene.start), ("goal", last, scene.goal)):
        if _gap(point_at(curve, at), vector(point)) > allowed:
            raise Fault(f"the curve is not at the scene's {name}")


def check_tool(
    section: dict[str, Any], duration: object, arm: ExactArm, curve: ExactCurve, slide: ExactSlide
) -> None:
    """Check that the joint positions of a plan move the tool along the curve, from end to end.

    Raises:
        Fault: they do not.
        SceneError: a field has the wrong form.
    """
    label = "arm.positions"
    rows = [numbers_of(label, row) for row in list_of(label, section.get("positions"))]
    times = numbers_of("arm.time", section.get("time"))
    if len(rows) < 2 or len(times) != len(rows) or any(len(row) != _JOINTS for row in rows):
        raise Fault(f"its positions are not two or more of {_JOINTS} joints, each with a time")
    late = abs(times[-1] - finite("timing.duration", duration)) > 1e-9 * max(1.0, times[-1])
    if times[0] != 0 or late or any(a > b for a, b in itertools.pairwise(times)):
        raise Fault("its times do not go from 0 to the motion's duration")
    allowed = _REACHED * (arm.upper + arm.lower)
    path, at = _Path.of(curve), float(curve.spans[0][0])
    first, last = (point_at(curve, end) for end in (curve.spans[0][0], curve.spans[-1][1]))
    for number, (row, time) in enumerate(zip(rows, times, strict=True)):
        tool, sine, out = _placed(arm, row)
        if sine * arm.side <= 0 or out <= 0:
            raise Fault(f"at {time:g} s its elbow is on the other side")
        ends = [first] * (number == 0) + [last] * (number == len(rows) - 1)
        found = path.next(tool, at, allowed)
        if found is None or any(_gap(tool, end) > allowed for end in ends):
            raise Fault(f"at {time:g} s the tool is not where it is on the curve")
        at = found
        slid, q5 = slide.within(Fraction(at), Fraction(at)), Fraction(row[4])
        if not slid.low - allowed <= q5 <= slid.high + allowed:
            raise Fault(f"at {time:g} s its slide is not where it is on the curve")


@dataclass(frozen=True, eq=False)
class _Path:
    """A curve in floating point, in which places are sought that are then checked exactly.

    Attributes:
        curve: the curve.
        starts: first parameter of each polynomial.
        bezier: Bézier points of each.
        grid: parameters in order, and the places there.
    """

    curve: ExactCurve
    starts: list[float]
    bezier: list[list[tuple[float, ...]]]
    grid: list[tuple[float, tuple[float, ...]]]

    @classmethod
    def of(cls, curve: ExactCurve) -> _Path:
        spans = curve.spans
        starts = [float(start) for start, _, _ in spans]
        bezier = [
            [tuple(map(float, point)) for point in curve.points(span, start, end)]
            for start, end, span in spans
        ]
        path = cls(curve, starts, bezier, [])
        for start, end, _ in spans:
            low, high = float(start), float(end)
            parameters = (low + (high - low) * k / _PARTS for k in range(_PARTS))
            path.grid.extend((at, path.place(at)[0]) for at in parameters)
        last = float(spans[-1][1])
        path.grid.append((last, path.place(last)[0]))
        return path

    def place(self, at: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Place and derivative at a parameter."""
        number = max(bisect_right(self.starts, at) - 1, 0)
        start, end = map(float, self.curve.spans[number][:2])
        share, points = (at - start) / (end - start), self.bezier[number]
        degree = len(points) - 1
        while len(points) > 2:
            points = [_mixed(a, b, share) for a, b in itertools.pairwise(points)]
        a, b = points
        slope = tuple(degree * (q - p) / (end - start) for p, q in zip(a, b, strict=True))
        return _mixed(a, b, share), slope

    def next(self, tool: Vec3, behind: float, allowed: Fraction) -> float | None:
        """First parameter found, not before ``behind``, where the curve is at the tool."""
        target = tuple(map(float, tool))
        for guess in self._guesses(target, behind):
            at = self._nearest(target, guess, behind)
            if _gap(point_at(self.curve, Fraction(at)), tool) <= allowed:
                return at
        return None

    def _guesses(self, target: tuple[float, ...], behind: float) -> Iterator[float]:
        """Parameters from ``behind`` on whose places are nearer than those beside them."""
        ahead = [(behind, self.place(behind)[0])]
        ahead += self.grid[bisect_right(self.grid, behind, key=_parameter) :]
        away = [_squared(place, target) for _, place in ahead]
        around = zip([float("inf"), *away], away, [*away[1:], float("inf")], strict=False)
        for (at, _), (before, here, after) in zip(ahead, around, strict=True):
            if before >= here <= after:
                yield at

    def _nearest(self, target: tuple[float, ...], at: float, behind: float) -> float:
        """Improve a parameter by steps of Gauss and Newton."""
        last = self.grid[-1][0]
        for _ in range(_STEPS):
            place, slope = self.place(at)
            square = sum(part * part for part in slope)
            if square == 0:
                break
            ahead = sum((t - p) * s for t, p, s in zip(target, place, slope, strict=True))
            at = min(max(at + ahead / square, behind), last)
        return at


def _placed(arm: ExactArm, row: Sequence[float]) -> tuple[Vec3, Fraction, Fraction]:
    """Tool at joint positions, the sine of q3, and the tool's distance from the base's axis.

    The sines are correct to far more digits than the error that is let pass.
    """
    if max(map(abs, row[:3])) > _LARGEST_ANGLE:
        raise Fault(f"a joint turns by more than {_LARGEST_ANGLE:g} rad")
    q1, q2, q3 = map(Fraction, row[:3])
    (s1, c1), (s2, c2), (s3, _), (s23, c23) = map(nearly_sine_and_cosine, (q1, q2, q3, q2 + q3))
    forearm = arm.lower + Fraction(row[4])
    out = arm.upper * s2 + forearm * s23
    x, y, z = arm.base
    up = z + arm.height + arm.upper * c2 + forearm * c23
    return (x + out * s1, y - out * c1, up), s3, out


def point_at(curve: ExactCurve, at: Fraction) -> Vec3:
    """Place on a curve.

    Raises:
        Fault: the curve has no such parameter.
    """
    for start, end, span in curve.spans:
        if start <= at <= end:
            return curve.points(span, at, at)[0]
    raise Fault(f"{float(at):g} is not on the curve")


def _gap(a: Vec3, b: Vec3) -> Fraction:
    return max(map(abs, sub(a, b)))


def _mixed(a: tuple[float, ...], b: tuple[float, ...], share: float) -> tuple[float, ...]:
    return tuple((1 - share) * p + share * q for p, q in zip(a, b, strict=True))


def _squared(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    return sum((p - q) ** 2 for p, q in zip(a, b, strict=True))


def _parameter(entry: tuple[float, tuple[float, ...]]) -> float:
    return entry[0]

"""Check that a plan's curves and motion are those of its scene, in exact rational numbers.

A curve must lead from start to goal. The tool of the paper's arm, from the joint positions as
written, must pass along the curve in order, on the side of the elbow and with the slide for which
the certificate holds.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
import scipy

from abi.arrays import BoolArray, FloatArray
from abi.scene.scene import Scene
from abi.verify.exact.frame import nearly_sine_and_cosine
from abi.verify.exact.paper_arm import ExactArm
from abi.verify.exact.slide import ExactSlide
from abi.verify.exact.solids import ExactCurve, Vec3, sub, vector
from abi.verify.fault import Fault
from abi.verify.plan_fields import list_of, numbers_of
from abi.verify.samples import check_samples, check_tool_points

_ROUNDING = Fraction(1, 10**9)
"""Accepted error at start and goal, over the largest coordinate of the workspace."""
_REACHED = Fraction(1, 10**7)
"""Accepted error of the tool, over the length of the arm."""
_LARGEST_ANGLE = 1e4
_PARTS = 32  # of each polynomial
_STEPS = 6
_JOINTS = ("q1", "q2", "q3", "q4", "q5", "q6")
_SWINGING = [0, 1, 2]
"""Numbers of those that turn links about other axes than their own."""


def check_ends(curve: ExactCurve, scene: Scene) -> None:
    """Check that a curve leads from the scene's start to its goal, up to rounding.

    Raises:
        Fault: it does not.
    """
    box = scene.workspace
    allowed = _ROUNDING * Fraction(max(map(abs, (*box.min, *box.max))))
    ends = curve[0].bezier[0], curve[-1].bezier[-1]
    for name, end, point in zip(("start", "goal"), ends, (scene.start, scene.goal), strict=True):
        if _gap(end, vector(point)) > allowed:
            raise Fault(f"the curve is not at the scene's {name}")


def check_tool(
    section: dict[str, Any],
    timing: dict[str, Any],
    arm: ExactArm,
    curve: ExactCurve,
    slide: ExactSlide,
) -> None:
    """Check that the joint positions of a plan move the tool along the curve, from end to end.

    Raises:
        Fault: they do not.
        SceneError: a field has the wrong form.
    """
    label = "arm.positions"
    rows = [numbers_of(label, row) for row in list_of(label, section.get("positions"))]
    check_samples(section, timing, _JOINTS)
    times = numbers_of("arm.time", section.get("time"))
    if any(len(row) != len(_JOINTS) for row in rows):
        raise Fault(f"its positions are not of {len(_JOINTS)} joints")
    turns = np.abs(np.diff(np.array(rows), axis=0))[:, _SWINGING]
    if (turns >= np.pi).any():  # the tool is the same a whole turn later
        raise Fault("a joint turns by half a turn or more between two samples")
    allowed = _REACHED * (arm.upper + arm.lower)
    check_tool_points(section, partial(_tool, arm), allowed)
    placed = [_placed(arm, row) for row in rows]
    along = _followed(curve, [tool for tool, _, _ in placed], allowed)
    first, last = curve[0].bezier[0], curve[-1].bezier[-1]
    for number, (row, time, (tool, sine, out)) in enumerate(zip(rows, times, placed, strict=True)):
        if sine * arm.side <= 0 or out <= 0:
            raise Fault(f"at {time:g} s its elbow is on the other side")
        ends = [first] * (number == 0) + [last] * (number == len(rows) - 1)
        at = next(along, None)
        if at is None or any(_gap(tool, end) > allowed for end in ends):
            raise Fault(f"at {time:g} s the tool tip is not where it is on the curve")
        slid, q5 = slide(Fraction(at), Fraction(at)), Fraction(row[4])
        if not slid.low - allowed <= q5 <= slid.high + allowed:
            raise Fault(f"at {time:g} s its slide is not where it is on the curve")


def _followed(curve: ExactCurve, tools: Sequence[Vec3], allowed: Fraction) -> Iterator[float]:
    """Parameters at which a curve is at tools, one after the other; they end where there is none.

    They are sought in floating point, and what is found is checked exactly.
    """
    with np.errstate(all="ignore"):
        breaks = [*(float(span.start) for span in curve), float(curve[-1].end)]
        bezier = np.array([span.bezier for span in curve], dtype=np.float64)
        places = scipy.interpolate.BPoly(bezier.swapaxes(0, 1), breaks)
        slopes, ends = places.derivative(), itertools.pairwise(breaks)
        parts = [np.linspace(low, high, _PARTS, endpoint=False) for low, high in ends]
        grid: FloatArray = np.concatenate([*parts, breaks[-1:]])
        on_grid, behind = np.asarray(places(grid)), breaks[0]
    for tool in tools:
        target = np.array(tool, dtype=np.float64)
        later = int(np.searchsorted(grid, behind, side="right"))
        few = np.append(behind, grid[later:])
        guesses = few[_nearer(np.vstack([places(behind), on_grid[later:]]), target)].tolist()
        span = behind, breaks[-1]
        found = (_nearest(places, slopes, target, guess, span) for guess in guesses)
        near = (at for at in found if _gap(point_at(curve, Fraction(at)), tool) <= allowed)
        at = next(near, None)
        if at is None:
            return
        yield at
        behind = at


# a damaged curve may leave the numbers: what is found is checked exactly
@np.errstate(all="ignore")
def _nearer(places: FloatArray, target: FloatArray) -> BoolArray:
    """Flags of the places (k, 3) that are no farther from a target than their neighbours."""
    away = ((places - target) ** 2).sum(axis=1)
    around = np.concatenate([[np.inf], away, [np.inf]])
    return np.asarray((around[:-2] >= away) & (away <= around[2:]))


@np.errstate(all="ignore")
def _nearest(
    places: Any, slopes: Any, target: FloatArray, at: float, span: tuple[float, float]
) -> float:
    """Refine a parameter between two by Gauss-Newton steps while they are finite.

    Args:
        places: function from a parameter to a place, (3,).
        slopes: its derivative.
        target: the place that is to be near, (3,).
        at: the parameter.
        span: the least and the largest.
    """
    for _ in range(_STEPS):
        slope = slopes(at)
        step = (target - places(at)) @ slope / (slope @ slope)
        if np.isnan(step):
            break
        at = min(max(at + float(step), span[0]), span[1])
    return at


def _tool(arm: ExactArm, row: Sequence[Fraction]) -> Vec3:
    """Tool at joint positions."""
    return _placed(arm, [float(one) for one in row])[0]


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
    for span in curve:
        if span.start <= at <= span.end:
            return span.points(at, at)[0]
    raise Fault(f"{float(at):g} is not on the curve")


def _gap(a: Vec3, b: Vec3) -> Fraction:
    return max(map(abs, sub(a, b)))

"""Measures: numbers of a plan by name, which lessons ask about, wait for and quote."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sized
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from abi.planner.plan import Plan
from abi.search.search import SEARCHES, SearchResult
from app.state.bent_curve import changed_share, moved_points
from app.state.frame import Frame
from app.ui.numbers import (
    distance_to_show,
    format_count,
    format_length,
    format_lower_bound,
    format_setting,
    with_minus,
)

Measure = Callable[[Frame], float | None]
"""A number of the frame; None if it has no value."""

_PLACE = re.compile(r"\{\{\s*([a-z_.0-9]+)\s*\}\}")


def _number(path: str, frame: Frame) -> float | None:
    """Number, or number of entries, at an attribute path from the frame."""
    found: Any = frame
    for name in path.split("."):
        if found is None:
            return None
        found = getattr(found, name)
    if isinstance(found, Sized):
        return len(found)
    return None if found is None else float(found)


def _searched(name: str, attribute: str, frame: Frame) -> float | None:
    found: dict[str, SearchResult] = {result.algorithm: result for result in frame.plan.searches}
    return float(getattr(found[name], attribute)) if name in found else None


def _gap(length: float | None, plan: Plan) -> float | None:
    """Excess of a length over the optimum, [%]."""
    if length is None:
        return None
    return 100 * (length / _least(plan) - 1)


def _least(plan: Plan) -> float:
    return plan.straight_length if plan.optimum is None else plan.optimum.length


def _clearance(plan: Plan, name: str) -> float | None:
    fit = plan.curves[name]
    if fit is None or math.isinf(fit.clearance.distance):
        return None
    return distance_to_show(fit.clearance)


def _is_complete(plan: Plan) -> bool:
    """Check whether there is a plan whose followed curve, if any, keeps the clearance.

    A motion that was found in the space of the joints follows none.
    """
    curve = plan.followed_curve
    holds = plan.joint_search is not None or (curve is not None and curve.holds)
    return plan.error is None and holds


def _axis_speed(plan: Plan, place: float) -> float | None:
    """Size of the quadratic's derivative by its own parameter, at a fraction of the interval."""
    if plan.quadratic is None:
        return None
    curve = plan.quadratic.curve
    first, last = curve.interval
    return float(np.linalg.norm(curve(np.array([first + place * (last - first)]), 1)[0]))


def _joint_nodes(frame: Frame) -> float | None:
    """Number of poses in both trees of a joint-space search."""
    search = frame.plan.joint_search
    return None if search is None else sum(len(tree.positions) for tree in search.trees)


def _tool_length(frame: Frame) -> float | None:
    """Path length of the tool tip over the motion's samples, [unit]."""
    motion = frame.plan.motion
    if motion is None:
        return None
    return float(np.linalg.norm(np.diff(motion.tool, axis=0), axis=1).sum())


def _phase(name: str, frame: Frame) -> float | None:
    """Duration of one of a motion's three phases, [s]."""
    return getattr(frame.plan.profile, name, None)


MEASURES: Mapping[str, Measure] = MappingProxyType(
    {
        "mesh.nodes": partial(_number, "plan.free.nodes"),
        "mesh.excluded": lambda f: None if f.plan.free is None else int(f.plan.free.excluded.sum()),
        "mesh.pitch": partial(_number, "plan.mesh.pitch"),
        "mesh.asked": partial(_number, "plan.scene.mesh.pitch"),
        "graph.edges": partial(_number, "plan.graph.edge_count"),
        "graph.crossing": partial(_number, "plan.graph.crossing"),
        "path.length": partial(_number, "plan.path.length"),
        "path.hops": partial(_number, "plan.path.hops"),
        "path.gap": lambda f: None if f.plan.path is None else _gap(f.plan.path.length, f.plan),
        "path.clearance": lambda f: None if f.plan.path is None else f.plan.path_clearance,
        **{
            f"{name}.{attribute}": partial(_searched, name, attribute)
            for name in SEARCHES
            for attribute in ("length", "hops", "expanded", "relaxed")
        },
        "taut.length": partial(_number, "plan.taut.length"),
        "taut.gap": lambda f: None if f.plan.taut is None else _gap(f.plan.taut.length, f.plan),
        "optimum.length": lambda f: _least(f.plan),
        "straight.length": partial(_number, "plan.straight_length"),
        "clearance.wanted": partial(_number, "plan.scene.spline.clearance"),
        "bspline.length": partial(_number, "plan.bspline_arc.length"),
        "bspline.degree": partial(_number, "plan.scene.spline.degree"),
        "bspline.clearance": lambda f: _clearance(f.plan, "bspline"),
        "bspline.points": partial(_number, "plan.bspline.curve.control_points"),
        "bent.moved": lambda f: (
            None if f.bent is None else int(moved_points(f.plan, f.bent.curve).sum())
        ),
        "bent.length": partial(_number, "bent.arc.length"),
        "bent.changed": lambda f: (
            None if f.bent is None else 100 * changed_share(f.plan, f.bent.curve)
        ),
        "bent.clearance": lambda f: None if f.bent is None else distance_to_show(f.bent.clearance),
        "quadratic.length": partial(_number, "plan.quadratic_arc.length"),
        "quadratic.clearance": lambda f: _clearance(f.plan, "quadratic"),
        "quadratic.clear": partial(_number, "plan.quadratic.holds"),
        "quadratic.pieces": partial(_number, "plan.quadratic.curve.pieces"),
        "quadratic.speed_first": lambda f: _axis_speed(f.plan, 0.0),
        "quadratic.speed_middle": lambda f: _axis_speed(f.plan, 0.5),
        "quadratic.speed_last": lambda f: _axis_speed(f.plan, 1.0),
        "curve.length": partial(_number, "plan.followed_arc.length"),
        "motion.speed": partial(_number, "plan.scene.motion.speed"),
        "motion.a": partial(_number, "plan.scene.motion.acceleration"),
        "motion.b": partial(_number, "plan.scene.motion.deceleration"),
        **{f"motion.{phase}": partial(_phase, phase) for phase in ("t1", "t2", "t3")},
        "motion.duration": partial(_number, "plan.profile.duration"),
        "motion.peak": partial(_number, "plan.profile.peak_speed"),
        "arm.clearance": partial(_number, "plan.arm_clearance.distance"),
        "arm.reaches": partial(_number, "plan.motion.reachable"),
        "tool.length": _tool_length,
        "joints.nodes": _joint_nodes,
        "joints.proofs": partial(_number, "plan.joint_search.proofs"),
        "joints.refused": partial(_number, "plan.joint_search.refused"),
        "plan.complete": lambda f: float(_is_complete(f.plan) and f.plan.is_arm_clear),
        "plan.tool_complete": lambda f: float(_is_complete(f.plan)),
        "search.step": partial(_number, "theatre.state.step"),
        "search.done": partial(_number, "theatre.state.done"),
        "search.length": partial(_number, "theatre.state.trace.length"),
        "search.cost": partial(_number, "theatre.state.trace.cost"),
        "search.cycle": lambda f: (
            None if f.theatre is None else float(len(f.theatre.state.trace.cycle) > 0)
        ),
        "playback.time": partial(_number, "time"),
    }
)
"""The measures by name."""

_COUNTS = {"nodes", "excluded", "edges", "crossing", "hops", "expanded", "relaxed", "points"}
_COUNTS |= {"degree", "pieces", "step", "moved", "changed", "proofs", "refused"}
_LENGTHS = {"length", "clearance", "wanted", "pitch", "asked"}
_SETTINGS = {"wanted", "asked", "speed", "a", "b"}
_LOWER_BOUNDS = {"optimum.length"}


def text(name: str, frame: Frame) -> str:
    """Format a measure, lengths with their unit; lower bounds are rounded down."""
    number = MEASURES[name](frame)
    if number is None or not math.isfinite(number):
        return "–"
    last = name.rsplit(".", 1)[-1]
    if last in _COUNTS:
        return format_count(int(number))
    unit = f" {frame.plan.scene.unit}" if last in _LENGTHS else ""
    if last == "peak":
        unit = f" {frame.plan.scene.unit}/s"
    if last == "gap":
        if 0 < number < 0.05:  # the lengths beside it differ
            return "under 0.1"
        return with_minus(f"{number:.1f}")
    if last in _SETTINGS:
        return format_setting(number) + unit
    is_bound = last == "clearance" or name in _LOWER_BOUNDS
    if name == "arm.clearance" and number < 0:  # a depth, as the message over the scene tells it
        is_bound = False
    return (format_lower_bound if is_bound else format_length)(number) + unit


def names_in(template: str) -> list[str]:
    """Measures that a text quotes as ``{{path.length}}``."""
    return _PLACE.findall(template)


def filled(template: str, frame: Frame) -> str:
    """Fill in the present numbers of a text."""
    return _PLACE.sub(lambda match: text(match[1], frame), template)

"""Measures: numbers of a plan by name, which lessons ask about, wait for and quote."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sized
from types import MappingProxyType
from typing import Any

import numpy as np

from abi.planner.plan import Plan
from abi.search.search import SearchResult
from app.frame import Frame
from app.numbers import (
    distance_to_show,
    format_count,
    format_length,
    format_lower_bound,
    format_setting,
)

Measure = Callable[[Frame], float | None]
"""A number of the frame; None where there is none."""

_PLACE = re.compile(r"\{\{\s*([a-z_.0-9]+)\s*\}\}")


def _at(path: str) -> Measure:
    """The number, or how many there are, at a path of attributes from the frame on."""
    return lambda frame: _number(frame, path)


def _number(frame: Frame, path: str) -> float | None:
    found: Any = frame
    for name in path.split("."):
        if found is None:
            return None
        found = getattr(found, name)
    if isinstance(found, Sized):
        return len(found)
    return None if found is None else float(found)


def _of_search(name: str, attribute: str) -> Measure:
    return lambda frame: _searched(frame.plan, name, attribute)


def _searched(plan: Plan, name: str, attribute: str) -> float | None:
    found: dict[str, SearchResult] = {result.algorithm: result for result in plan.searches}
    return float(getattr(found[name], attribute)) if name in found else None


def _gap(length: float | None, plan: Plan) -> float | None:
    """By how many percent a length is over the least possible."""
    if length is None:
        return None
    least = plan.straight_length if plan.optimum is None else plan.optimum.length
    return 100 * (length / least - 1)


def _clearance(plan: Plan, name: str) -> float | None:
    fit = plan.bspline if name == "bspline" else plan.quadratic
    if fit is None or math.isinf(fit.clearance.distance):
        return None
    return distance_to_show(fit.clearance)


def _is_complete(plan: Plan) -> bool:
    """Check whether there is a plan along a curve that keeps the clearance, for the tool alone."""
    curve = plan.followed_curve
    return plan.error is None and curve is not None and curve.holds


def _axis_speed(plan: Plan, place: float) -> float | None:
    """Size of the quadratic's derivative in t, of its own parameter, at a share of its interval."""
    if plan.quadratic is None:
        return None
    curve = plan.quadratic.curve
    first, last = curve.interval
    return float(np.linalg.norm(curve(np.array([first + place * (last - first)]), 1)[0]))


MEASURES: Mapping[str, Measure] = MappingProxyType(
    {
        "mesh.nodes": _at("plan.free.nodes"),
        "mesh.excluded": lambda f: None if f.plan.free is None else int(f.plan.free.excluded.sum()),
        "mesh.pitch": _at("plan.mesh.pitch"),
        "graph.edges": _at("plan.graph.edge_count"),
        "graph.crossing": _at("plan.graph.crossing"),
        "path.length": _at("plan.path.length"),
        "path.hops": _at("plan.path.hops"),
        "path.gap": lambda f: None if f.plan.path is None else _gap(f.plan.path.length, f.plan),
        "path.clearance": lambda f: None if f.plan.path is None else f.plan.path_clearance,
        **{
            f"{name}.{attribute}": _of_search(name, attribute)
            for name in ("a_star", "dijkstra", "bellman_ford")
            for attribute in ("length", "hops", "expanded", "relaxed")
        },
        "taut.length": _at("plan.taut.length"),
        "taut.gap": lambda f: None if f.plan.taut is None else _gap(f.plan.taut.length, f.plan),
        "optimum.length": lambda f: (
            f.plan.straight_length if f.plan.optimum is None else f.plan.optimum.length
        ),
        "straight.length": _at("plan.straight_length"),
        "clearance.wanted": _at("plan.scene.spline.clearance"),
        "bspline.length": _at("plan.bspline_arc.length"),
        "bspline.degree": _at("plan.scene.spline.degree"),
        "bspline.clearance": lambda f: _clearance(f.plan, "bspline"),
        "bspline.points": _at("plan.bspline.curve.control_points"),
        "quadratic.length": _at("plan.quadratic_arc.length"),
        "quadratic.clearance": lambda f: _clearance(f.plan, "quadratic"),
        "quadratic.clear": _at("plan.quadratic.holds"),
        "quadratic.pieces": _at("plan.quadratic.curve.pieces"),
        "quadratic.speed_first": lambda f: _axis_speed(f.plan, 0.0),
        "quadratic.speed_middle": lambda f: _axis_speed(f.plan, 0.5),
        "quadratic.speed_last": lambda f: _axis_speed(f.plan, 1.0),
        "curve.length": _at("plan.followed_arc.length"),
        "motion.speed": _at("plan.scene.motion.speed"),
        "motion.a": _at("plan.scene.motion.acceleration"),
        "motion.b": _at("plan.scene.motion.deceleration"),
        "motion.t1": lambda f: getattr(f.plan.profile, "t1", None),
        "motion.t2": lambda f: getattr(f.plan.profile, "t2", None),
        "motion.t3": lambda f: getattr(f.plan.profile, "t3", None),
        "motion.duration": _at("plan.profile.duration"),
        "motion.peak": _at("plan.profile.peak_speed"),
        "arm.clearance": _at("plan.arm_clearance.distance"),
        "arm.reaches": _at("plan.motion.reachable"),
        "plan.complete": lambda f: float(_is_complete(f.plan) and f.plan.is_arm_clear),
        "plan.tool_complete": lambda f: float(_is_complete(f.plan)),
        "search.step": _at("theatre.state.step"),
        "search.done": _at("theatre.state.done"),
        "search.length": _at("theatre.state.trace.length"),
        "search.cost": _at("theatre.state.trace.cost"),
        "search.cycle": lambda f: (
            None if f.theatre is None else float(len(f.theatre.state.trace.cycle) > 0)
        ),
        "playback.time": _at("time"),
    }
)
"""The numbers by name."""

_COUNTS = {"nodes", "excluded", "edges", "crossing", "hops", "expanded", "relaxed", "points"}
_COUNTS |= {"degree", "pieces", "step"}
_LENGTHS = {"length", "clearance", "wanted", "pitch"}
_SETTINGS = {"wanted", "speed", "a", "b"}
_LOWER_BOUNDS = {"optimum.length"}


def value(name: str, frame: Frame) -> float | None:
    """A measure of the frame; None where there is none."""
    return MEASURES[name](frame)


def text(name: str, frame: Frame) -> str:
    """A measure as it is read, lengths with their unit; lower bounds are rounded down."""
    number = value(name, frame)
    if number is None or not math.isfinite(number):
        return "–"
    last = name.rsplit(".", 1)[-1]
    if last in _COUNTS:
        return format_count(int(number))
    unit = f" {frame.plan.scene.unit}" if last in _LENGTHS else ""
    if last == "peak":
        unit = f" {frame.plan.scene.unit}/s"
    if last == "gap":
        return f"{number:.1f}"
    if last in _SETTINGS:
        return format_setting(number) + unit
    is_bound = last == "clearance" or name in _LOWER_BOUNDS
    return (format_lower_bound if is_bound else format_length)(number) + unit


def names_in(template: str) -> list[str]:
    """Measures that a text names as ``{{path.length}}``."""
    return _PLACE.findall(template)


def filled(template: str, frame: Frame) -> str:
    """The text with the present numbers in it."""
    return _PLACE.sub(lambda match: text(match[1], frame), template)

"""Table of the stages of the method: what the page says and shows of each.

The headings of the left panel, the lecture's steps and the large numbers are made of it. A new
stage is a row here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from abi.planner.arm_words import arm_result
from abi.planner.plan import Plan
from abi.search.search import SEARCHES
from app.stages import stage_numbers, stage_results
from app.stages.curve_numbers import Number

_ALWAYS = frozenset({"workspace", "axes", "obstacles"})


class ShownStage(NamedTuple):
    """What the page says and shows of a stage.

    Attributes:
        title: its name.
        sentence: what it does, to be read from afar.
        result: its result in a plan, short enough for its heading; empty where there is none.
        numbers: its large numbers; none where the plan did not get so far.
        layers: switches of the legend that a lecture has on while it shows this stage.
        fields: sections of a scene that are its inputs.
        failure: its result where the plan ends in it; empty where ``result`` says so.
        errors: further names that an error may have for it.
    """

    title: str
    sentence: str
    result: Callable[[Plan], str]
    numbers: Callable[[Plan], list[Number]]
    layers: frozenset[str]
    fields: tuple[str, ...] = ()
    failure: str = ""
    errors: tuple[str, ...] = ()


SHOWN_STAGES = {
    "mesh": ShownStage(
        "Mesh",
        "The workspace becomes nodes; those in an obstacle, or too near one, are removed.",
        stage_results.mesh_result,
        stage_numbers.mesh_numbers,
        _ALWAYS | {"edges", "nodes", "excluded"},
        fields=("mesh",),
    ),
    "graph": ShownStage(
        "Graph",
        "What is left of the mesh is a graph, and every edge of it is clear.",
        stage_results.graph_result,
        stage_numbers.graph_numbers,
        _ALWAYS | {"edges", "nodes"},
        failure="blocked ✗",
    ),
    "search": ShownStage(
        "Search",
        "Of all paths along the edges, find the shortest.",
        stage_results.search_result,
        stage_numbers.search_numbers,
        _ALWAYS | {*SEARCHES, "taut", "names"},
        fields=("search",),
        failure="no path ✗",
    ),
    "bspline": ShownStage(
        "B-spline",
        "A smooth curve near the path, proven to stay clear.",
        stage_results.bspline_result,
        stage_numbers.bspline_numbers,
        _ALWAYS | {"a_star", "taut", "bspline", "control", "names"},
        fields=("spline",),
        failure="too close ✗",
    ),
    "quadratic": ShownStage(
        "Quadratic",
        "A simple formula instead of the spline, where one stays clear.",
        stage_results.quadratic_result,
        stage_numbers.quadratic_numbers,
        _ALWAYS | {"bspline", "quadratic", "names"},
        fields=("quadratic", "motion"),
        errors=("timing",),
    ),
    "arm": ShownStage(
        "Arm",
        "Joint angles for each moment of the motion.",
        arm_result,
        stage_numbers.arm_numbers,
        _ALWAYS | {"bspline", "quadratic", "arm", "trace", "names"},
        fields=("arm",),
    ),
}
"""The stages in order, by the names that plans have for them."""
STAGE_OF_ERROR = {part: name for name, one in SHOWN_STAGES.items() for part in (name, *one.errors)}
"""Stage beside which an error is shown, by the name that the error has for its stage."""
TITLES = {name: f"{k} · {stage.title}" for k, (name, stage) in enumerate(SHOWN_STAGES.items(), 1)}
"""Headings of the stages, numbered."""

"""The plan as one HTML file that plays by itself: its stages, its search, and the arm's motion.

The page's script does its own projection and draws in two dimensions, so the file needs no server,
library or graphics card; it contains the numbers that the drawing needs, rounded.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from abi import assets
from abi.arrays import FloatArray
from abi.curves.curve import Curve
from abi.errors import AbiError
from abi.explain.arm_faults import arm_faults, limits_warning
from abi.export.carried_objects import carried_objects
from abi.obstacles.obstacle_set import Obstacles
from abi.planner.arm_words import clearance_sentence
from abi.planner.own_search import OWN, expanded_by_a_star
from abi.planner.plan import Plan
from abi.search.compare import COMPARED
from abi.search.search import search
from abi.search.subset import evenly, subset

EDGES = 5_000
"""Most mesh edges that are drawn, those near path and obstacles."""
EXPANSIONS = 4_000
"""Most expanded nodes that are drawn, evenly spaced."""
FACES = 3_000
"""Most triangles of an obstacle that are drawn."""
_CURVE, _POSES = 161, 121  # samples
_DIGITS = 5
_SEARCH_SECONDS = 8.0


def write(plan: Plan, name: str) -> bytes:
    """Write the page.

    Raises:
        AbiError: the plan has no mesh, so there is nothing to show.
    """
    if plan.free is None:
        raise AbiError("A plan without a mesh cannot be shown.", "See its error.")
    return page_of("page.html", page_data(plan))


def page_of(template: str, data: dict[str, Any]) -> bytes:
    """A page of data and the script that draws it, from a template in ``assets/export``."""
    # what could end the script's element is written as an escape
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    page = _asset(template).replace("/*DRAWING*/", _asset("drawing.js"))
    return page.replace("/*PLAN*/", text).encode()


def _asset(name: str) -> str:
    return assets.path("export", name).read_text(encoding="utf-8")


def page_data(plan: Plan) -> dict[str, Any]:
    """Data of the drawing and the text beside it; the plan has a mesh."""
    assert plan.free is not None
    scene = plan.scene
    near = np.array([scene.start]) if plan.path is None else plan.path.points
    nodes, edges, excluded = subset(plan.free, plan.graph, scene.obstacles, near, "near", EDGES)
    order = _order(plan)
    corners = np.array([scene.workspace.min, scene.workspace.max, scene.arm.base])
    return {
        "workspace": [list(scene.workspace.min), list(scene.workspace.max)],
        "box": [corners.min(axis=0).tolist(), corners.max(axis=0).tolist()],
        "start": list(scene.start),
        "goal": list(scene.goal),
        "faces": rounded(_faces(_standing(plan))),
        "nodes": rounded(nodes),
        "edges": edges.tolist(),
        "removed": rounded(excluded[:: max(1, len(excluded) // 500)]),
        "order": rounded(order),
        "expanded": 0 if plan.path is None else plan.path.expanded,
        "path": [] if plan.path is None else rounded(plan.path.points),
        "taut": [] if plan.taut is None else rounded(plan.taut.points),
        "bspline": [] if plan.bspline is None else _sampled(plan.bspline.curve),
        "control": [] if plan.bspline is None else rounded(plan.bspline.curve.control_points),
        "quadratic": [] if plan.quadratic is None else _sampled(plan.quadratic.curve),
        "arm": _arm(plan),
        "steps": _steps(plan),
    }


def _order(plan: Plan) -> FloatArray:
    """Positions (k, 3) of the nodes that the chosen search expanded, in order, [unit]."""
    if plan.path is None or plan.graph is None:
        return np.zeros((0, 3))
    return plan.graph.places(evenly(plan.path.order, EXPANSIONS))


def _steps(plan: Plan) -> list[dict[str, Any]]:
    """Stages in order: names, sentences with numbers, what each draws, and its bar."""
    assert plan.free is not None
    unit = plan.scene.unit
    steps = [_step("1 Mesh", "A mesh of tetrahedra", f"{plan.free.nodes:,} free nodes.", ["mesh"])]
    if plan.graph is not None:
        text = f"{plan.graph.edge_count:,} edges, each clear along its whole length."
        steps.append(_step("2 Graph", "The graph of what is left", text, ["mesh"]))
    if plan.path is not None:
        own = plan.path.algorithm == OWN
        length = _length(plan.path.length, unit)
        text = f"{plan.path.expanded:,} nodes visited, dark first; the path is {length} long."
        text += _beside_ours(plan) if own else ""
        title = "The path of your search" if own else _by(plan.path.algorithm)
        step = _step("3 Search", title, text, ["search"])
        steps.append(step | {"bar": "search", "seconds": _SEARCH_SECONDS})
    if plan.taut is not None:
        text = f"{_length(plan.taut.length, unit)}, freed of the edges' directions."
        steps.append(_step("3½ Taut", "The path pulled taut", text, ["path", "taut"]))
    if plan.bspline is not None and plan.bspline_arc is not None:
        text = f"{_length(plan.bspline_arc.length, unit)}, {_kept(plan, 'bspline')}."
        steps.append(_step("4 B-spline", "A smooth curve", text, ["path", "bspline"]))
    if plan.quadratic is not None and plan.quadratic_arc is not None:
        text = f"{_length(plan.quadratic_arc.length, unit)}, {_kept(plan, 'quadratic')}."
        steps.append(_step("5 Quadratic", "A simple formula", text, ["bspline", "quadratic"]))
    if plan.motion is not None and (plan.followed or plan.joint_search):
        steps.append(_arm_step(plan, float(plan.motion.time[-1])))
    if plan.error is not None and plan.error.message not in steps[-1]["text"]:
        steps[-1]["text"] += f" {plan.error.message}"
    return steps


def _by(algorithm: str) -> str:
    return f"The shortest path, by {COMPARED[algorithm].label}"


def _beside_ours(plan: Plan) -> str:
    """A*'s expanded nodes on the same graph, and the shortest length, beside a user's search."""
    assert plan.graph is not None
    straight, grid = expanded_by_a_star(plan.graph)
    least = search("a_star", plan.graph, "length").length
    return (
        f" A* visits {straight:,} with the straight distance as its heuristic, and {grid:,} with "
        "the distance along this grid's own edges, which says more of what is left and still "
        f"never too much; the shortest path is {_length(least, plan.scene.unit)}."
    )


def _step(name: str, title: str, text: str, draw: list[str]) -> dict[str, Any]:
    return {"name": name, "title": title, "text": text, "draw": draw, "bar": "", "seconds": 0}


def _arm_step(plan: Plan, duration: float) -> dict[str, Any]:
    """The last stage: whether the whole arm is clear, or what it touches, when and how deeply."""
    faults = [*arm_faults(plan), *filter(None, [limits_warning(plan)])]
    unproven = "The motion is NOT proven clear. " if arm_faults(plan) else ""
    name = {"bspline": "B-spline", "quadratic": "quadratic"}.get(plan.followed or "")
    text = f"The arm follows the {name}. " if name else "The joints follow a curve of their own. "
    text += f"✗ {unproven}{' '.join(faults)}" if faults else clearance_sentence(plan)
    text = " ".join((text, *plan.not_compared))
    step = _step(
        "6 Arm ✗" if faults else "6 Arm",
        "The motion",
        text,
        [*filter(None, [plan.followed]), "arm"],
    )
    return step | {"bar": "time", "seconds": duration}


def _kept(plan: Plan, name: str) -> str:
    """Phrase on whether a curve keeps the clearance, or only the tool tip along it."""
    fit = plan.curves[name]
    if fit is None or not fit.holds:
        return "✗ nearer to an obstacle than asked"
    if plan.followed == name and not plan.is_arm_clear:
        return "proven to keep the clearance, by the tool tip alone"
    return "proven to keep the clearance"


def _length(length: float, unit: str) -> str:
    return f"{length:.3f} {unit}"


def _arm(plan: Plan) -> dict[str, Any]:
    """Capsules of the links, which of them touch something, and the tool, at moments in time."""
    if plan.motion is None or plan.arm is None:
        return {"time": [0.0], "links": [[]], "radii": [], "tool": [], "touching": [[]]}
    last = len(plan.motion.time) - 1
    clearance = plan.arm_clearance
    contacts = () if clearance is None else clearance.contacts
    # one that is over before the next pose is seen, too
    deepest = np.searchsorted(plan.motion.time, [contact.time for contact in contacts])
    evenly = np.linspace(0, last, min(_POSES, last + 1)).round().astype(int)
    chosen = np.unique(np.concatenate([evenly, np.minimum(deepest, last)]))
    time = plan.motion.time[chosen]
    names, radii = list(plan.arm.capsule_links), plan.arm.radii.tolist()
    poses = [plan.arm.place(plan.motion.positions[chosen])]
    for one in carried_objects(plan):
        if one.is_taken:  # what is held from the start is a body of the arm
            samples = np.clip(chosen, one.first, one.last)
            of_it = [k for k, link in enumerate(one.arm.capsule_links) if link == one.link]
            names += [one.link] * len(of_it)
            radii += one.arm.radii[of_it].tolist()
            poses.append(one.arm.place(plan.motion.positions[samples])[:, of_it])
    touching = [frozenset() if clearance is None else clearance.touching(one) for one in time]
    return {
        "time": rounded(time),
        "links": rounded(np.concatenate(poses, axis=1)),
        "radii": list(map(_round, radii)),
        "tool": rounded(plan.motion.tool[chosen]),
        "touching": [
            [row for row, name in enumerate(names) if name in links] for links in touching
        ],
    }


def _standing(plan: Plan) -> Obstacles:
    """The obstacles that are never carried."""
    carried = {one.number for one in carried_objects(plan)}
    return tuple(one for k, one in enumerate(plan.scene.obstacles) if k not in carried)


def _sampled(curve: Curve) -> Any:
    return rounded(curve(np.linspace(*curve.interval, _CURVE)))


def _faces(obstacles: Obstacles) -> FloatArray:
    """Triangles (m, 3, 3) of the obstacles' surfaces, [unit], world."""
    # of a fine surface every few triangles still show its shape
    shown = [evenly(one.triangles(), FACES) for one in obstacles]
    return np.concatenate([np.zeros((0, 3, 3)), *shown])


def rounded(array: FloatArray) -> Any:
    """The numbers as lists, rounded to what a drawing shows."""
    largest = float(np.abs(array).max(initial=0.0))
    digits = _DIGITS - (math.floor(math.log10(largest)) + 1 if largest > 0 else 0)
    return np.round(array, max(digits, 0)).tolist()


def _round(number: float) -> float:
    return float(f"{number:.{_DIGITS}g}")

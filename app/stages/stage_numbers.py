"""The large numbers of each stage, for a lecture that goes through the stages."""

from __future__ import annotations

import html
import math

from abi.curves.three_phase_profile import ThreePhaseProfile
from abi.planner.plan import Plan
from app.stages.curve_numbers import Number, curve_numbers, excess, judged
from app.ui import style
from app.ui.numbers import format_count, format_length, format_lower_bound


def mesh_numbers(plan: Plan) -> list[Number]:
    """Numbers of nodes and tetrahedra that are left."""
    if plan.mesh is None or plan.free is None:
        return []
    removed = len(plan.mesh.points) - plan.free.nodes
    return [
        (format_count(plan.free.nodes), "free nodes", "Grid points in no obstacle."),
        (
            format_count(plan.free.tetrahedra_kept),
            "tetrahedra",
            "What is left of the mesh: those with all four corners free.",
        ),
        (
            format_count(removed),
            "nodes removed",
            "In an obstacle, or nearer to one than the clearance.",
        ),
    ]


def graph_numbers(plan: Plan) -> list[Number]:
    """Number of free edges, and edges per node."""
    graph = plan.graph
    if graph is None:
        return []
    open_edges = graph.edge_count - len(graph.tails)
    return [
        (
            f"{format_count(open_edges)} of {format_count(graph.mesh.edge_count)}",
            "edges open",
            "Edges of the grid that keep the clearance along their whole length.",
        ),
        (
            f"{2 * graph.edge_count / max(graph.free_nodes, 1):.1f}",
            "edges at each node",
            "On average: the ways that a search tries from a node.",
        ),
    ]


def search_numbers(plan: Plan) -> list[Number]:
    """Length of the path, its excess over the optimum, and visited nodes."""
    if plan.path is None or plan.graph is None:
        return []
    name = style.ALGORITHMS[plan.path.algorithm][0]
    visited = f"{format_count(plan.path.expanded)} of {format_count(plan.graph.free_nodes)}"
    return [
        (
            f"{format_length(plan.path.length)} {plan.scene.unit}",
            f"{name} path",
            "Length of the path along the grid's edges.",
        ),
        excess(plan, plan.path.length),
        (visited, "nodes visited", "Nodes that the search visited before it had the path."),
    ]


def bspline_numbers(plan: Plan) -> list[Number]:
    """Length, gap and kept distance of the B-spline."""
    return curve_numbers(plan, "bspline")


def quadratic_numbers(plan: Plan) -> list[Number]:
    """Kept distance of the curve if it is not followed, and speed and duration of the motion."""
    profile, unit = plan.profile, plan.scene.unit
    if profile is None or plan.quadratic is None:
        return []
    kept = [one for one in curve_numbers(plan, "quadratic") if "closest" in one[1]]
    numbers = [
        *kept,
        (
            f"{format_length(profile.peak_speed)} {unit}/s",
            "top speed",
            "Greatest speed of the tool tip along the curve that the arm follows.",
        ),
    ]
    if isinstance(profile, ThreePhaseProfile):
        phases = f"{profile.t1:.2f} + {profile.t2:.2f} + {profile.t3:.2f} s"
        hint = "Times of the three phases, one after the other."
        numbers.append((phases, "speed up, cruise, brake", hint))
    else:
        numbers.append((f"{profile.duration:.2f} s", "motion", "Time from start to goal."))
    return numbers


def arm_numbers(plan: Plan) -> list[Number]:
    """Duration of the motion, and clearance of the links."""
    if plan.profile is None or plan.motion is None or plan.arm_clearance is None:
        return []
    clearance, unit = plan.arm_clearance, plan.scene.unit
    time = (f"{plan.profile.duration:.2f} s", "motion", "Time from start to goal.")
    if plan.error is not None and plan.motion.reachable:
        return [(judged("no", False), "motion of the arm", html.escape(plan.error.message))]
    if not plan.motion.reachable:
        return [
            time,
            (judged("out", False), "of the arm's reach", "The arm cannot follow the curve."),
        ]
    if clearance.contacts:
        hint = "Deepest that a link goes into an obstacle, the floor or the arm itself."
        depth = f"{format_length(clearance.contacts[0].depth)} {unit}"
        return [time, (judged(depth, False), "deep a link collides", hint)]
    if math.isinf(clearance.distance):
        return [time]
    distance = f"{format_lower_bound(clearance.distance)} {unit}"
    shown = judged(distance, plan.is_arm_clear)
    hint = "Least distance of any link from the obstacles; proven if there is a ✓."
    return [time, (shown, "from link to obstacle, at least", hint)]

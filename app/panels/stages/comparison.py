"""Table of all searches on a plan's graph, with what it takes to mend the search before."""

from __future__ import annotations

from abi.planner.comparison import compare, minimised, search_problem
from abi.planner.plan import Plan
from abi.search.arcs import Arcs
from abi.search.compare import COMPARED
from abi.search.heuristic import Weight
from abi.search.lifelong_a_star import can_repair, lifelong_a_star
from abi.search.search_problem import SearchProblem
from abi.search.trace import SearchTrace
from app.ui import style
from app.ui.numbers import format_count, format_length, format_time, with_minus
from app.ui.table import table

_NOTE = (
    "<b>gap</b>: how far above the least cost (=), or below it by leaving the mesh's edges. "
    "<b>visited</b>: nodes, or rounds over all edges. <b>tried</b>: edges. If an edge costs its "
    "length, all exact searches find the same length. If each costs 1 (stage 3), they find equally "
    "few edges but different lengths, as in the paper's Table I."
)
_MENDING = "LPA* (lifelong A*) keeps its costs and repairs them where edges changed."


def comparison(plan: Plan, before: Plan | None) -> tuple[str, float]:
    """All searches on a plan's graph, as HTML, and the time that they took, [ms].

    With the plan ``before`` the search there is mended.
    """
    problem = search_problem(plan, heuristic_weight=1.5)
    found = compare(problem)
    mended = _mended(before, problem.arcs, problem.weight)
    anew, _ = found["a_star"]
    text = _table(found, problem, plan.scene.unit) + _told(mended, anew)
    return text, sum(ms for _, ms in found.values())


def _mended(before: Plan | None, arcs: Arcs, weight: Weight) -> tuple[int, int] | None:
    """Nodes that mending the search of the plan before visits, and nodes whose edges have changed.

    None where there was none between the same ends.
    """
    if before is None or before.graph is None:
        return None
    known = Arcs.of(before.graph, weight)
    if not can_repair(known, arcs):
        return None
    (_, _, order, _), changed = lifelong_a_star(known, arcs)
    return len(order), changed


def _told(mended: tuple[int, int] | None, a_star: SearchTrace) -> str:
    """Note on mending the search before, as HTML."""
    if mended is None:
        return style.paragraph(f"Move an obstacle and compare again: {_MENDING}")
    expanded, changed = mended
    visited, anew = format_count(expanded), format_count(a_star.steps)
    nodes = "node" if expanded == 1 else "nodes"
    return style.paragraph(
        f"Since the last plan, the edges of {format_count(changed)} nodes have changed. "
        f"{_MENDING} It visits <b>{visited}</b> {nodes}; A* from scratch, {anew}."
    )


def _visited(trace: SearchTrace) -> str:
    """Nodes visited; of a search that goes over all edges in rounds, how many of these."""
    count = format_count(trace.steps)
    return f"{count} rounds" if trace.queue == "rounds" else count


def _table(found: dict[str, tuple[SearchTrace, float]], problem: SearchProblem, unit: str) -> str:
    """Table I, and the searches that the paper does not have."""
    least = min(trace.cost for name, (trace, _) in found.items() if COMPARED[name].exact)
    rows = []
    for name, (trace, ms) in found.items():
        gap = "–"
        # lengths and numbers of edges do not compare
        if trace.hops >= 0 and minimised(name, problem) == problem.weight:
            cost = trace.length if problem.weight == "length" else trace.cost
            gap = with_minus(f"{100 * (cost / least - 1):+.1f} %")
            gap = "=" if abs(cost - least) < 1e-9 * max(least, 1) else gap
        rows.append(
            (
                f'<span style="white-space:normal">{COMPARED[name].label}</span>',
                str(trace.hops) if trace.hops >= 0 else "–",
                format_length(trace.length) if trace.hops >= 0 else "–",
                gap,
                _visited(trace),
                format_count(trace.relaxed),
                format_time(ms),
            )
        )
    head = ("search", "edges", f"length [{unit}]", "gap", "visited", "tried", "time")
    return f'<div style="zoom:.82">{table(head, rows)}</div>' + style.paragraph(_NOTE)

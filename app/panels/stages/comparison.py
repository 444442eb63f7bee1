"""Table of all searches on the present graph, made on request."""

from __future__ import annotations

import viser

from abi.planner.comparison import SearchComparison, compare, search_problem
from abi.planner.plan import Plan
from abi.search.arcs import Arcs
from abi.search.compare import COMPARED
from abi.search.heuristic import Weight
from abi.search.lifelong_a_star import Repair, can_repair, lifelong_a_star
from abi.search.trace import SearchTrace
from app.panels.widgets import Wake, pressed
from app.state.frame import Frame
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
_NO_GRAPH = style.paragraph("There is no graph to search: the message over the scene says why.")
_PRESS_AGAIN = style.paragraph("The scene has changed: press again to compare on its new mesh.")
_LIVE = 50.0
"""Time for all searches, [ms], within which the table follows the plan."""
_LAST = 1e9
"""Place in the tab: behind what the layers add later."""


class ComparisonPanel:
    """A button, and the table that it fills."""

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self.button = gui.add_button(
            "Compare all searches", hint="Runs them once, on the present mesh.", order=_LAST
        )
        self._text = gui.add_html("", visible=False, order=_LAST + 1)
        self._plan: Plan | None = None
        self._ms = 0.0
        self.button.on_click(wake)

    def draw(self, frame: Frame) -> None:
        """Run the searches if the button was pressed, or again for another plan if they are quick.

        The table is never that of another plan's graph; it waits for the hand to rest.
        """
        asked = pressed(self.button)
        changed = self._plan is not None and frame.plan.graph is not self._plan.graph
        if changed and not asked and frame.interactive:
            self._text.visible = False
        elif changed and self._ms > _LIVE and not asked:
            self._plan = None
            self._show(_PRESS_AGAIN)
        elif asked or changed:
            self._plan = frame.plan
            self._show(self._compare(frame.plan, frame.before))

    def _compare(self, plan: Plan, before: Plan | None) -> str:
        """Run the searches, and tell what they found."""
        if plan.graph is None:
            return _NO_GRAPH
        problem = search_problem(plan, heuristic_weight=1.5)
        found = compare(problem)
        self._ms = sum(one.ms for one in found)
        mended = _mended(before, problem.arcs, problem.weight)
        return _table(found, problem.weight, plan.scene.unit) + _told(mended, found[0])

    def _show(self, text: str) -> None:
        self._text.content = text
        self._text.visible = True


def _mended(before: Plan | None, arcs: Arcs, weight: Weight) -> Repair | None:
    """The search of the plan before, mended; None where there was none between the same ends."""
    if before is None or before.graph is None:
        return None
    known = Arcs.of(before.graph, weight)
    return lifelong_a_star(known, arcs) if can_repair(known, arcs) else None


def _told(mended: Repair | None, a_star: SearchComparison) -> str:
    """Note on mending the search before, as HTML."""
    if mended is None:
        return style.paragraph(f"Move an obstacle and compare again: {_MENDING}")
    visited, anew = format_count(mended.expanded), format_count(a_star.trace.steps)
    nodes = "node" if mended.expanded == 1 else "nodes"
    return style.paragraph(
        f"Since the last plan, the edges of {format_count(mended.changed)} nodes have changed. "
        f"{_MENDING} It visits <b>{visited}</b> {nodes}; A* from scratch, {anew}."
    )


def _visited(trace: SearchTrace) -> str:
    """Nodes visited; of a search that goes over all edges in rounds, how many of these."""
    count = format_count(trace.steps)
    return f"{count} rounds" if trace.queue == "rounds" else count


def _table(found: tuple[SearchComparison, ...], weight: Weight, unit: str) -> str:
    """Table I, and the searches that the paper does not have."""
    least = min(one.trace.cost for one in found if COMPARED[one.algorithm].exact)
    rows = []
    for one in found:
        trace = one.trace
        gap = "–"
        # lengths and numbers of edges do not compare
        if trace.hops >= 0 and one.weight == weight:
            cost = trace.length if weight == "length" else trace.cost
            gap = with_minus(f"{100 * (cost / least - 1):+.1f} %")
            gap = "=" if abs(cost - least) < 1e-9 * max(least, 1) else gap
        rows.append(
            (
                f'<span style="white-space:normal">{COMPARED[one.algorithm].label}</span>',
                str(trace.hops) if trace.hops >= 0 else "–",
                format_length(trace.length) if trace.hops >= 0 else "–",
                gap,
                _visited(trace),
                format_count(trace.relaxed),
                format_time(one.ms),
            )
        )
    head = ("search", "edges", f"length [{unit}]", "gap", "visited", "tried", "time")
    return f'<div style="zoom:.82">{table(head, rows)}</div>' + style.paragraph(_NOTE)

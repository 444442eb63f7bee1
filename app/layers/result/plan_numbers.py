"""Numbers of a plan as text: tables of searches and lengths, and notes in the stages' folders."""

from __future__ import annotations

from app.layers.result.stage_notes import shown_notes
from app.layers.result.tables import Rows, search_rows, tables
from app.state.frame import Frame, Layer
from app.ui.layout import Layout


class PlanNumbersLayer(Layer):
    """Tables and notes; while one search is made, the rows of the others stay."""

    def __init__(self, layout: Layout) -> None:
        gui = layout.client.gui
        with layout.result:
            self._tables = gui.add_html("")
        self._notes = {}
        for stage in ("bspline", "quadratic", "arm"):
            with layout.folders[stage]:
                self._notes[stage] = gui.add_html("")
        with layout.result:
            self._notes["motion"] = gui.add_html("")
        self._last: Rows = {}
        self._tabled: tuple[object, ...] = ()
        self._noted: tuple[object, ...] = ()

    def draw(self, frame: Frame) -> None:
        """Write the plan's numbers."""
        plan = frame.plan
        if (plan, frame.current) != self._tabled:
            self._tabled = plan, frame.current
            old = self._last if plan.partial else {}
            self._tables.content = tables(plan, frame.current, old)
            if not plan.partial:
                self._last = search_rows(plan)
        if (state := (plan, frame.asks, frame.lesson and frame.shown)) != self._noted:
            self._noted = state
            for name, text in shown_notes(frame).items():
                self._notes[name].content = text

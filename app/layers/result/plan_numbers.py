"""Numbers of a plan as text: tables of searches and lengths, and notes in the stages' folders."""

from __future__ import annotations

from app.layers.result.stage_notes import shown_notes
from app.layers.result.tables import Rows, search_rows, tables
from app.state.frame import Draw, Frame
from app.ui.layout import Layout


def plan_numbers_layer(layout: Layout) -> Draw:
    """Tables and notes; while one search is made, the rows of the others stay."""
    gui = layout.client.gui
    with layout.result:
        tabled = gui.add_html("")
    noted = {}
    for stage in ("bspline", "quadratic", "arm"):
        with layout.folders[stage]:
            noted[stage] = gui.add_html("")
    with layout.result:
        noted["motion"] = gui.add_html("")
    last: Rows = {}
    of_tables: tuple[object, ...] = ()
    of_notes: tuple[object, ...] = ()

    def draw(frame: Frame) -> None:
        nonlocal last, of_tables, of_notes
        plan = frame.plan
        if (plan, frame.current) != of_tables:
            of_tables = plan, frame.current
            tabled.content = tables(plan, frame.current, last if plan.partial else {})
            if not plan.partial:
                last = search_rows(plan)
        if (state := (plan, frame.asks, frame.lesson and frame.shown)) != of_notes:
            of_notes = state
            for name, text in shown_notes(frame).items():
                noted[name].content = text

    return draw

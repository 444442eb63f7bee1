"""Studies made on request: a table of all searches, and plots against the spacing."""

from __future__ import annotations

import viser

from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.panels.stages.comparison import comparison
from app.panels.stages.pitch_study import STEPS, pitch_plot, study
from app.panels.widgets import Wake, pressed
from app.state.frame import Draw, Frame
from app.ui import style

_NO_GRAPH = style.paragraph("There is no graph to search: the message over the scene says why.")
_PRESS_AGAIN = style.paragraph("The scene has changed: press again to compare on its new mesh.")
_NOTHING = style.paragraph(f"Fewer than two of {STEPS} spacings gave a path: nothing to plot.")
_LIVE = 50.0
"""Time for all searches, [ms], within which the table follows the plan."""
_LAST = 1e9
"""Place in the tab: behind what the layers add later."""


def studies(gui: viser.GuiApi, wake: Wake) -> Draw:
    """A button for each study, and the table or plots that it fills; none is of another scene."""
    parts = _searches_compared(gui, wake), _spacings_plotted(gui, wake)

    def draw(frame: Frame) -> None:
        for part in parts:
            part(frame)

    return draw


def _searches_compared(gui: viser.GuiApi, wake: Wake) -> Draw:
    """Table of all searches, made if its button is pressed, or again for another plan if quick.

    It is never that of another plan's graph; it waits for the hand to rest.
    """
    button = gui.add_button(
        "Compare all searches", hint="Runs them once, on the present mesh.", order=_LAST
    )
    button.on_click(wake)
    table = gui.add_html("", visible=False, order=_LAST + 1)
    compared: Plan | None = None
    took = 0.0

    def draw(frame: Frame) -> None:
        nonlocal compared, took
        asked, plan = pressed(button), frame.plan
        changed = compared is not None and plan.graph is not compared.graph
        if changed and not asked and frame.interactive:
            table.visible = False
        elif changed and took > _LIVE and not asked:
            compared = None
            table.content, table.visible = _PRESS_AGAIN, True
        elif asked or changed:
            compared, text = plan, _NO_GRAPH
            if plan.graph is not None:
                text, took = comparison(plan, frame.before)
            table.content, table.visible = text, True

    return draw


def _spacings_plotted(gui: viser.GuiApi, wake: Wake) -> Draw:
    """Plots against the spacing, made if their button is pressed; hidden for another scene."""
    button = gui.add_button(
        "Plot against the spacing",
        order=_LAST + 2,
        hint=f"Path length and visited nodes for up to {STEPS} spacings around this one.",
    )
    button.on_click(wake)
    note = gui.add_html(_NOTHING, visible=False, order=_LAST + 3)
    length = pitch_plot(gui, style.A_STAR, _LAST + 4)
    nodes = pitch_plot(gui, style.DIJKSTRA, _LAST + 5)
    plotted: Scene | None = None

    def draw(frame: Frame) -> None:
        nonlocal plotted
        scene = frame.plan.scene
        if plotted is not None and scene != plotted:
            plotted = None
            note.visible = length.visible = nodes.visible = False
        if not pressed(button):
            return
        pitches, lengths, expanded = study(scene)
        plotted, found = scene, len(pitches) >= 2
        note.visible, length.visible, nodes.visible = not found, found, found
        if not found:
            return
        for plot, line, what in (
            (length, lengths, f"path length [{scene.unit}]"),
            (nodes, expanded, "nodes visited"),
        ):
            plot.data = (pitches, line)
            plot.title = f"{what} against spacing [{scene.unit}]"

    return draw

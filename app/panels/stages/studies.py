"""Studies made on request: a table of all searches, and plots against the spacing."""

from __future__ import annotations

import viser

from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.panels.stages.comparison import comparison
from app.panels.stages.pitch_study import STEPS, pitch_plot, study
from app.panels.widgets import Wake, pressed
from app.state.frame import Frame
from app.ui import style

_NO_GRAPH = style.paragraph("There is no graph to search: the message over the scene says why.")
_PRESS_AGAIN = style.paragraph("The scene has changed: press again to compare on its new mesh.")
_NOTHING = style.paragraph(f"Fewer than two of {STEPS} spacings gave a path: nothing to plot.")
_LIVE = 50.0
"""Time for all searches, [ms], within which the table follows the plan."""
_LAST = 1e9
"""Place in the tab: behind what the layers add later."""


class StudiesPanel:
    """A button for each study, and the table or plots that it fills; none is of another scene."""

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self.compare = gui.add_button(
            "Compare all searches", hint="Runs them once, on the present mesh.", order=_LAST
        )
        self.table = gui.add_html("", visible=False, order=_LAST + 1)
        self.plot = gui.add_button(
            "Plot against the spacing",
            order=_LAST + 2,
            hint=f"Path length and visited nodes for up to {STEPS} spacings around this one.",
        )
        self.note = gui.add_html(_NOTHING, visible=False, order=_LAST + 3)
        self.length = pitch_plot(gui, style.A_STAR, _LAST + 4)
        self.expanded = pitch_plot(gui, style.DIJKSTRA, _LAST + 5)
        self._compared: Plan | None = None
        self._ms = 0.0
        self._plotted: Scene | None = None
        for button in (self.compare, self.plot):
            button.on_click(wake)

    def draw(self, frame: Frame) -> None:
        """Make the studies whose buttons were pressed."""
        self._draw_table(frame)
        self._draw_plots(frame.plan.scene)

    def _draw_table(self, frame: Frame) -> None:
        """Run the searches if that was asked for, or again for another plan if they are quick.

        The table is never that of another plan's graph; it waits for the hand to rest.
        """
        asked, plan = pressed(self.compare), frame.plan
        changed = self._compared is not None and plan.graph is not self._compared.graph
        if changed and not asked and frame.interactive:
            self.table.visible = False
        elif changed and self._ms > _LIVE and not asked:
            self._compared = None
            self.table.content, self.table.visible = _PRESS_AGAIN, True
        elif asked or changed:
            self._compared, text = plan, _NO_GRAPH
            if plan.graph is not None:
                text, self._ms = comparison(plan, frame.before)
            self.table.content, self.table.visible = text, True

    def _draw_plots(self, scene: Scene) -> None:
        """Plan and plot if that was asked for; hide what is of another scene."""
        if self._plotted is not None and scene != self._plotted:
            self._plotted = None
            self.note.visible = self.length.visible = self.expanded.visible = False
        if not pressed(self.plot):
            return
        pitches, lengths, expanded = study(scene)
        self._plotted, found = scene, len(pitches) >= 2
        self.note.visible, self.length.visible, self.expanded.visible = not found, found, found
        if not found:
            return
        for plot, line, what in (
            (self.length, lengths, f"path length [{scene.unit}]"),
            (self.expanded, expanded, "nodes visited"),
        ):
            plot.data = (pitches, line)
            plot.title = f"{what} against spacing [{scene.unit}]"

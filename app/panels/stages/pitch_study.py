"""Plot of path length and expanded nodes against the spacing, made on request."""

from __future__ import annotations

import numpy as np
import viser
from viser import uplot

from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from app.panels.widgets import Wake, pressed
from app.state.frame import Frame
from app.ui import style

STEPS = 8
"""Pitches that are tried."""
_FINEST, _COARSEST = 0.45, 1.5
"""Range of these, as parts of the scene's pitch."""
_MOST_NODES = 40_000
_NOTHING = style.paragraph(f"Fewer than two of {STEPS} spacings gave a path: nothing to plot.")
_LAST = 1e9 + 10
"""Place in the tab: behind the table of searches."""


class PitchStudyPanel:
    """A button, and the two plots that it fills."""

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self.button = gui.add_button(
            "Plot against the spacing",
            order=_LAST,
            hint=f"Path length and visited nodes for up to {STEPS} spacings around this one.",
        )
        self._note = gui.add_html(_NOTHING, visible=False, order=_LAST)
        self.length = _plot(gui, style.A_STAR, _LAST + 1)
        self.expanded = _plot(gui, style.DIJKSTRA, _LAST + 2)
        self._scene: Scene | None = None
        self.button.on_click(wake)

    def draw(self, frame: Frame) -> None:
        """Plan and plot if the button was pressed; hide what is of another scene."""
        scene = frame.plan.scene
        if self._scene is not None and scene != self._scene:
            self._scene = None
            self._note.visible = self.length.visible = self.expanded.visible = False
        if not pressed(self.button):
            return
        pitches, lengths, expanded = study(scene)
        self._scene, found = scene, len(pitches) >= 2
        self._note.visible, self.length.visible, self.expanded.visible = not found, found, found
        if not found:
            return
        for plot, line, what in (
            (self.length, lengths, f"path length [{scene.unit}]"),
            (self.expanded, expanded, "nodes visited"),
        ):
            plot.data = (pitches, line)
            plot.title = f"{what} against spacing [{scene.unit}]"


def study(scene: Scene) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Real pitches, ascending, path lengths, [unit], and nodes expanded, of those with a path."""
    planner, rows = Planner(compile=False), {}
    for factor in np.geomspace(_COARSEST, _FINEST, STEPS):
        mesh = scene.mesh.model_copy(update={"pitch": scene.mesh.pitch * float(factor)})
        if mesh.node_count(scene.workspace) > _MOST_NODES:
            break
        plan: Plan = planner(scene.model_copy(update={"mesh": mesh}), chosen_only=True)
        if plan.path is not None and plan.mesh is not None:
            rows[plan.mesh.pitch] = (plan.path.length, float(plan.path.expanded))
    pitches = sorted(rows)
    values = np.array([rows[pitch] for pitch in pitches]).reshape(-1, 2)
    return np.array(pitches), values[:, 0], values[:, 1]


def _plot(gui: viser.GuiApi, colour: style.Colour, order: float) -> viser.GuiUplotHandle:
    axis = uplot.Axis(size=46, font="11px sans-serif")
    return gui.add_uplot(
        (np.array([0.0, 1.0]), np.zeros(2)),
        # by its label the page knows that this is no plot over time
        (uplot.Series(label="spacing"), uplot.Series(stroke=style.css(colour), width=2)),
        scales={"x": uplot.Scale(time=False)},
        legend=uplot.Legend(show=False),
        axes=(axis, axis),
        height=170,
        order=order,
        visible=False,
    )

"""Path length and expanded nodes against the spacing, and plots for them."""

from __future__ import annotations

import numpy as np
import viser
from viser import uplot

from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from app.ui import style

STEPS = 8
"""Pitches that are tried."""
_FINEST, _COARSEST = 0.45, 1.5
"""Range of these, as parts of the scene's pitch."""
_MOST_NODES = 40_000


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


def pitch_plot(gui: viser.GuiApi, colour: style.Colour, order: float) -> viser.GuiUplotHandle:
    """Add a plot against the spacing, hidden until it has lines."""
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

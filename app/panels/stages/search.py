"""Inputs of stage 3: algorithm, cost of an edge, taut path, and the slider through the search."""

from __future__ import annotations

import viser

from abi.scene.scene import Scene
from app.panels.stages.fields import Labels, Widgets
from app.panels.widgets import clamp
from app.state.frame import Frame
from app.ui import style

WEIGHTS: Labels = {"length": "length", "number of edges": "hops"}
ALGORITHMS: Labels = {label: name for name, (label, _) in style.ALGORITHMS.items()}


def search_inputs(gui: viser.GuiApi, scene: Scene) -> Widgets:
    """Add widgets of the ``search`` section of a scene."""
    return {
        "search.algorithm": gui.add_dropdown(
            "path used",
            tuple(ALGORITHMS),
            hint="All searches run each time; this one's path becomes the curve.",
        ),
        "search.weight": gui.add_dropdown(
            "shortest by",
            tuple(WEIGHTS),
            hint="By number of edges, all searches find equally few edges, but of several such "
            "paths each may find another, of another length (the paper's Table I).",
        ),
        "search.taut": gui.add_checkbox(
            "shortcut the corners",
            scene.search.taut,
            hint="Cuts the zigzag that the grid forces on the path. Not in the paper.",
        ),
    }


def add_visited(gui: viser.GuiApi) -> viser.GuiSliderHandle[int]:
    """Add a slider for the part of the search to draw, which belongs to no scene."""
    return gui.add_slider(
        "show visited",
        0,
        1,
        1,
        0,
        hint="Colours so many of the nodes that the search visited, in their order: first "
        "yellow, later blue, the latest magenta.",
    )


def visited_nodes(slider: viser.GuiSliderHandle[int]) -> int:
    """Number of expanded nodes to draw."""
    return int(clamp(slider.value, 0, slider.max))


def fit_visited(slider: viser.GuiSliderHandle[int], frame: Frame) -> None:
    """Let the slider end where the search did, once the hand rests."""
    path = frame.plan.path
    if frame.interactive or frame.plan.partial or not frame.current or path is None:
        return
    most = max(path.expanded, 1)
    if slider.max != most:
        slider.value = min(visited_nodes(slider), most)
        slider.max = most

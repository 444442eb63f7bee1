"""Inputs of stage 3: algorithm, cost of an edge, taut path, and the search's slider."""

from __future__ import annotations

from typing import Any

import viser

from abi.scene.scene import Scene
from app import style
from app.panels.widgets import Choice, Wake, clamp

WEIGHTS = {"length": "length", "number of edges": "hops"}
ALGORITHMS = {label: name for name, (label, _) in style.ALGORITHMS.items()}


class SearchPanel:
    """The ``search`` section of a scene, and the part of the search to draw."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        self.algorithm = Choice(
            gui,
            "path used",
            ALGORITHMS,
            "All three searches run each time; this one's path becomes the curve.",
            wake,
        )
        self.weight = Choice(
            gui,
            "shortest by",
            WEIGHTS,
            "By number of edges, all searches find equally few edges, but of several such paths "
            "each may find another, of another length (the paper's Table I).",
            wake,
        )
        self.taut = gui.add_checkbox(
            "straighten",
            scene.search.taut,
            hint="Cuts the zigzag that the grid forces on the path. Not in the paper.",
        )
        self.shown = gui.add_slider(
            "visited [%]",
            0,
            100,
            1,
            0,
            hint="Shows the nodes visited so far, from the first to the last.",
        )
        self.taut.on_update(wake)
        self.shown.on_update(wake)
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """Read the section as typed."""
        return {
            "search": {
                "algorithm": self.algorithm.read(),
                "weight": self.weight.read(),
                "taut": self.taut.value,
            }
        }

    def expanded_share(self) -> float:
        """Part of the expansions to draw, 0 to 1."""
        return clamp(self.shown.value, 0, 100) / 100

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        self.algorithm.write(scene.search.algorithm)
        self.weight.write(scene.search.weight)
        self.taut.value = scene.search.taut

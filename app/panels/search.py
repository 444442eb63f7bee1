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
            "goes on with",
            ALGORITHMS,
            "All three run on every plan; this one's path becomes the curve.",
            wake,
        )
        self.weight = Choice(
            gui,
            "edge costs",
            WEIGHTS,
            "By length the three lengths tie. By hops they tie in edges and differ in length: "
            "that is how the paper's Table I comes about.",
            wake,
        )
        self.taut = gui.add_checkbox(
            "pull taut (3½)",
            scene.search.taut,
            hint="Frees the path of the mesh's directions; off is the paper's way.",
        )
        self.shown = gui.add_slider(
            "search [%]",
            0,
            100,
            1,
            0,
            hint="Colours the nodes in the order in which the algorithm expanded them.",
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

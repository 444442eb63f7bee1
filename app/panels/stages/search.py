"""Inputs of stage 3: algorithm, cost of an edge, taut path, and the slider through the search."""

from __future__ import annotations

import viser

from abi.scene.scene import Scene
from app.panels.stages.fields import Fields
from app.panels.widgets import Wake, clamp
from app.state.frame import Frame
from app.ui import style

WEIGHTS = {"length": "length", "number of edges": "hops"}
ALGORITHMS = {label: name for name, (label, _) in style.ALGORITHMS.items()}


class SearchPanel:
    """The ``search`` section of a scene, and the part of the search to draw."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        self.algorithm = gui.add_dropdown(
            "path used",
            tuple(ALGORITHMS),
            hint="All searches run each time; this one's path becomes the curve.",
        )
        self.weight = gui.add_dropdown(
            "shortest by",
            tuple(WEIGHTS),
            hint="By number of edges, all searches find equally few edges, but of several such "
            "paths each may find another, of another length (the paper's Table I).",
        )
        self.taut = gui.add_checkbox(
            "shortcut the corners",
            scene.search.taut,
            hint="Cuts the zigzag that the grid forces on the path. Not in the paper.",
        )
        self.shown = gui.add_slider(
            "show visited",
            0,
            1,
            1,
            0,
            hint="Colours so many of the nodes that the search visited, in their order: first "
            "yellow, later blue, the latest magenta.",
        )
        widgets = {"algorithm": self.algorithm, "weight": self.weight, "taut": self.taut}
        named = {f"search.{name}": one for name, one in widgets.items()}
        options = {"search.algorithm": ALGORITHMS, "search.weight": WEIGHTS}
        self._fields = Fields(named, wake, options)
        self.read = self._fields.read
        self.shown.on_update(wake)
        self.write(scene)

    def visited(self) -> int:
        """Number of expanded nodes to draw."""
        return int(clamp(self.shown.value, 0, self.shown.max))

    def draw(self, frame: Frame) -> None:
        """Let the slider end where the search did, once the hand rests."""
        path = frame.plan.path
        if frame.interactive or frame.plan.partial or not frame.current or path is None:
            return
        most = max(path.expanded, 1)
        if self.shown.max != most:
            self.shown.value = min(self.visited(), most)
            self.shown.max = most

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        self._fields.write(scene)
        self.shown.value = 0  # of the search of another scene

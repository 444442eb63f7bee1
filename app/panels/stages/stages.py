"""Folders of all stages on the left, each with its heading and its stage's inputs.

A panel has ``read()``, which returns sections of a scene as typed, for :meth:`abi.Scene.replace` to
check, and ``write(scene)``, which shows another scene. ``wake`` is the only callback.
"""

from __future__ import annotations

from typing import Any

import viser

from abi.scene.scene import Scene
from app.panels.stages.arm import ArmPanel
from app.panels.stages.find_base import FindBasePanel
from app.panels.stages.mesh import MeshPanel
from app.panels.stages.motion import MotionPanel
from app.panels.stages.search import SearchPanel
from app.panels.stages.spline import SplinePanel
from app.panels.stages.stage_headings import headings
from app.panels.widgets import Wake
from app.stages.catalogue import TITLES
from app.state.frame import Frame
from app.ui.layout import Layout

_FOLDED = ("graph", "arm")
"""Stages whose folders are closed at first."""


def stage_folders(gui: viser.GuiApi) -> dict[str, viser.GuiFolderHandle]:
    """Add the stages' folders, still without inputs, by the stages' names."""
    folders = {}
    for stage, title in TITLES.items():
        # viser sets a folder that follows another right away further apart
        gui.add_html("", visible=False)
        folders[stage] = gui.add_folder(title, expand_by_default=stage not in _FOLDED)
    return folders


class StagePanels:
    """The stages' folders: the inputs of stages 1 and 3 to 6, as stage 2 has none, and headings."""

    def __init__(self, layout: Layout, scene: Scene, wake: Wake) -> None:
        gui, folders = layout.client.gui, layout.folders
        self._folders = folders
        self._drawn: tuple[object, ...] = ()
        with folders["mesh"]:
            self.mesh = MeshPanel(gui, scene, wake)
        with folders["search"]:
            self.search = SearchPanel(gui, scene, wake)
        with folders["bspline"]:
            self.spline = SplinePanel(gui, scene, wake)
        with folders["quadratic"]:
            self.motion = MotionPanel(gui, scene, wake)
        with folders["arm"]:
            self.arm = ArmPanel(layout.client, scene, wake)
            self.bases = FindBasePanel(layout.client, scene, wake)
        self._panels = (self.mesh, self.search, self.spline, self.motion, self.arm, self.bases)

    def draw(self, frame: Frame) -> None:
        """Write the plan's results into the headings, and where an error belongs."""
        state = frame.plan, frame.outdated, frame.refused, frame.asks, frame.lesson and frame.shown
        if state == self._drawn:
            return
        self._drawn = state
        for stage, heading in headings(frame).items():
            if self._folders[stage].label != heading:
                self._folders[stage].label = heading

    def read(self) -> dict[str, Any]:
        """Read all sections as typed."""
        return {name: part for panel in self._panels for name, part in panel.read().items()}

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        for panel in self._panels:
            panel.write(scene)

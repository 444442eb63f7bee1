"""Inputs of all stages, each in its stage's folder on the left.

A panel has ``read()``, which returns sections of a scene as typed, for :meth:`abi.Scene.replace` to
check, and ``write(scene)``, which shows another scene. ``wake`` is the only callback.
"""

from __future__ import annotations

from typing import Any

from abi.scene.scene import Scene
from app.panels.stages.arm import ArmPanel
from app.panels.stages.find_base import FindBasePanel
from app.panels.stages.mesh import MeshPanel
from app.panels.stages.motion import MotionPanel
from app.panels.stages.search import SearchPanel
from app.panels.stages.spline import SplinePanel
from app.panels.widgets import Wake
from app.ui.layout import Layout


class StagePanels:
    """The panels of stages 1 and 3 to 6; stage 2 has no inputs."""

    def __init__(self, layout: Layout, scene: Scene, wake: Wake) -> None:
        gui, folders = layout.client.gui, layout.folders
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

    def read(self) -> dict[str, Any]:
        """Read all sections as typed."""
        return {name: part for panel in self._panels for name, part in panel.read().items()}

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        for panel in self._panels:
            panel.write(scene)

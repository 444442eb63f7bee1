"""Folders of all stages on the left, each with its heading and its stage's inputs.

Stages 1 to 5 have widgets that each set a field. A panel has ``read()``, which returns sections of
a scene as typed, for :meth:`abi.Scene.replace` to check, and ``write(scene)``, which shows another
scene. ``wake`` is the only callback.
"""

from __future__ import annotations

from typing import Any

import viser

from abi.scene.scene import Scene
from app.panels.stages.arm import ArmPanel
from app.panels.stages.fields import Fields, Labels
from app.panels.stages.find_base import FindBasePanel
from app.panels.stages.mesh import LATTICE_LABELS, fit_pitch, mesh_inputs, show_seed
from app.panels.stages.motion import (
    FITS,
    FOLLOWED,
    LAW_LABELS,
    fit_steps,
    motion_inputs,
    show_limits,
)
from app.panels.stages.search import (
    ALGORITHMS,
    WEIGHTS,
    add_visited,
    fit_visited,
    search_inputs,
    visited_nodes,
)
from app.panels.stages.spline import fit_clearance, spline_inputs
from app.panels.stages.stage_headings import headings
from app.panels.widgets import Wake
from app.stages.catalogue import TITLES
from app.state.frame import Frame
from app.ui.layout import Layout

_FOLDED = ("graph", "arm")
"""Stages whose folders are closed at first."""
_OPTIONS: dict[str, Labels] = {
    "mesh.lattice": LATTICE_LABELS,
    "search.algorithm": ALGORITHMS,
    "search.weight": WEIGHTS,
    "quadratic.mode": FITS,
    "motion.curve": FOLLOWED,
    "motion.law": LAW_LABELS,
}


def stage_folders(gui: viser.GuiApi) -> dict[str, viser.GuiFolderHandle]:
    """Add the stages' folders, still without inputs, by the stages' names."""
    folders = {}
    for stage, title in TITLES.items():
        # viser sets a folder that follows another right away further apart
        gui.add_html("", visible=False)
        folders[stage] = gui.add_folder(title, expand_by_default=stage not in _FOLDED)
    return folders


class StagePanels:
    """The stages' folders: the inputs of stages 1 and 3 to 6, as stage 2 has none, and headings.

    Attributes:
        fields: widgets of stages 1 to 5.
        visited: slider for the part of the search to draw.
        arm: the inputs of stage 6.
        bases: the search for a base, there, too.
    """

    def __init__(self, layout: Layout, scene: Scene, wake: Wake) -> None:
        gui, folders = layout.client.gui, layout.folders
        self._folders = folders
        self._drawn: tuple[object, ...] = ()
        with folders["mesh"]:
            mesh = mesh_inputs(gui, scene)
        with folders["search"]:
            search = search_inputs(gui, scene)
            self.visited = add_visited(gui)
        with folders["bspline"]:
            spline = spline_inputs(gui, scene)
        with folders["quadratic"]:
            motion = motion_inputs(gui)
        self.fields = Fields({**mesh, **search, **spline, **motion}, wake, _OPTIONS)
        self.visited.on_update(wake)
        self._write_fields(scene)
        with folders["arm"]:
            self.arm = ArmPanel(layout.client, scene, wake)
            self.bases = FindBasePanel(layout.client, scene, wake)

    def draw(self, frame: Frame) -> None:
        """Write the plan's results into the headings, and where an error belongs."""
        state = frame.plan, frame.outdated, frame.refused, frame.asks, frame.lesson and frame.shown
        if state == self._drawn:
            return
        self._drawn = state
        for stage, heading in headings(frame).items():
            if self._folders[stage].label != heading:
                self._folders[stage].label = heading

    def draw_inputs(self, frame: Frame) -> None:
        """Show what belongs to the frame's plan: its lattice's seed, and where its search ended."""
        if frame.current:
            show_seed(self.fields, frame.plan.scene)
        fit_visited(self.visited, frame)

    def visited_nodes(self) -> int:
        """Number of expanded nodes to draw."""
        return visited_nodes(self.visited)

    def read(self) -> dict[str, Any]:
        """Read all sections as typed."""
        show_limits(self.fields)
        return {**self.fields.read(), **self.arm.read(), **self.bases.read()}

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        self._write_fields(scene)
        self.arm.write(scene)
        self.bases.write(scene)

    def _write_fields(self, scene: Scene) -> None:
        fields = self.fields
        for fit in (fit_pitch, fit_clearance, fit_steps):
            fit(fields, scene)
        fields.write(scene)
        show_seed(fields, scene)
        show_limits(fields)
        self.visited.value = 0  # of the search of another scene

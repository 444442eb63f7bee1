"""Inputs of stage 6: elbow branch, base, links, and the forces behind q4, q5, q6."""

from __future__ import annotations

from typing import Any

import viser

from abi.scene.scene import Scene
from abi.scene.settings import ArmSettings
from app.panels.arm_model import ArmModelPanel
from app.panels.length_step import fine_step, length_step
from app.panels.widgets import DIGITS, Choice, Wake

DYNAMICS = {"physics (½·t²)": "corrected", "as printed in the paper": "as_printed"}


class ArmPanel:
    """The ``arm`` section of a scene."""

    def __init__(self, client: viser.ClientHandle, scene: Scene, wake: Wake) -> None:
        arm, gui = scene.arm, client.gui
        self.model = ArmModelPanel(client, wake)
        self.avoid = gui.add_checkbox(
            "avoid with the whole arm",
            arm.avoid,
            hint="Plan so that no link touches an obstacle, the floor or the arm itself.",
        )
        self.elbow = gui.add_dropdown(
            "elbow",
            ("up", "down", "auto"),
            hint="Kept along the whole path; auto takes the one with the shorter path.",
        )
        self.clearance = gui.add_number(
            "link clearance",
            arm.clearance,
            min=0.0,
            step=0.05,
            hint="Distance that the links keep from the obstacles.",
        )
        self.base = gui.add_vector3(
            "base", arm.base, step=0.1, hint="Where the arm stands: x, y, z."
        )
        self._add_papers(gui, arm, wake)
        boxes = self.columns, self.links, self.extension, self.forces, self.masses, self.radii
        for box in (self.base, self.clearance, *boxes):
            box.precision = DIGITS
            box.on_update(wake)
        lengths = self.clearance, self.base, self.columns, self.links, self.extension, self.radii
        self._lengths = [(handle, handle.label) for handle in lengths]
        self._shows_papers: bool | None = None
        self._papers = (self.elbow, self.dynamics.handle, *boxes)
        self.elbow.on_update(wake)
        self.avoid.on_update(wake)
        self.write(scene)

    def _add_papers(self, gui: viser.GuiApi, arm: ArmSettings, wake: Wake) -> None:
        """Add what only the paper's arm has."""
        self.columns = gui.add_vector2(
            "pedestal, column", (arm.a1, arm.a2), step=0.1, hint="Heights; together the shoulder's."
        )
        self.links = gui.add_vector3(
            "upper arm, forearm, slide",
            (arm.a3, arm.a4, arm.a5),
            step=0.1,
            hint="Lengths of the links.",
        )
        self.extension = gui.add_number(
            "slide at start",
            arm.q5,
            min=0.0,
            step=0.1,
            hint="How far the slide is extended at 0 s.",
        )
        self.dynamics = Choice(
            gui,
            "force law",
            DYNAMICS,
            "How a constant force Q moves wrist, slide and gripper from rest: by t²Q/(2I), where "
            "the paper prints t²Q/I. The slide has its mass in place of the inertia I.",
            wake,
        )
        self.forces = gui.add_vector3(
            "drives",
            arm.forces,
            step=0.1,
            hint="Torque of the wrist, force of the slide, torque of the gripper.",
        )
        self.masses = gui.add_vector3(
            "their masses [kg]", arm.masses, step=0.1, hint="Of wrist, slide and gripper."
        )
        self.radii = gui.add_vector3(
            "radii of gyration", arm.radii, step=0.1, hint="Of wrist, slide and gripper."
        )

    def read(self) -> dict[str, Any]:
        """Read the section as typed."""
        names = ("a1", "a2", "a3", "a4", "a5")
        lengths = zip(names, (*self.columns.value, *self.links.value), strict=True)
        model = self.model.read()
        self._show_papers()
        return {
            "arm": {
                **model,
                "avoid": self.avoid.value,
                "elbow": self.elbow.value,
                "clearance": self.clearance.value,
                "base": self.base.value,
                **dict(lengths),
                "q5": self.extension.value,
                "dynamics": self.dynamics.read(),
                "forces": self.forces.value,
                "masses": self.masses.value,
                "radii": self.radii.value,
            }
        }

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        arm = scene.arm
        for handle, name in self._lengths:
            handle.label = f"{name} [{scene.unit}]"
            handle.step = fine_step(scene) if handle is self.clearance else length_step(scene)
        self.forces.label = f"drives [kg, {scene.unit}, s]"
        force, torque = f"kg·{scene.unit}/s²", f"kg·{scene.unit}²/s²"
        self.forces.hint = (
            f"Torque of the wrist [{torque}], force of the slide [{force}], torque of the gripper "
            f"[{torque}]; at 0 the joint stands still."
        )
        self.model.write(scene)
        self._show_papers()
        self.elbow.value = arm.elbow
        self.avoid.value = arm.avoid
        self.clearance.value = arm.clearance
        self.base.value = arm.base
        self.columns.value = (arm.a1, arm.a2)
        self.links.value = (arm.a3, arm.a4, arm.a5)
        self.extension.value = arm.q5
        self.dynamics.write(arm.dynamics)
        self.forces.value = arm.forces
        self.masses.value = arm.masses
        self.radii.value = arm.radii

    def _show_papers(self) -> None:
        """Show what only the paper's arm has where that is chosen."""
        if (shown := self.model.is_paper) != self._shows_papers:
            self._shows_papers = shown
            for handle in self._papers:
                handle.visible = shown

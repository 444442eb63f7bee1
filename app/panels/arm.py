"""Inputs of stage 6: elbow branch, base, links, and the forces behind q4, q5, q6."""

from __future__ import annotations

from typing import Any

import viser

from abi.scene.scene import Scene
from app.panels.widgets import DIGITS, Choice, Wake

DYNAMICS = {"corrected: ½ and mass": "corrected", "as printed": "as_printed"}


class ArmPanel:
    """The ``arm`` section of a scene."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        arm = scene.arm
        self.elbow = gui.add_dropdown(
            "elbow", ("up", "down"), hint="Which of the two solutions; kept along the whole path."
        )
        self.base = gui.add_vector3("base", arm.base, step=0.1, hint="Where the arm stands.")
        self.columns = gui.add_vector2(
            "a1, a2", (arm.a1, arm.a2), step=0.1, hint="Pedestal and column: the shoulder's height."
        )
        self.links = gui.add_vector3(
            "a3, a4, a5", (arm.a3, arm.a4, arm.a5), step=0.1, hint="Upper arm, forearm, slide."
        )
        self.extension = gui.add_number(
            "q5 at start", arm.q5, min=0.0, step=0.1, hint="How far the slide is out at t = 0."
        )
        self.dynamics = Choice(
            gui,
            "q4, q5, q6",
            DYNAMICS,
            "From constant forces: the paper prints t²Q/I; from rest it is t²Q/(2I), and a "
            "slide has mass, not moment of inertia.",
            wake,
        )
        self.forces = gui.add_vector3(
            "Q4, Q5, Q6", arm.forces, step=0.1, hint="Generalised forces of wrist, slide, gripper."
        )
        self.masses = gui.add_vector3("m4, m5, m6 [kg]", arm.masses, step=0.1, hint="Masses.")
        self.radii = gui.add_vector3("i4, i5, i6", arm.radii, step=0.1, hint="Radii of inertia.")
        for box in (
            self.base,
            self.columns,
            self.links,
            self.extension,
            self.forces,
            self.masses,
            self.radii,
        ):
            box.precision = DIGITS
            box.on_update(wake)
        self.elbow.on_update(wake)
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """Read the section as typed."""
        a1, a2 = self.columns.value
        a3, a4, a5 = self.links.value
        return {
            "arm": {
                "elbow": self.elbow.value,
                "base": self.base.value,
                "a1": a1,
                "a2": a2,
                "a3": a3,
                "a4": a4,
                "a5": a5,
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
        for handle, name in (
            (self.base, "base"),
            (self.columns, "a1, a2"),
            (self.links, "a3, a4, a5"),
            (self.extension, "q5 at start"),
            (self.radii, "i4, i5, i6"),
        ):
            handle.label = f"{name} [{scene.unit}]"
        self.elbow.value = arm.elbow
        self.base.value = arm.base
        self.columns.value = (arm.a1, arm.a2)
        self.links.value = (arm.a3, arm.a4, arm.a5)
        self.extension.value = arm.q5
        self.dynamics.write(arm.dynamics)
        self.forces.value = arm.forces
        self.masses.value = arm.masses
        self.radii.value = arm.radii

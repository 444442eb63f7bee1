"""Inputs of stage 6: elbow branch, base, links, ends, and the forces behind q4, q5, q6."""

from __future__ import annotations

from typing import Any

import viser

from abi.scene.arm_settings import ArmSettings
from abi.scene.scene import Scene
from app.panels.length_step import fine_step, length_step
from app.panels.stages.arm_model import ArmModelPanel
from app.panels.stages.end_text import End, add_end, end_text, typed_end
from app.panels.stages.fields import Fields, Widgets
from app.panels.widgets import Wake
from app.state.frame import Frame

DYNAMICS = {"physics (½·t²)": "corrected", "as printed in the paper": "as_printed"}

SEARCHES = {
    "on the mesh, else in the joints": "auto",
    "on the mesh of the tool tip": "mesh",
    "in the space of the joints": "joints",
}

_ENDS: tuple[End, ...] = ("start", "goal")
_WHICH_ARM = ("model", "urdf", "tip", "base_link")
"""Fields that say which joints there are."""


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
            "link clearance [{unit}]",
            arm.clearance,
            min=0.0,
            step=0.05,
            hint="Distance that the links keep from the obstacles. 0 or more.",
        )
        self.base = gui.add_vector3(
            "base [{unit}]", arm.base, step=0.1, hint="Where the arm stands: x, y, z."
        )
        self.search = gui.add_dropdown(
            "motion is sought",
            tuple(SEARCHES),
            hint="On a mesh of places of the tool tip, or by two trees of joint positions that "
            "grow towards each other; without a choice there if the mesh leads to none.",
        )
        self.ends = {end: add_end(gui, end) for end in _ENDS}
        for box in self.ends.values():
            box.on_update(wake)
        self._shown_ends: dict[End, Scene] = {}
        self._add_papers(gui, arm)
        widgets: Widgets = {
            "arm.avoid": self.avoid,
            "arm.elbow": self.elbow,
            "arm.clearance": self.clearance,
            "arm.base": self.base,
            "arm.search": self.search,
            "arm.a1 arm.a2": self.columns,
            "arm.a3 arm.a4 arm.a5": self.links,
            "arm.q5": self.extension,
            "arm.dynamics": self.dynamics,
            "arm.forces": self.forces,
            "arm.masses": self.masses,
            "arm.radii": self.radii,
        }
        options = {"arm.search": SEARCHES, "arm.dynamics": DYNAMICS}
        self._fields = Fields(widgets, wake, options)
        boxes = self.columns, self.links, self.extension, self.forces, self.masses, self.radii
        self._shows_papers: bool | None = None
        self._papers = (self.elbow, self.dynamics, *boxes)
        self.write(scene)

    def _add_papers(self, gui: viser.GuiApi, arm: ArmSettings) -> None:
        """Add what only the paper's arm has."""
        self.columns = gui.add_vector2(
            "pedestal, column [{unit}]",
            (arm.a1, arm.a2),
            step=0.1,
            hint="Heights; together the shoulder's. Both above 0.",
        )
        self.links = gui.add_vector3(
            "upper arm, forearm, slide [{unit}]",
            (arm.a3, arm.a4, arm.a5),
            step=0.1,
            hint="Lengths of the links. All above 0.",
        )
        self.extension = gui.add_number(
            "slide at start [{unit}]",
            arm.q5,
            min=0.0,
            step=0.1,
            hint="How far the slide is extended at 0 s. 0 or more.",
        )
        self.dynamics = gui.add_dropdown(
            "force law",
            tuple(DYNAMICS),
            hint="How a constant force Q moves wrist, slide and gripper from rest: by t²Q/(2I), "
            "where the paper prints t²Q/I. The slide has its mass in place of the inertia I.",
        )
        self.forces = gui.add_vector3(
            "drives [kg, {unit}, s]",
            arm.forces,
            step=0.1,
            hint="Torque of the wrist, force of the slide, torque of the gripper.",
        )
        self.masses = gui.add_vector3(
            "their masses [kg]",
            arm.masses,
            step=0.1,
            hint="Of wrist, slide and gripper. All above 0.",
        )
        self.radii = gui.add_vector3(
            "radii of gyration [{unit}]",
            arm.radii,
            step=0.1,
            hint="Of wrist, slide and gripper: a part turns as if its mass m were all at the "
            "radius k from its axis, with the inertia I = m·k². All above 0.",
        )

    def read(self) -> dict[str, Any]:
        """Read the section as typed."""
        model = self.model.read()
        self._show_papers()
        # joints that were asked of another arm mean nothing to this one
        same = not self.model.is_paper and all(model[name] == self._arm[name] for name in self._arm)
        ends: dict[str, Any] = {"start": None, "goal": None, "search": "auto"}
        if same:
            ends = {end: self._read_end(end) for end in self.ends}
        return {"arm": {**model, **self._fields.read()["arm"], **ends}}

    def draw(self, frame: Frame) -> None:
        """Show what became of the ends: one that was dragged is a point again."""
        scene = frame.plan.scene
        if frame.outdated or frame.refused is not None or scene.arm.model != "urdf":
            return
        for end, box in self.ends.items():
            shown = self._shown_ends.get(end)
            kept, now = None if shown is None else getattr(shown.arm, end), getattr(scene.arm, end)
            if now == kept:
                continue
            # not where a newer one is typed
            untouched = shown is not None and box.value.strip() == end_text(shown, end)
            if untouched or self._read_end(end) == (None if now is None else now.model_dump()):
                self._show_end(end, scene)

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        self.clearance.step = fine_step(scene)
        for length in (self.base, self.columns, self.links, self.extension, self.radii):
            length.step = length_step(scene)
        force, torque = f"kg·{scene.unit}/s²", f"kg·{scene.unit}²/s²"
        self.forces.hint = (
            f"Torque of the wrist [{torque}], force of the slide [{force}], torque of the gripper "
            f"[{torque}]; at 0 the joint stands still."
        )
        self._arm = {name: getattr(scene.arm, name) for name in _WHICH_ARM}
        self.model.write(scene)
        self._show_papers()
        self._fields.write(scene)
        is_urdf = scene.arm.model == "urdf"  # the paper's arm has no such fields
        self.search.visible = is_urdf
        for end, box in self.ends.items():
            box.visible = is_urdf
            if is_urdf:
                self._show_end(end, scene)

    def _show_end(self, end: End, scene: Scene) -> None:
        self._shown_ends[end] = scene
        self.ends[end].value = end_text(scene, end)

    def _read_end(self, end: End) -> Any:
        """The joints at one end as typed: the scene's own while its text is unchanged."""
        text, shown = self.ends[end].value.strip(), self._shown_ends.get(end)
        if shown is None:
            return None
        return getattr(shown.arm, end) if text == end_text(shown, end) else typed_end(text, shown)

    def _show_papers(self) -> None:
        """Show what only the paper's arm has where that is chosen."""
        if (shown := self.model.is_paper) != self._shows_papers:
            self._shows_papers = shown
            for handle in self._papers:
                handle.visible = shown

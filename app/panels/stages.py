"""The inputs of stages 1 to 6, one panel each, docked left in the order of the method.

Every panel has ``read() -> dict`` (what its widgets change of a scene, as typed: checked by
:meth:`abi.Scene.replace`, not here) and ``write(scene)`` (show another scene). ``wake`` is the only
callback there is.
"""

from __future__ import annotations

import math
from typing import Any

import viser

from abi.scene.scene import Scene
from app import style
from app.frame import Frame
from app.layout import Layout
from app.panels.widgets import DIGITS, Wake, label_of, within

LATTICES = {
    "BCC: congruent tetrahedra": "bcc",
    "Kuhn: six per cube": "kuhn",
    "Delaunay: jittered": "delaunay",
}
WEIGHTS = {"length": "length", "number of edges": "hops"}
ALGORITHMS = {label: name for name, (label, _) in style.ALGORITHMS.items()}
FITS = {
    "least squares": "least_squares",
    "nearest clear one": "clear",
    "fewest clear pieces": "pieces",
}
FOLLOWED = {
    "quadratic if clear, else B-spline": "auto",
    "quadratic": "quadratic",
    "B-spline": "bspline",
}
DYNAMICS = {"corrected: ½ and mass": "corrected", "as printed": "as_printed"}


class MeshPanel:
    """Stage 1: lattice, pitch, seed."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        low, high, step = _pitch_range(scene)
        self.lattice = gui.add_dropdown(
            "lattice", tuple(LATTICES), hint="How the workspace is cut into tetrahedra."
        )
        self.pitch = gui.add_slider(
            f"pitch [{scene.unit}]",
            low,
            high,
            step,
            within(scene.mesh.pitch, low, high),
            hint="Distance between neighbouring nodes. Half the pitch: eight times the nodes.",
        )
        self.seed = gui.add_number(
            "seed", scene.mesh.seed, min=0, step=1, hint="Another seed jitters the nodes anew."
        )
        self.pitch.precision = DIGITS
        for handle in (self.lattice, self.pitch, self.seed):
            handle.on_update(wake)
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """The ``mesh`` section."""
        return {
            "mesh": {
                "lattice": LATTICES.get(self.lattice.value, self.lattice.value),
                "pitch": self.pitch.value,
                "seed": self.seed.value,
            }
        }

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        low, high, step = _pitch_range(scene)
        self.pitch.label = f"pitch [{scene.unit}]"
        self.pitch.min, self.pitch.max, self.pitch.step = low, high, step
        self.lattice.value = label_of(LATTICES, scene.mesh.lattice)
        self.pitch.value = scene.mesh.pitch
        self.seed.value = scene.mesh.seed
        self._offer(scene)

    def draw(self, frame: Frame) -> None:
        """Show what there is to choose for the lattice of the plan."""
        if not frame.faded:
            self._offer(frame.plan.scene)

    def _offer(self, scene: Scene) -> None:
        self.seed.visible = scene.mesh.lattice == "delaunay"


class SearchPanel:
    """Stage 3: which algorithm's path goes on, what an edge costs, how much of the search shows."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        self.algorithm = gui.add_dropdown(
            "goes on with",
            tuple(ALGORITHMS),
            hint="All three run on every plan; this one's path becomes the curve.",
        )
        self.weight = gui.add_dropdown(
            "edge costs",
            tuple(WEIGHTS),
            hint="By length the three lengths tie. By hops they tie in edges and differ in length: "
            "that is how the paper's Table I comes about.",
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
        for handle in (self.algorithm, self.weight, self.taut, self.shown):
            handle.on_update(wake)
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """The ``search`` section."""
        return {
            "search": {
                "algorithm": ALGORITHMS.get(self.algorithm.value, self.algorithm.value),
                "weight": WEIGHTS.get(self.weight.value, self.weight.value),
                "taut": self.taut.value,
            }
        }

    def share(self) -> float:
        """Part of the expansions to show, 0 to 1."""
        return min(max(self.shown.value, 0), 100) / 100

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        self.algorithm.value = label_of(ALGORITHMS, scene.search.algorithm)
        self.weight.value = label_of(WEIGHTS, scene.search.weight)
        self.taut.value = scene.search.taut


class SplinePanel:
    """Stage 4: degree and clearance."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        self.degree = gui.add_slider(
            "degree", 2, 5, 1, scene.spline.degree, hint="The paper uses 3 and 4."
        )
        high = _clearance_range(scene)
        self.clearance = gui.add_slider(
            f"clearance [{scene.unit}]",
            0.0,
            high,
            high / 100,
            within(scene.spline.clearance, 0.0, high),
            hint="The distance that mesh, path and curve keep from every obstacle.",
        )
        self.clearance.precision = DIGITS
        for handle in (self.degree, self.clearance):
            handle.on_update(wake)
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """The ``spline`` section."""
        return {"spline": {"degree": self.degree.value, "clearance": self.clearance.value}}

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        high = _clearance_range(scene)
        self.clearance.label = f"clearance [{scene.unit}]"
        self.clearance.max, self.clearance.step = high, high / 100
        self.degree.value = scene.spline.degree
        self.clearance.value = scene.spline.clearance


class MotionPanel:
    """Stage 5: how the quadratic is fitted, which curve the arm executes, and how fast."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        self.fit = gui.add_dropdown(
            "fit",
            tuple(FITS),
            hint="Least squares is the paper's and may enter an obstacle; the others keep clear.",
        )
        self.curve = gui.add_dropdown(
            "arm follows", tuple(FOLLOWED), hint="The curve that the arm executes."
        )
        self.speed = gui.add_number("speed V", 1.0, step=0.1, hint="Cruise speed.")
        self.rates = gui.add_vector2(
            "a1, a3", (1.0, 1.0), step=0.1, hint="Speeding up from rest, and braking to rest."
        )
        self.speed.precision = self.rates.precision = DIGITS
        for handle in (self.fit, self.curve, self.speed, self.rates):
            handle.on_update(wake)
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """The ``quadratic`` and ``motion`` sections."""
        return {
            "quadratic": {"mode": FITS.get(self.fit.value, self.fit.value)},
            "motion": {
                "curve": FOLLOWED.get(self.curve.value, self.curve.value),
                "speed": self.speed.value,
                "acceleration": self.rates.value[0],
                "deceleration": self.rates.value[1],
            },
        }

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        self.speed.label = f"V [{scene.unit}/s]"
        self.rates.label = f"a1, a3 [{scene.unit}/s²]"
        self.fit.value = label_of(FITS, scene.quadratic.mode)
        self.curve.value = label_of(FOLLOWED, scene.motion.curve)
        self.speed.value = scene.motion.speed
        self.rates.value = (scene.motion.acceleration, scene.motion.deceleration)


class ArmPanel:
    """Stage 6: links, base, elbow branch, and the forces behind q4, q5, q6."""

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
        self.dynamics = gui.add_dropdown(
            "q4, q5, q6",
            tuple(DYNAMICS),
            hint="From constant forces: the paper prints t²Q/I; from rest it is t²Q/(2I), and a "
            "slide has mass, not moment of inertia.",
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
        for handle in (self.elbow, self.dynamics):
            handle.on_update(wake)
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """The ``arm`` section."""
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
                "dynamics": DYNAMICS.get(self.dynamics.value, self.dynamics.value),
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
        self.dynamics.value = label_of(DYNAMICS, arm.dynamics)
        self.forces.value = arm.forces
        self.masses.value = arm.masses
        self.radii.value = arm.radii


class StagePanels:
    """The panels of all stages, each in its stage's folder."""

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
            self.arm = ArmPanel(gui, scene, wake)
        self._panels = (self.mesh, self.search, self.spline, self.motion, self.arm)

    def read(self) -> dict[str, Any]:
        """The sections that the panels change."""
        return {name: part for panel in self._panels for name, part in panel.read().items()}

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        for panel in self._panels:
            panel.write(scene)


def _pitch_range(scene: Scene) -> tuple[float, float, float]:
    """Slider range: from what the node budget allows, hundreds of thousands, up to a handful."""
    longest = max(scene.workspace.size)
    finest = max(scene.mesh.finest_pitch(scene.workspace), longest / 90)
    digits = 1 - math.floor(math.log10(finest))
    finest = math.ceil(finest * 10.0**digits) / 10.0**digits
    return round(finest, 12), round(longest / 2, 6), round(longest / 600, 6)


def _clearance_range(scene: Scene) -> float:
    return round(max(scene.workspace.size) / 6, 6)

"""Inputs of stage 1: lattice, pitch and seed."""

from __future__ import annotations

import math
from typing import Any

import viser

from abi.scene.lattices import LATTICES
from abi.scene.scene import Scene
from app.frame import Frame
from app.panels.widgets import DIGITS, Choice, Wake, clamp

_LABELS = {kind.label: name for name, kind in LATTICES.items()}


class MeshPanel:
    """The ``mesh`` section of a scene."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        low, high, step = _pitch_range(scene)
        self.lattice = Choice(
            gui, "grid type", _LABELS, "How the workspace is cut into tetrahedra.", wake
        )
        self.pitch = gui.add_slider(
            f"spacing [{scene.unit}]",
            low,
            high,
            step,
            clamp(scene.mesh.pitch, low, high),
            hint="Distance between neighbouring nodes. Halving it gives eight times as many.",
        )
        self.seed = gui.add_number(
            "seed",
            scene.mesh.seed,
            min=0,
            step=1,
            hint="Another number gives another irregular grid.",
        )
        self.pitch.precision = DIGITS
        self.pitch.on_update(wake)
        self.seed.on_update(wake)
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """Read the section as typed."""
        return {
            "mesh": {
                "lattice": self.lattice.read(),
                "pitch": self.pitch.value,
                "seed": self.seed.value,
            }
        }

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        low, high, step = _pitch_range(scene)
        self.pitch.label = f"spacing [{scene.unit}]"
        self.pitch.min, self.pitch.max, self.pitch.step = low, high, step
        self.lattice.write(scene.mesh.lattice)
        self.pitch.value = scene.mesh.pitch
        self.seed.value = scene.mesh.seed
        self._show_seed(scene)

    def draw(self, frame: Frame) -> None:
        """Show the seed where the plan's lattice has one."""
        if frame.current:
            self._show_seed(frame.plan.scene)

    def _show_seed(self, scene: Scene) -> None:
        self.seed.visible = LATTICES[scene.mesh.lattice].seeded


def _pitch_range(scene: Scene) -> tuple[float, float, float]:
    """Least and most pitch of the slider and its step, [unit]; the least by the node budget."""
    longest = max(scene.workspace.size)
    finest = max(scene.mesh.finest_pitch(scene.workspace), longest / 90)
    digits = 1 - math.floor(math.log10(finest))
    finest = math.ceil(finest * 10.0**digits) / 10.0**digits
    return round(finest, 12), round(longest / 2, 6), round(longest / 600, 6)

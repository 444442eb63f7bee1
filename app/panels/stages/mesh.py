"""Inputs of stage 1: lattice, pitch and seed."""

from __future__ import annotations

import math

import viser

from abi.scene.lattices import LATTICES
from abi.scene.scene import Scene
from app.panels.stages.fields import Fields
from app.panels.widgets import Wake, clamp, range_hint
from app.state.frame import Frame

_LABELS = {kind.label: name for name, kind in LATTICES.items()}
_SPACING = "Distance between neighbouring nodes. Halving it gives up to eight times as many."


class MeshPanel:
    """The ``mesh`` section of a scene."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        low, high, step = _pitch_range(scene)
        self.lattice = gui.add_dropdown(
            "grid type", tuple(_LABELS), hint="How the workspace is cut into tetrahedra."
        )
        self.pitch = gui.add_slider(
            "spacing [{unit}]",
            low,
            high,
            step,
            clamp(scene.mesh.pitch, low, high),
        )
        self.seed = gui.add_number(
            "seed",
            scene.mesh.seed,
            min=0,
            step=1,
            hint="Another number gives another irregular grid. A whole one, 0 or more.",
        )
        widgets = {"lattice": self.lattice, "pitch": self.pitch, "seed": self.seed}
        named = {f"mesh.{name}": one for name, one in widgets.items()}
        self._fields = Fields(named, wake, {"mesh.lattice": _LABELS})
        self.read = self._fields.read
        self.write(scene)

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        low, high, step = _pitch_range(scene)
        self.pitch.min, self.pitch.max, self.pitch.step = low, high, step
        self.pitch.hint = range_hint(_SPACING, low, high, scene.unit)
        self._fields.write(scene)
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

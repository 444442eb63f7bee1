"""Inputs of stage 1: lattice, pitch and seed."""

from __future__ import annotations

import math

import viser

from abi.scene.lattices import LATTICES
from abi.scene.scene import Scene
from app.panels.stages.fields import Fields, Labels, Widgets
from app.panels.widgets import clamp, range_hint

LATTICE_LABELS: Labels = {kind.label: name for name, kind in LATTICES.items()}
_SPACING = "Distance between neighbouring nodes. Halving it gives up to eight times as many."


def mesh_inputs(gui: viser.GuiApi, scene: Scene) -> Widgets:
    """Add widgets of the ``mesh`` section of a scene."""
    low, high, step = _pitch_range(scene)
    return {
        "mesh.lattice": gui.add_dropdown(
            "grid type", tuple(LATTICE_LABELS), hint="How the workspace is cut into tetrahedra."
        ),
        "mesh.pitch": gui.add_slider(
            "spacing [{unit}]", low, high, step, clamp(scene.mesh.pitch, low, high)
        ),
        "mesh.seed": gui.add_number(
            "seed",
            scene.mesh.seed,
            min=0,
            step=1,
            hint="Another number gives another irregular grid. A whole one, 0 or more.",
        ),
    }


def fit_pitch(fields: Fields, scene: Scene) -> None:
    """Give the spacing's slider the range of a scene."""
    low, high, step = _pitch_range(scene)
    pitch = fields["mesh.pitch"]
    pitch.min, pitch.max, pitch.step = low, high, step
    pitch.hint = range_hint(_SPACING, low, high, scene.unit)


def show_seed(fields: Fields, scene: Scene) -> None:
    """Show the seed where the scene's lattice has one."""
    fields["mesh.seed"].visible = LATTICES[scene.mesh.lattice].seeded


def _pitch_range(scene: Scene) -> tuple[float, float, float]:
    """Least and most pitch of the slider and its step, [unit]; the least by the node budget."""
    longest = max(scene.workspace.size)
    finest = max(scene.mesh.finest_pitch(scene.workspace), longest / 90)
    digits = 1 - math.floor(math.log10(finest))
    finest = math.ceil(finest * 10.0**digits) / 10.0**digits
    return round(finest, 12), round(longest / 2, 6), round(longest / 600, 6)

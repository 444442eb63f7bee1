"""Inputs of stage 5 and the motion: fit of the quadratic, curve to follow, speed profile."""

from __future__ import annotations

import viser

from abi.arm_planning.motion_law import LAWS
from abi.scene.scene import Scene
from app.panels.length_step import length_step
from app.panels.stages.fields import Fields, Labels, Widgets

FITS: Labels = {
    "paper's fit (may hit)": "least_squares",
    "closest that does not hit": "clear",
    "several joined curves, none hitting": "pieces",
}
FOLLOWED: Labels = {
    "quadratic if it keeps clear": "auto",
    "quadratic": "quadratic",
    "B-spline": "bspline",
}
LAW_LABELS: Labels = {one.label: name for name, one in LAWS.items()}
_JERK_STEPS = 10
"""Steps of a length that are one of the jerk, which is a larger number."""
_LIMITS = ("speed", "acceleration", "joint_acceleration", "jerk")


def motion_inputs(gui: viser.GuiApi) -> Widgets:
    """Add widgets of the ``quadratic`` and ``motion`` sections of a scene."""
    return {
        "quadratic.mode": gui.add_dropdown(
            "curve",
            tuple(FITS),
            hint="The paper's least-squares arc may enter an obstacle. The closest arc that does "
            "not, or several joined smoothly, stay clear.",
        ),
        "motion.curve": gui.add_dropdown(
            "arm follows",
            tuple(FOLLOWED),
            hint="The curve that the arm executes: the B-spline where the quadratic comes too "
            "close.",
        ),
        "motion.law": gui.add_dropdown(
            "motion",
            tuple(LAW_LABELS),
            hint="The paper's three phases heed only the tool tip. The others also keep the joints "
            "within their speeds and accelerations.",
        ),
        "motion.speed": gui.add_number(
            "speed [{unit}/s]", 1.0, step=0.1, hint="Of the tool tip, once it has sped up. Above 0."
        ),
        "motion.acceleration motion.deceleration": gui.add_vector2(
            "speed up, brake [{unit}/s²]",
            (1.0, 1.0),
            step=0.1,
            hint="Acceleration from rest, and deceleration to rest. Both above 0.",
        ),
        "motion.joint_acceleration": gui.add_number(
            "joints [rad/s²]", 1.0, step=0.1, hint="Largest acceleration of any joint. Above 0."
        ),
        "motion.jerk": gui.add_number(
            "jerk [{unit}/s³]", 1.0, step=1.0, hint="Largest jerk of the tool tip. Above 0."
        ),
    }


def fit_steps(fields: Fields, scene: Scene) -> None:
    """Give the limits' boxes steps that suit the lengths of a scene."""
    step = length_step(scene)
    fields["motion.speed"].step = fields["motion.acceleration"].step = step
    fields["motion.jerk"].step = _JERK_STEPS * step


def show_limits(fields: Fields) -> None:
    """Show the boxes that the chosen law asks for."""
    law = LAW_LABELS.get(fields["motion.law"].value)
    uses = frozenset[str]() if law is None else LAWS[law].uses
    for name in _LIMITS:
        fields[f"motion.{name}"].visible = name in uses

"""Table of the arm models that a scene can name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from abi.arm_planning.paper_arm_model import PaperArmModel
from abi.arm_planning.urdf_arm_model import UrdfArmModel
from abi.scene.arm_settings import ArmSettings

Unit = Literal["m", "cm", "mm"]

ArmModel = PaperArmModel | UrdfArmModel
"""An arm and its inverse kinematics, by formulas or by damped least squares."""

MODELS: dict[str, Callable[[ArmSettings, Unit], ArmModel]] = {
    "abi": PaperArmModel,
    "urdf": UrdfArmModel,
}
"""Arm models by the names that ``arm.model`` takes."""


def model_of(settings: ArmSettings, unit: Unit = "cm") -> ArmModel:
    """The arm that a scene's settings describe; lengths in the scene's unit."""
    return MODELS[settings.model](settings, unit)

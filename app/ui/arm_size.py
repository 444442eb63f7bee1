"""Arms whose size is not that of the scene."""

from __future__ import annotations

import numpy as np

from abi.obstacles.pose import METRES
from abi.robot.urdf.robot import Robot, joints_to
from abi.scene.arm_settings import ArmSettings
from abi.scene.scene import Scene
from app.ui.numbers import format_setting

MADE_FOR_ARMS = "kitchen-ur5e"
"""Shipped scene for arms of about a metre."""
_LENGTHS = ("a1", "a2", "a3", "a4", "a5")
"""Fields of the lengths of the paper's arm."""
_PAPER_SIDE = 6.0
"""Side of the paper's workspace, [cm], for the lengths that its arm has by default."""
_MOST = 6.0
"""Length of an arm, over the workspace's side, from which it hardly fits."""


def size_note(robot: Robot, tip: str, workspace: float, unit: str) -> tuple[str, str] | None:
    """Sentence on an arm of unsuitable size, and its numbers; None if it may fit.

    Args:
        robot: the arm.
        tip: name of the link that follows the curve.
        workspace: longest side, [unit].
        unit: of the scene's lengths.
    """
    note = _size_note(_length(robot, tip, unit), workspace, unit)
    if note is None:
        return None
    title, numbers = note
    return title, f"{numbers} The scene {MADE_FOR_ARMS} is made for arms of about a metre."


def oversize(scene: Scene) -> float:
    """Length of an arm that is far too large for its scene, [unit]; 0 otherwise."""
    length = _scene_length(scene)
    return length if length > _MOST * max(scene.workspace.size) else 0.0


def _length(robot: Robot, tip: str, unit: str) -> float:
    """Length of the links to the tip, [unit]."""
    links = (float(np.linalg.norm(joint.origin[:3, 3])) for joint in joints_to(robot, tip))
    return sum(links) / METRES[unit]


def scene_size_note(scene: Scene) -> tuple[str, str] | None:
    """Note on an arm's size relative to its workspace, see :func:`size_note`."""
    workspace, unit = max(scene.workspace.size), scene.unit
    if scene.arm.model == "urdf":
        return size_note(scene.arm.robot, scene.arm.tool, workspace, unit)
    return _size_note(_scene_length(scene), workspace, unit)


def fitting_lengths(scene: Scene) -> dict[str, float]:
    """Lengths of the paper's arm, [unit], scaled to the workspace as in the paper."""
    usual, factor = ArmSettings(), max(scene.workspace.size) / _PAPER_SIDE
    return {name: float(f"{factor * getattr(usual, name):.3g}") for name in _LENGTHS}


def _size_note(length: float, workspace: float, unit: str) -> tuple[str, str] | None:
    if 0 < length < workspace / _MOST:
        title = "This arm is too short for the scene"
    elif length > _MOST * workspace:
        title = "This arm is too large for the scene"
    else:
        return None
    return title, (
        f"Its links are {format_setting(float(f'{length:.2g}'))} {unit} long in all; the "
        f"workspace measures {format_setting(workspace)} {unit}."
    )


def _scene_length(scene: Scene) -> float:
    """Length of the links of a scene's arm, [unit]."""
    if scene.arm.model == "urdf":
        return _length(scene.arm.robot, scene.arm.tool, scene.unit)
    return float(sum(getattr(scene.arm, name) for name in _LENGTHS))

"""Arms whose size is not that of the scene."""

from __future__ import annotations

import numpy as np

from abi.obstacles.pose import METRES
from abi.robot.robot import Robot, joints_to
from abi.scene.scene import Scene
from app.numbers import format_setting

MADE_FOR_ARMS = "kitchen-ur5e"
"""Shipped scene for arms of about a metre."""
_MOST = 6.0
"""Length of an arm, in sides of the workspace, from which it hardly fits."""


def size_note(robot: Robot, tip: str, workspace: float, unit: str) -> tuple[str, str] | None:
    """Fault of an arm's size, in words and in numbers; None where it may fit.

    Args:
        robot: the arm.
        tip: name of the link that follows the curve.
        workspace: longest side, [unit].
        unit: of the scene's lengths.
    """
    length = _length(robot, tip, unit)
    if 0 < length < workspace / _MOST:
        title = "This arm is too short for the scene"
    elif length > _MOST * workspace:
        title = "This arm is too large for the scene"
    else:
        return None
    return title, (
        f"Its links are {format_setting(float(f'{length:.2g}'))} {unit} long in all; the "
        f"workspace measures {format_setting(workspace)} {unit}. The scene {MADE_FOR_ARMS} is "
        "made for arms of about a metre."
    )


def oversize(scene: Scene) -> float:
    """Length of a scene's arm, [unit], that is far too large for it; 0 for any other arm."""
    if scene.arm.model != "urdf":
        return 0.0
    length = _length(scene.arm.robot, scene.arm.tool, scene.unit)
    return length if length > _MOST * max(scene.workspace.size) else 0.0


def _length(robot: Robot, tip: str, unit: str) -> float:
    """Length of the links to the tip, [unit]."""
    links = (float(np.linalg.norm(joint.origin[:3, 3])) for joint in joints_to(robot, tip))
    return sum(links) / METRES[unit]


def scene_size_note(scene: Scene) -> tuple[str, str] | None:
    """The same of a scene's arm; None for the paper's, whose lengths are typed."""
    if scene.arm.model != "urdf":
        return None
    return size_note(scene.arm.robot, scene.arm.tool, max(scene.workspace.size), scene.unit)

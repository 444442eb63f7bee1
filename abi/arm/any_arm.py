"""The arm of a scene: the paper's, or one that a URDF describes."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from abi.arm.arm import Arm, place, urdf
from abi.arm.trajectory import rest_pose
from abi.arm.urdf_arm import UrdfArm, urdf_arm
from abi.arrays import FloatArray
from abi.obstacles.pose import Vec3
from abi.scene.scene import ArmSettings

AnyArm = Arm | UrdfArm


def arm_of(settings: ArmSettings, unit: Literal["m", "cm", "mm"] = "cm") -> AnyArm:
    """The arm that a scene's settings describe; lengths in the scene's unit."""
    if settings.model == "abi":
        return Arm.from_settings(settings, unit)
    return urdf_arm(settings.robot, settings.tool, settings.base, settings.axis, unit)


def waiting_pose(arm: AnyArm, settings: ArmSettings, point: Vec3) -> FloatArray:
    """Joint positions with the tool at ``point``, or as near as it can be, (n,)."""
    if isinstance(arm, Arm):
        return rest_pose(arm, settings, point)
    return arm.first_poses(np.array(point))[0]


def description(arm: AnyArm) -> str:
    """URDF of an arm, in metres, standing at the origin of its root link."""
    return urdf(arm) if isinstance(arm, Arm) else arm.chain.robot.urdf


class PlacedCapsule(NamedTuple):
    """A capsule of a link at joint positions.

    Attributes:
        link: name of the link.
        radius: [unit].
        ends: of its segment at each of the positions, shape (k, 2, 3), [unit], world.
    """

    link: str
    radius: float
    ends: FloatArray


def placed_capsules(arm: AnyArm, positions: FloatArray) -> list[PlacedCapsule]:
    """Capsules of all links at joint positions (k, n)."""
    if isinstance(arm, Arm):
        ends, radii = place(arm, positions), [one.radius for one in arm.capsules]
    else:
        ends, radii = arm.place(positions), arm.radii.tolist()
    names = [one.link for one in arm.capsules]
    return [PlacedCapsule(*one) for one in zip(names, radii, ends.swapaxes(0, 1), strict=True)]

"""Scene nodes of an arm that a URDF describes, with the links that each joint carries."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace

import numpy as np
import viser.transforms

from abi.arrays import ByteArray, FloatArray
from abi.obstacles.pose import rotation
from abi.robot.kinematics.chain_kernels import POSE
from abi.robot.urdf.link import LinkShape
from abi.robot.urdf_arm import UrdfArm
from abi.scene.scene import Scene
from app.layers.arm.arm_nodes import ArmNodes
from app.layers.arm.link_body import link_glbs
from app.layers.arm.link_colours import muted
from app.shared.computed_once import computed_once

_COLOURS: ByteArray = np.array([[(226, 230, 234)], [(96, 108, 122)]], np.uint8)
"""Of every other link without a colour of its own, so that one sees where they meet."""


_KEPT = 4
"""Arms whose bodies are kept: some megabytes each."""


def look(arm: UrdfArm) -> tuple[Hashable, ...]:
    """What the drawings of its links depend on; its base may stand anywhere."""
    return arm.chain.robot, arm.tip, arm.unit, frozenset(arm.held.items()), arm.joints


def build(nodes: ArmNodes, arm: UrdfArm, base: str) -> None:
    """Add a node a joint that moves, and the links that it carries, below the base's node."""
    names = [base]
    for number, joint in enumerate(arm.chain.joints):
        # the base is first, so that the joint before one is where its number plus one is
        names.append(f"{names[arm.chain.table.before[number] + 1]}/joint{number}")
        slides = joint.kind == "prismatic"
        nodes.add_joint(names[-1], joint_origin(arm, number), joint.axis, number, slides)
    links = [*arm.chain.frames.items()]
    for number, glbs in bodies(arm).items():
        link, frame = links[number]
        nodes.add_body(link, f"{names[frame + 1]}/{number}", glbs)


def rest_pose(arm: UrdfArm, scene: Scene) -> FloatArray:
    """The first pose found with the tool on the start, (n,)."""
    return arm.first_poses(np.array(scene.start))[0]


@computed_once(_KEPT, by=look)
def bodies(arm: UrdfArm) -> dict[int, tuple[bytes, bytes]]:
    """Bodies of the links that are drawn, by their numbers among those that the chain carries.

    They are made once for all tabs in which an arm looks alike.
    """
    made = {}
    for number, (name, frame) in enumerate(arm.chain.frames.items()):
        link = arm.chain.robot.links[name]
        if link.drawn:
            pose = np.array(arm.chain.places[name])
            if frame < 0:
                pose = np.linalg.inv(root_pose(arm)) @ pose
            shapes = [_muted(shape, number % 2) for shape in link.drawn]
            made[number] = link_glbs(shapes, pose, 1 / arm.metres)
    return made


def joint_origin(arm: UrdfArm, number: int) -> viser.transforms.SE3:
    """Frame of a joint at position 0 in that of the joint before it, or in the base, [unit]."""
    packed = arm.chain.table.origins[POSE * number : POSE * (number + 1)]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = packed[:9].reshape(3, 3), packed[9:]
    if arm.chain.table.before[number] < 0:
        pose = np.linalg.inv(root_pose(arm)) @ pose
    pose[:3, 3] /= arm.metres
    return viser.transforms.SE3.from_matrix(pose)


def root_pose(arm: UrdfArm) -> FloatArray:
    """World from the root link, (4, 4), [m]."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation(arm.wxyz), arm.base * arm.metres
    return pose


def joint_values(arm: UrdfArm, positions: FloatArray) -> FloatArray:
    """Positions (k, m) of an arm's joints, [rad] or [unit], of those (k, n) that a motion has.

    Those that mimic another are among them.
    """
    table = arm.chain.table
    values = (positions / arm.scales)[:, table.source] * table.factor + table.offset
    return np.asarray(np.where(table.slides, values / arm.metres, values))


def _muted(shape: LinkShape, second: int) -> LinkShape:
    """A shape in the colours that it is drawn in; ``second``: whether of every other link."""
    own = muted(shape.colours, bool(second)) if len(shape.colours) else _COLOURS[second]
    return replace(shape, colours=own)

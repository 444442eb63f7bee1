"""Scene nodes of the paper's arm."""

from __future__ import annotations

import numpy as np
import viser.transforms

from abi.arm_planning.motion import trajectory
from abi.arrays import FloatArray
from abi.robot.bodies.link_solid import LinkSolid, rotation_of
from abi.robot.paper_arm import arm_links
from abi.robot.paper_arm.paper_arm import JOINT_AXES, SLIDES, PaperArm
from abi.robot.urdf.link import LinkShape
from abi.scene.scene import Scene
from app.layers.arm.arm_nodes import ArmNodes
from app.layers.arm.link_body import link_glbs
from app.shared.computed_once import computed_once

_KEPT = 8
"""Arms of different sizes that are kept."""


def look(arm: PaperArm) -> tuple[float, ...]:
    """Lengths of the links, which its nodes depend on."""
    return arm.a1, arm.a2, arm.a3, arm.a4, arm.a5


def build(nodes: ArmNodes, arm: PaperArm, base: str) -> None:
    """Add a node for each joint and one for the tool, and the bodies, below the base's node."""
    (pedestal, glbs), *moved = bodies(arm).items()
    *heights, tool = arm_links.joint_heights(*look(arm))
    name = base
    nodes.add_body(pedestal, name, glbs)
    joints = zip(moved, heights, JOINT_AXES, enumerate(SLIDES), strict=True)
    for (link, glbs), height, axis, (column, slides) in joints:
        name = f"{name}/{link}"
        origin = viser.transforms.SE3.from_translation(np.array([0.0, 0.0, height]))
        nodes.add_joint(name, origin, np.array(axis), column, slides)
        nodes.add_body(link, name, glbs)
    nodes.add_frame(f"{name}/tool", tool)


def rest_pose(arm: PaperArm, scene: Scene) -> FloatArray:
    """Pose (6,) with the tool on the start."""
    return trajectory.rest_pose(arm, scene.arm, scene.start)


def joint_values(arm: PaperArm, positions: FloatArray) -> FloatArray:
    """Values (k, 6) of the scene nodes' joints, which are the joint positions (k, 6)."""
    return positions


@computed_once(_KEPT, by=look)
def bodies(arm: PaperArm) -> dict[str, tuple[bytes, bytes]]:
    """Bodies of the links that have any, from the base to the gripper, as :func:`link_glbs`.

    They are made once for all tabs.
    """
    links = arm_links.links(*look(arm))
    shapes = {link: [_shape(one) for one in solids] for link, solids in links.items() if solids}
    return {link: link_glbs(own, np.eye(4), 1.0) for link, own in shapes.items()}


def _shape(solid: LinkSolid) -> LinkShape:
    """A solid with its colour as the links of other arms have them."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation_of(solid.rpy), solid.xyz
    radius, _, height = solid.size
    size = solid.size if solid.shape == "box" else (radius, height, 0.0)
    colours = (255 * np.array([arm_links.COLOURS[solid.material]])).astype(np.uint8)
    return LinkShape(solid.shape, size, pose, np.empty((0, 3)), np.empty((0, 3), np.int32), colours)

"""Inverse kinematics spread over a mesh: the tip is at each node, and it ends when told."""

from __future__ import annotations

from functools import partial

import numpy as np

from abi import progress
from abi.arm_planning.exclusion.node_configurations import spread_over
from abi.robot.kinematics.start_poses import REACHED
from abi.scene.settings import MeshSettings, Workspace
from abi.tet_mesh.tet_mesh import tetrahedralise
from tests.abi.arm_planning.test_chain_certificate import some_arm


def _wanted(asked: list[None]) -> bool:
    """Note that it was asked, and cancel nothing."""
    asked.append(None)
    return False


def test_the_tip_is_at_every_node_reached_and_the_result_may_become_unwanted_meanwhile() -> None:
    arm, asked = some_arm("ur5e"), list[None]()
    pose = np.array([0.3, -1.4, 1.6, -1.8, -1.5, 0.2])
    start = arm.tool(pose[None])[0]
    low, high = (tuple((start + side * 12).tolist()) for side in (-1, 1))
    mesh = tetrahedralise(Workspace(min=low, max=high), MeshSettings(pitch=1.6))

    with progress.watched_by(partial(_wanted, asked)):
        found = spread_over(arm, mesh, start, pose, pose)

    tips = arm.tool(found.positions[found.reached])
    missed = np.linalg.norm(tips - mesh.points[found.reached], axis=1)
    assert found.reached.mean() > 0.9
    assert missed.max() <= 2 * REACHED * arm.reach
    assert len(asked) > len(mesh.points) / 2500

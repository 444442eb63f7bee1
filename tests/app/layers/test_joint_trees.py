"""What is drawn of a search in the space of the joints."""

from __future__ import annotations

import numpy as np
import pytest

import abi
from abi.robot.urdf_arm import UrdfArm
from app.drawing.lines import NO_SEGMENTS
from app.layers.arm.joint_trees import tree_lines
from app.panels.stages.stage_headings import _results


@pytest.mark.slow
def test_every_edge_is_drawn_from_one_place_of_the_tool_to_the_other() -> None:
    scene = abi.load_scene("kitchen-ur5e")
    plan = abi.plan(scene.replace(arm={"axis": None, "search": "joints"}))
    assert plan.joint_search is not None
    assert plan.joint_search.path is not None
    assert isinstance(plan.arm, UrdfArm)
    *trees, along = tree_lines(plan)
    for tree, lines in zip(plan.joint_search.trees, trees, strict=True):
        pieces = lines.reshape(len(tree.edges), -1, 2, 3)
        tool = plan.arm.tool(tree.positions)
        np.testing.assert_allclose(pieces[:, 0, 0], tool[tree.edges[:, 0]], atol=1e-6)
        np.testing.assert_allclose(pieces[:, -1, 1], tool[tree.edges[:, 1]], atol=1e-6)
        np.testing.assert_array_equal(pieces[:, 1:, 0], pieces[:, :-1, 1])
    headings = _results(plan)
    told = {headings[name] for name in ("search", "bspline", "quadratic")}
    assert told <= {"not used", "not followed"}
    path = along.reshape(len(plan.joint_search.path) - 1, -1, 2, 3)
    np.testing.assert_allclose(path[1:, 0, 0], path[:-1, -1, 1], atol=1e-6)


def test_nothing_is_drawn_of_a_plan_on_the_mesh() -> None:
    lines = tree_lines(abi.plan(abi.load_scene("paper")))
    assert all(np.array_equal(one, NO_SEGMENTS) for one in lines)

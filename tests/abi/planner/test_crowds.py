"""Plans among many obstacles, against the obstacles one by one."""

from __future__ import annotations

import numpy as np
import pytest

from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.planner import Planner
from benchmarks import crowds
from tests.abi.shape_distances import segment_distance
from tests.random_scenes import crowd


def test_a_crowd_is_passed_at_the_clearance_asked_for() -> None:
    scene = crowd(90, 1, 2_000)
    plan = Planner(compile=False)(scene)

    assert plan.taut is not None
    assert plan.path is not None
    assert plan.taut.length <= plan.path.length
    margin = scene.spline.clearance + scene.workspace.slack
    ends = np.min([one.signed_distance(plan.taut.points[[0, -1]]) for one in scene.obstacles])
    for one in scene.obstacles:
        near = segment_distance(one, plan.taut.points[:-1], plan.taut.points[1:]).min()
        assert near >= min(margin, ends) - 1e-8
    assert plan.bspline is not None
    assert plan.bspline.clearance.certified
    nearest, _ = ObstacleSet(scene.obstacles).nearest(plan.taut.points)
    assert nearest.min() >= plan.taut.clearance - 1e-9


@pytest.mark.slow
def test_the_benchmark_of_crowds_finds_none_that_is_wrong() -> None:
    rows = crowds.measure((10, 60), meshes=0.1)

    assert [row["obstacles"] for row in rows] == [10, 60]
    assert all(row["solved"] for row in rows)

"""An object that is held counts as hardly smaller than it is, so that it may stand."""

from __future__ import annotations

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.primitives import Box
from abi.obstacles.triangle_mesh.repair import clean
from abi.robot.attached_object import STANDING, with_object
from abi.robot.urdf.robot_files import robot_from_archive
from tests.abi.robot.robots import arm, packed


@given(st.integers(0, 2**31))
def test_a_held_mesh_loses_little_at_its_sides_and_no_more_than_twice_that_at_its_tips(
    seed: int,
) -> None:
    random = np.random.default_rng(seed)
    points = random.normal(size=(8, 3)) * random.uniform((0.1, 0.01, 0.01), (0.6, 0.2, 0.05))
    whole = scipy.spatial.ConvexHull(points)
    shape = MeshShape.of(clean(points, whole.simplices.astype(np.int32)))
    robot = robot_from_archive(packed({"a.urdf": arm()}))
    (held,) = with_object(robot, "d", shape, 1.0, STANDING).links["held_object"].shapes

    away = held.vertices @ whole.equations[:, :3].T + whole.equations[:, 3]
    assert away.max() < 0
    rest = scipy.spatial.ConvexHull(held.vertices)
    corners = points[whole.vertices]
    nearest = [
        scipy.optimize.nnls(
            np.vstack([held.vertices[rest.vertices].T, 1e3 * np.ones(len(rest.vertices))]),
            np.append(corner, 1e3),
        )[1]
        for corner in corners
    ]
    assert max(nearest) == pytest.approx(0, abs=2 * STANDING + 1e-6)


def test_a_held_object_and_its_joint_have_names_that_the_robot_has_not() -> None:
    text = arm().replace('name="q"', 'name="held_object_joint"')
    robot = robot_from_archive(packed({"a.urdf": text}))
    holding = with_object(robot, "d", Box(size=(0.1, 0.1, 0.1)), 1.0)
    assert len(holding.links) == len(robot.links) + 1
    names = [one.name for one in holding.joints]
    assert "held_object_joint" in names
    assert len({*names}) == len(names) == len(robot.joints) + 1

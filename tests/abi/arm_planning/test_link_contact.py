"""Contacts of links by their shapes as they are given, against many points on these."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from abi.arm_planning.world.arm_worlds import chain_world
from abi.arm_planning.world.link_contact import _gap, are_apart, link_gap
from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitives import Box, Cylinder, Sphere
from abi.robot.bodies.link_solids import SIDES, LinkSolids
from abi.robot.urdf_arm import UrdfArm
from tests.abi.arm_planning.test_chain_distances import some_arm
from tests.random_geometry import random_obstacle

_SPACING = 0.02
"""Distance of any point of a link's surface from the nearest of those that stand for it, [m]."""


def surface_points(arm: UrdfArm, link: str, pose: FloatArray) -> FloatArray:
    """Points (k, 3) on the surface of a link's meshes at a pose, [unit], world."""
    shapes = arm.chain.robot.links[link].shapes
    corners = np.concatenate(
        [one.vertices[one.faces] @ one.pose[:3, :3].T + one.pose[:3, 3] for one in shapes]
    )
    found = [corners.reshape(-1, 3)]
    while len(corners):
        sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        corners = corners[sides > _SPACING]
        a, b, c = corners.swapaxes(0, 1)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        found.append(np.concatenate([ab, bc, ca]))
        parts = (a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)
        corners = np.concatenate([np.stack(part, axis=1) for part in parts])
    points = np.concatenate(found)
    number, frame = arm.chain.frames[link], np.eye(4)
    if number >= 0:
        frame[:3] = arm.chain.poses(pose[None] / arm.scales)[0, number]
    world = frame @ arm.chain.places[link]
    return np.asarray((points @ world[:3, :3].T + world[:3, 3]) / arm.metres)


@pytest.mark.slow
def test_a_link_touches_a_ball_where_a_point_of_it_is_in_the_ball() -> None:
    arm, random, seen = some_arm("ur5e"), np.random.default_rng(0), set()
    pose = random.uniform(*arm.chain.usual_range().T) * arm.scales
    for link in sorted({one.link for one in arm.capsules if one.frame >= 0})[::2]:
        points, radius = surface_points(arm, link, pose), 0.05 / arm.metres
        surface = scipy.spatial.cKDTree(points)
        for _ in range(8):
            centre = points[random.integers(len(points))] + random.normal(0, radius, 3)
            ball = Sphere(radius=radius, position=tuple(centre.tolist()))
            obstacles = ObstacleSet((ball,))
            around = chain_world(arm, obstacles, -1e3)
            found = link_gap(arm, around, pose, (link, 0))
            assert found is not None
            gap, slack = float(surface.query(centre)[0]) - radius, _SPACING / arm.metres
            assert found <= 0 or gap > -1e-9
            if found <= 0:
                seen.add(True)
            elif gap > slack:
                seen.add(False)
                assert found >= gap - slack
    assert seen == {True, False}


@pytest.mark.slow
def test_two_links_are_as_far_apart_as_their_points_whatever_other_joints_do() -> None:
    arm, random = some_arm("ur5e"), np.random.default_rng(1)
    around, apart = chain_world(arm, ObstacleSet(), -1e3), 0
    low, high = arm.chain.usual_range().T
    for pose in random.uniform(low, high, (2, len(low))) * arm.scales:
        pair = "forearm_link", "wrist_3_link"
        found = link_gap(arm, around, pose, pair)
        assert found is not None
        assert (found <= 0) != are_apart(arm, pose, *pair)
        surface, points = (surface_points(arm, link, pose) for link in pair)
        gap = float(scipy.spatial.cKDTree(surface).query(points)[0].min())
        if found > 0:
            apart += 1
            assert abs(found - gap) < 2 * _SPACING / arm.metres
    assert apart


@given(seed=st.integers(0, 10**6))
def test_the_lowest_point_of_shapes_is_that_of_the_boxes_around_them(seed: int) -> None:
    random = np.random.default_rng(seed)
    shapes = tuple(random_obstacle(random) for _ in range(random.integers(1, 4)))
    solids = LinkSolids(shapes)
    lowest, size = float(solids.bounds[0][2]), float(np.ptp(solids.bounds, axis=0).max())
    assert solids.lowest(np.eye(3), np.array([1.0, 2, 3])) == pytest.approx(
        lowest + 3, abs=size * (1 - np.cos(np.pi / SIDES))
    )
    upside_down = np.diag([1.0, -1, -1])
    assert solids.lowest(upside_down, np.zeros(3)) == pytest.approx(
        -float(solids.bounds[1][2]), abs=size * (1 - np.cos(np.pi / SIDES))
    )


@pytest.mark.parametrize(
    ("face", "least", "most"), [(0.99, -1, 0), (0.999, None, None), (1.01, 0, 0.02)]
)
def test_only_roundness_decides_whether_a_drum_touches_a_wall(
    face: float, least: float | None, most: float | None
) -> None:
    """The drum's edges are those of a polygon in it, whose sides are 0.9979 from its axis."""
    drum, half = LinkSolids((Cylinder(radius=1, height=1),)), math.pi / 48
    wall = LinkSolids((Box(size=(2, 9, 9), position=(face + 1, 2, 0)),))
    turn = Rotation.from_euler("z", half).as_matrix()
    found = _gap(drum, wall, (turn, np.zeros(3)))
    if found is None or least is None or most is None:
        assert found is least is most
    else:
        assert least <= found <= most

"""Segments of the tool that are said to be clear for the arm are, and how the elbow bends."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from abi.arm_planning.branch.elbow_branch import ElbowBranch
from abi.arm_planning.paper_arm_model import paper_arm
from abi.arm_planning.world.arm_worlds import paper_arm_world
from abi.arrays import FloatArray
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.triangle_mesh.repair import clean
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.robot.paper_arm.pose_kernels import bend_near, neighbourhood_of, pose_of, reaches
from abi.scene.arm_settings import ArmSettings
from tests.abi import meshes
from tests.random_geometry import random_obstacle
from tests.thorough import examples

BOX = clean(*meshes.box((0.7, 0.8, 0.6)))
KNOT = clean(*meshes.knot(600))
SEED = st.integers(0, 2**32 - 1)


def random_arm(random: np.random.Generator) -> PaperArm:
    base = (float(random.uniform(1, 5)), float(random.uniform(-4, -1)), 0.0)
    lengths = dict(zip(("a3", "a4", "a5"), random.uniform(2, 6, 3).tolist(), strict=True))
    return paper_arm(ArmSettings(base=base, **lengths))


@settings(max_examples=examples(20), deadline=None)
@given(SEED)
def test_the_elbow_bends_no_more_than_its_bound(seed: int) -> None:
    random = np.random.default_rng(seed)
    arm = random_arm(random)
    table = arm.table("up" if random.random() < 0.5 else "down")
    forearm = arm.a4 + arm.a5
    middle, way = random.uniform(0.5, 5.5, 3), random.normal(size=3)
    way /= np.linalg.norm(way)
    half = float(random.uniform(0.01, 0.5))
    assume(reaches(table, tuple(middle.tolist()), forearm))
    pose = pose_of(table, tuple(middle.tolist()), forearm)
    near = neighbourhood_of(table, pose, half, 0.0)
    assume(np.isfinite(near.by_tool))
    steps = np.linspace(-half, half, 81)
    elbows = np.array(
        [pose_of(table, tuple((middle + t * way).tolist()), forearm).elbow for t in steps]
    )
    second = np.diff(elbows, 2, axis=0) / (steps[1] - steps[0]) ** 2
    bound = bend_near(table, near)
    assert np.linalg.norm(second, axis=1).max() <= bound * (1 + 1e-6) + 1e-7


@settings(max_examples=40, deadline=None)
@given(SEED)
def test_legs_are_clear_where_they_have_a_certificate_and_no_place_that_touches(seed: int) -> None:
    random = np.random.default_rng(seed)
    arm = random_arm(random)
    obstacles = [random_obstacle(random) for _ in range(int(random.integers(0, 4)))]
    if random.random() < 0.3:
        place = tuple(random.uniform(1, 6, 3).tolist())
        surface = BOX if random.random() < 0.5 else KNOT
        obstacles.append(MeshShape.of(surface, position=place))
    collision_world = paper_arm_world(arm, ObstacleSet(tuple(obstacles)), 0.0)
    slides = (0.0, float(random.choice([0.0, 0.2])))
    branch = ElbowBranch(arm, "up", collision_world, slides, 0.05, 0.0)
    points = random.uniform(0.5, 5.5, (12, 3))
    clear = branch.clear_segments(points)
    for k in range(len(clear)):
        fault = branch.polyline_refutation(points[k : k + 2])
        assert clear[k] or fault is not None
        if clear[k]:
            assert fault is None or not fault.decided
            assert _poses_clear(branch, points[k], points[k + 1])


def _poses_clear(branch: ElbowBranch, a: FloatArray, b: FloatArray) -> bool:
    """Check whether no place of many on a segment is found not to be clear."""
    places = a + np.linspace(0, 1, 50)[:, None] * (b - a)
    faults = (branch.polyline_refutation(place[None]) for place in places)
    return not any(fault is not None and fault.decided for fault in faults)

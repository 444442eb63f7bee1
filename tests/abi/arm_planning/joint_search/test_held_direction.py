"""Angles of a tool beside a direction: their bounds between poses, and joints that keep them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from abi.arm_planning.joint_search.held_direction import HeldDirection
from abi.arm_planning.joint_search.held_search import HeldSearch
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.joint_search.search_joints import JointSearchEffort
from abi.arm_planning.world.arm_worlds import chain_world
from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.verify.exact.solids import vector
from tests.abi.arm_planning.test_chain_certificate import between, some_arm

ARMS = ("ur5e", "panda", "sliding", "linkage")
seeds = st.integers(0, 2**31)


def some_hold(name: str, random: np.random.Generator, tolerance: float = 0.1) -> HeldDirection:
    return HeldDirection(some_arm(name), random.normal(size=3), tolerance)


def angle_at(hold: HeldDirection, joints: FloatArray) -> float:
    """The angle by the cosine, from the poses of the links."""
    tip = hold.arm.chain.poses((joints / hold.arm.scales)[None])[0, -1, :, 2]
    return math.acos(min(max(float(tip @ hold.direction), -1.0), 1.0))


@pytest.mark.parametrize("name", ARMS)
@settings(max_examples=25)
@given(seeds, st.floats(1e-3, 1.5))
def test_no_pose_on_a_straight_way_is_off_by_more_than_its_bound(
    name: str, seed: int, size: float
) -> None:
    random = np.random.default_rng(seed)
    hold = some_hold(name, random)
    low, high = hold.arm.limits.T
    start = random.uniform(np.maximum(low, -4), np.minimum(high, 4))
    end = np.clip(start + random.uniform(-size, size, len(low)) * hold.arm.scales, low, high)
    bound = float(hold.largest_angles(np.stack([start, end]))[0])
    dense = [angle_at(hold, one) for one in np.linspace(start, end, 60)]
    assert max(dense) <= bound + 1e-7
    # halves are bounded at least as well, and short ways well
    fine = hold.largest_angles(np.linspace(start, end, 200))
    assert max(dense) - 1e-3 <= fine.max() <= bound + 1e-9
    assert fine.max() <= max(dense) + 0.03 * size


@pytest.mark.parametrize("name", ["ur5e", "panda"])
@settings(max_examples=15)
@given(seeds, st.floats(0.01, 0.5))
def test_joints_are_brought_near_within_their_limits(
    name: str, seed: int, tolerance: float
) -> None:
    random = np.random.default_rng(seed)
    hold = some_hold(name, random, tolerance)
    low, high = hold.arm.limits.T
    near = hold.brought_near(random.uniform(np.maximum(low, -2), np.minimum(high, 2)))
    assume(near is not None)
    assert near is not None
    assert angle_at(hold, near) <= tolerance
    assert ((low - 1e-12 <= near) & (near <= high + 1e-12)).all()
    again = hold.brought_near(near)
    assert again is not None
    assert (again == near).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ur5e", "panda"])
def test_a_path_that_is_found_keeps_the_direction_all_along(name: str) -> None:
    found = 0
    for seed in range(4):
        random = np.random.default_rng(seed)
        hold = some_hold(name, random)
        arm = some_arm(name)
        space = JointSpace(arm, chain_world(arm, ObstacleSet(()), -1e6), 0.0)
        low, high = arm.chain.usual_range().T
        drawn = (hold.brought_near(one) for one in random.uniform(low, high, (30, len(low))))
        poses = [one for one in drawn if one is not None and space.clear(np.stack([one, one]))]
        away = [space.distance(np.stack([poses[0], one])) for one in poses[1:]]
        ends = poses[0][None], poses[1 + int(np.argmin(away))][None]
        search = HeldSearch(space, hold).search(*ends, JointSearchEffort(samples=2_000))
        if search.path is None:
            continue
        found += 1
        assert (search.path[[0, -1]] == np.concatenate(ends)).all()
        assert space.clear(search.path)
        assert hold.angles(between(search.path, 40)).max() <= hold.tolerance
    assert found >= 2


def test_a_direction_is_kept_as_a_unit_vector() -> None:
    hold = HeldDirection(some_arm("ur5e"), np.array([0.0, 3.0, -4.0]), 0.1)
    assert vector(hold.direction.tolist()) == vector([0.0, 0.6, -0.8])

"""Paths of the joints: their laws, and searches on a grid and dense samples to compare with."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
import pytest
import scipy
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from abi.arm_planning.certificates.chain_certificate import certify_chain
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.joint_search.search_joints import (
    JointSearch,
    JointSearchEffort,
    paths_found,
    search_joints,
)
from abi.arm_planning.joint_search.shorten import shortened
from abi.arm_planning.world.arm_worlds import chain_world
from abi.arm_planning.world.chain_distances import (
    Poses,
    floor_distances,
    hull_distances_to,
    obstacle_distances,
    own_distances,
)
from abi.arrays import BoolArray, FloatArray
from abi.curves.clearance.certificate import Certificate
from abi.errors import ArgumentError
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitives import Sphere
from abi.progress import CancelledError, watched_by
from tests.abi.arm_planning.test_chain_certificate import between, some_arm, some_obstacles

ARMS = ("ur5e", "panda", "sliding", "linkage")
FEW = JointSearchEffort(samples=400, nodes=400, shortcuts=20)
seeds = st.integers(0, 2**31)


class Task(NamedTuple):
    """A random task of an arm, and what it keeps clear of."""

    space: JointSpace
    obstacles: ObstacleSet
    start: FloatArray
    goal: FloatArray

    def found(self, effort: JointSearchEffort = FEW) -> list[JointSearch]:
        """All that the search finds, one after the other."""
        return list(paths_found(self.space, self.start[None], self.goal[None], effort))


def some_task(name: str, seed: int) -> Task:
    one, random = some_arm(name), np.random.default_rng(seed)
    obstacles = some_obstacles(one, random)
    margin = float(random.uniform(0, 0.02)) * one.reach
    space = JointSpace(one, chain_world(one, obstacles, -1e3), margin)
    low, high = one.chain.usual_range().T * one.scales
    poses = random.uniform(low, high, (60, len(low)))
    clear = [pose for pose in poses if space.clear(np.stack([pose, pose]))]
    assume(len(clear) >= 2)
    return Task(space, obstacles, clear[0], clear[1])


@pytest.mark.slow
@settings(max_examples=8)
@given(st.sampled_from(ARMS), seeds)
def test_every_path_found_is_proven_keeps_limits_and_leads_from_start_to_goal(
    name: str, seed: int
) -> None:
    task = some_task(name, seed)
    space, found = task.space, task.found()
    assume(found[-1].path is not None)
    for one in found:
        assert one.path is not None
        proof = certify_chain(space.arm, one.path, space.collision_world, space.margin)
        assert isinstance(proof, Certificate)
        assert space.is_within(one.path)
        assert one.path[[0, -1]] == pytest.approx(np.stack([task.start, task.goal]), abs=1e-12)
        assert one.length == space.distance(one.path)


@pytest.mark.slow
@settings(max_examples=8)
@given(st.sampled_from(ARMS), seeds)
def test_every_edge_of_both_trees_is_clear_at_dense_samples(name: str, seed: int) -> None:
    task = some_task(name, seed)
    space, arm = task.space, task.space.arm
    for tree in task.found(JointSearchEffort(samples=40, nodes=40, shortcuts=0))[-1].trees:
        assert (tree.parents < np.arange(len(tree.parents))).all()
        assert space.is_within(tree.positions)
        for edge in tree.edges:
            way = tree.positions[edge]
            assert space.distance(way) < 1 + 1e-9
            poses = Poses.of(arm, between(way))
            assert solid_distances(space, task.obstacles, poses).min() > space.margin
            assert own_distances(arm, poses).min(initial=math.inf) > 0
            floor = space.collision_world.floor
            assert floor_distances(arm, floor, poses).min(initial=math.inf) > 0


def solid_distances(space: JointSpace, obstacles: ObstacleSet, poses: Poses) -> FloatArray:
    """Distances (k, c) of an arm's bodies to obstacles."""
    of_capsules = obstacle_distances(space.arm, obstacles, poses.ends)
    return hull_distances_to(space.arm, poses, space.collision_world, of_capsules, math.inf)[0]


@pytest.mark.slow
@settings(max_examples=8)
@given(st.sampled_from(ARMS), seeds)
def test_a_path_gets_shorter_and_no_shorter_than_the_straight_way(name: str, seed: int) -> None:
    task = some_task(name, seed)
    lengths = [one.length for one in task.found()]
    straight = task.space.distance(np.stack([task.start, task.goal]))
    assert all(later <= before + 1e-12 for before, later in itertools.pairwise(lengths))
    assert lengths[-1] >= straight - 1e-12


@pytest.mark.slow
@settings(max_examples=8)
@given(st.sampled_from(ARMS), seeds)
def test_equal_seeds_give_equal_searches_within_their_bounds(name: str, seed: int) -> None:
    task = some_task(name, seed)
    effort = JointSearchEffort(seed=seed, samples=30, nodes=12, shortcuts=5)
    first, second = (task.found(effort)[-1] for _ in range(2))
    assert first.samples <= 30
    assert all(len(tree.positions) <= 12 for tree in first.trees)
    assert (first.proofs, first.refused) == (second.proofs, second.refused)
    assert np.array_equal(first.trees[0].positions, second.trees[0].positions)
    assert first.length == second.length


class Grid(NamedTuple):
    """Poses of an arm of two joints on a grid.

    Attributes:
        poses: (k, k, 2).
        gaps: distance of the arm to obstacles, floor and itself at each, (k, k), [unit].
        moves: farthest that a link gets from where it is at the nearest pose, [unit].
    """

    poses: FloatArray
    gaps: FloatArray
    moves: float

    def regions(self, clear: BoolArray) -> FloatArray:
        """Number of the region that each pose belongs to, 0 of those that are not clear."""
        found, _ = scipy.ndimage.label(clear, np.ones((3, 3)))
        return np.asarray(found)


def grid_of(task_space: JointSpace, obstacles: ObstacleSet, size: int = 121) -> Grid:
    arm = task_space.arm
    sides = [np.linspace(low, high, size) for low, high in arm.limits]
    poses = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1)
    placed = Poses.of(arm, poses.reshape(-1, 2))
    gaps = [
        solid_distances(task_space, obstacles, placed).min(axis=1) - task_space.margin,
        own_distances(arm, placed).min(axis=1, initial=math.inf),
        floor_distances(arm, task_space.collision_world.floor, placed).min(axis=1),
    ]
    half = np.array([side[1] - side[0] for side in sides]) / 2
    levers = np.concatenate([arm.levers, arm.pair_levers])
    return Grid(poses, np.min(gaps, axis=0).reshape(size, size), float((levers @ half).max()))


@pytest.mark.slow
def test_it_finds_a_path_where_a_grid_has_one_and_none_where_a_grid_shows_that_there_is_none() -> (
    None
):
    """Of an arm of two joints, one that a third follows, among spheres at random places."""
    arm, seen = some_arm("linked"), {True: 0, False: 0}
    for seed in range(32):
        random = np.random.default_rng(seed)
        middle = arm.tool(random.uniform(-2, 2, (5, 2)))
        spheres = [Sphere(radius=0.15, position=tuple(place)) for place in middle.tolist()]
        obstacles = ObstacleSet(tuple(spheres))
        space = JointSpace(arm, chain_world(arm, obstacles, -1e3), 0.0)
        grid = grid_of(space, obstacles)
        surely = grid.regions(grid.gaps > 3 * grid.moves)
        perhaps = grid.regions(grid.gaps > -grid.moves)
        inside = np.argwhere(surely > 0)
        if len(inside) < 2:
            continue
        a, b = (tuple(inside[k]) for k in random.choice(len(inside), 2, replace=False))
        if (surely[a] == surely[b]) == (perhaps[a] == perhaps[b]):
            joined = bool(surely[a] == surely[b])
            effort = JointSearchEffort(samples=20_000 if joined else 300, shortcuts=0)
            result = search_joints(space, grid.poses[a][None], grid.poses[b][None], effort)
            assert (result.path is not None) == joined
            seen[joined] += 1
        if min(seen.values()) == 3:
            return
    raise AssertionError(f"too few grids show it: {seen}")


def test_the_nearest_of_several_goals_can_be_taken_and_a_free_way_is_straight() -> None:
    arm = some_arm("ur5e")
    space = JointSpace(arm, chain_world(arm, ObstacleSet(()), -1e3), 0.0)
    start = np.array([0.0, -1.2, 1.0, 0.3, 0.2, 0.0])
    goals = start + np.array([[0.4, 0, 0, 0, 0, 0], [0.1, 0, 0, 0, 0, 0.1]])
    found = search_joints(space, start[None], goals)
    assert found.path is not None
    assert found.path[0] == pytest.approx(start)
    assert any(found.path[-1] == pytest.approx(goal) for goal in goals)
    assert found.length == pytest.approx(space.distance(found.path[[0, -1]]))


def test_shortening_stops_after_its_tries() -> None:
    arm = some_arm("ur5e")
    space = JointSpace(arm, chain_world(arm, ObstacleSet(()), -1e3), 0.0)
    start = np.array([0.0, -1.2, 1.0, 0.3, 0.2, 0.0])
    detour = start + np.array([0.0, 0.3, 0.1, 0.4])[:, None] * np.eye(6)[0]
    ways = list(shortened(space, detour, np.random.default_rng(0), 0))
    assert len(ways) == 1
    assert len([*shortened(space, detour, np.random.default_rng(0), 1)][-1]) == 2


def test_a_search_that_is_not_wanted_any_more_ends() -> None:
    task_arm = some_arm("ur5e")
    space = JointSpace(task_arm, chain_world(task_arm, ObstacleSet(()), -1e3), 0.0)
    pose = np.array([[0.0, -1.2, 1.0, 0.3, 0.2, 0.0]])
    with pytest.raises(CancelledError), watched_by(lambda: True):
        search_joints(space, pose, pose + 0.5)


def test_wrong_ends_are_named() -> None:
    arm = some_arm("ur5e")
    space = JointSpace(arm, chain_world(arm, ObstacleSet(()), -1e3), 0.0)
    pose = np.zeros((1, 6))
    with pytest.raises(ArgumentError, match="number of goals"):
        search_joints(space, pose, pose[:0])
    with pytest.raises(ArgumentError, match="starts"):
        search_joints(space, pose + 100, pose)
    with pytest.raises(ArgumentError, match="samples"):
        JointSearchEffort(samples=0)

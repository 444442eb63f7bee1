"""Proofs of the arm, against dense samples measured in another way."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from abi.arm_planning.motion.arm_clearance import ArmClearance, arm_clearance
from abi.arm_planning.motion.trajectory import ArmMotion, follow
from abi.arm_planning.paper_arm_model import paper_arm
from abi.arm_planning.world.arm_worlds import paper_arm_world
from abi.arm_planning.world.paper_arm_distance_kernels import (
    capsule_clearances,
    capsules_near_meshes,
)
from abi.arrays import FloatArray, flat, read_only
from abi.curves.bspline import clamped
from abi.curves.curve import arc_length
from abi.curves.three_phase_profile import three_phase
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacles, ObstacleSet
from abi.obstacles.primitives import Box, Sphere
from abi.obstacles.triangle_mesh.repair import clean
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.scene.arm_settings import ArmSettings
from tests.abi import meshes
from tests.random_geometry import random_obstacle
from tests.random_scenes import mesh_source

SEED = st.integers(0, 2**32 - 1)


@dataclass(frozen=True, eq=False)
class Case:
    """An arm on its way, and what is around."""

    arm: PaperArm
    motion: ArmMotion
    obstacles: ObstacleSet
    clearance: ArmClearance

    @property
    def distances(self) -> FloatArray:
        """Densely sampled distances (m, c, k) of the capsules to each obstacle, at finer times."""
        ends = self.arm.place(self.motion.positions)
        shares = np.linspace(0, 1, 25)[:, None, None, None]
        points = ends[:, :, 0] + shares * (ends[:, :, 1] - ends[:, :, 0])
        radii = np.array([capsule.radius for capsule in self.arm.capsules])
        away = [
            one.signed_distance(points.reshape(-1, 3)).reshape(points.shape[:3]).min(axis=0) - radii
            for one in self.obstacles
        ]
        return np.stack(away, axis=2)


def case(settings: ArmSettings, points: FloatArray, obstacles: Obstacles, samples: int) -> Case:
    arm, curve = paper_arm(settings), clamped(points, min(3, len(points) - 1))
    arc = arc_length(curve)
    profile = three_phase(arc.length, 4.0, 6.0, 6.0)
    motion = follow(curve, arc, profile, arm, settings, samples)
    solids = ObstacleSet(obstacles)
    collision_world = paper_arm_world(arm, solids, 0.0)
    return Case(arm, motion, solids, arm_clearance(motion, arm, collision_world, 0.0))


def case_of(other: Case, obstacles: Obstacles) -> Case:
    """The motion of another case among other obstacles."""
    solids = ObstacleSet(obstacles)
    collision_world = paper_arm_world(other.arm, solids, 0.0)
    clearance = arm_clearance(other.motion, other.arm, collision_world, 0.0)
    return Case(other.arm, other.motion, solids, clearance)


def random_case(seed: int, samples: int = 301) -> Case:
    """An arm beside or under the workspace; the slide moves in half of the cases."""
    random = np.random.default_rng(seed)
    obstacles = [random_obstacle(random) for _ in range(int(random.integers(0, 5)))]
    if random.random() < 0.3:
        size = float(random.uniform(0.2, 1.2))
        place_ = tuple(random.uniform(1, 6, 3).tolist())
        obstacles.append(MeshShape.of(clean(*meshes.box((size, 0.8, 1.3 - size))), position=place_))
    base = (float(random.uniform(1, 5)), float(random.uniform(-4, -1)), 0.0)
    force = float(random.choice([0.0, 0.3, -0.2]))
    settings = ArmSettings(
        base=base if random.random() < 0.7 else (3.0, 3.0, -6.0),
        elbow="up" if random.random() < 0.7 else "down",
        forces=(0.1, force, 0.2),
        q5=0.5,
    )
    points = random.uniform((0.5, 0.5, 1.5), 5.5, (int(random.integers(2, 7)), 3))
    return case(settings, points, tuple(obstacles), samples)


@pytest.mark.slow
@settings(max_examples=8)
@given(SEED)
def test_nothing_proven_is_refuted_by_dense_samples(seed: int) -> None:
    found = random_case(seed)
    clearance = found.clearance
    assert clearance.certified == (clearance.certificate is not None)
    assume(clearance.certificate is not None)
    assert not clearance.contacts
    if len(found.obstacles):
        assert found.distances.min() > clearance.distance - 1e-9
    ends = found.arm.place(found.motion.positions)
    column = found.arm.base + np.array([0.0, 0.0, 1.0]) * np.linspace(0, 3, 40)[:, None]
    for c, capsule in enumerate(found.arm.capsules):
        if capsule.body == 0:
            continue
        if not capsule.grips:
            assert ends[:, c, :, 2].min() - capsule.radius > min(found.arm.base[2], 0.0)
        if not capsule.neighbour:  # the column is at least as thick as its turret
            inner = ends[:, c, 0, None] - column[None, 20:37]
            assert np.linalg.norm(inner, axis=2).min() > capsule.radius + 1.0


@pytest.mark.slow
@settings(max_examples=16)
@given(SEED)
def test_contacts_and_the_least_distance_are_those_of_dense_samples(seed: int) -> None:
    found = random_case(seed, 61)
    if not len(found.obstacles):
        assert found.clearance.distance == math.inf
        return
    distances = found.distances
    least = found.clearance.distances.min()
    assert distances.min() >= least - 1e-9
    if least > 0:  # within a mesh there is only a bound
        assert distances.min() == pytest.approx(least, abs=0.03)
    touching = {
        (found.arm.capsules[c].link, k)
        for c, k in zip(*np.nonzero((distances < -0.01).any(axis=0)), strict=True)
    }
    said = {link for link, _ in touching} - {one.link for one in found.clearance.contacts}
    assert not said
    for one in found.clearance.contacts:
        assert one.first <= one.time <= one.last
        assert one.link in found.clearance.touching(one.time)


@pytest.mark.slow
@settings(max_examples=8)
@given(SEED)
@example(89878596)  # deep in one mesh beside another
def test_of_many_meshes_the_nearest_and_all_that_touch_are_found(seed: int) -> None:
    random = np.random.default_rng(seed)
    ball = clean(*meshes.sphere(1))
    crowd = tuple(
        MeshShape.of(
            ball,
            position=tuple(random.uniform(-2, 8, 3).tolist()),
            scale=float(random.uniform(0.05, 0.4)),
        )
        for _ in range(30)
    )
    alone = random_case(seed, 61)
    found = case_of(alone, crowd)
    each = [case_of(alone, (one,)) for one in crowd]
    least = [one.clearance.distances.min() for one in each]
    assert found.clearance.distances.min() == pytest.approx(min(least), abs=1e-9)
    touched = {one.obstacle for one in found.clearance.contacts if isinstance(one.obstacle, int)}
    # of two that one capsule is in at once the deeper one is told
    assert touched <= {number for number, away in enumerate(least) if away <= 0}
    assert bool(touched) == (min(least) <= 0)


def test_a_link_in_an_obstacle_is_named_with_its_time_and_depth() -> None:
    points = np.array([[1.0, 1.0, 3.0], [5.0, 1.0, 3.0]])
    free = case(ArmSettings(), points, (), 101)
    assert free.clearance.certified
    assert free.clearance.obstacle == -1
    # in the forearm at the middle of the motion
    ends = free.arm.place(free.motion.positions[[50]])[0]
    c = next(k for k, one in enumerate(free.arm.capsules) if one.link == "forearm")
    x, y, z = ends[c].mean(axis=0).tolist()
    ball = Sphere(radius=0.05, position=(x, y, z))

    found = case(ArmSettings(), points, (ball,), 101).clearance

    assert found.certificate is None
    assert not found.certified
    worst = found.contacts[0]
    assert (worst.link, worst.obstacle) == ("forearm", 0)
    assert worst.time == pytest.approx(free.motion.time[50], abs=0.05)
    assert worst.depth == pytest.approx(free.arm.capsules[c].radius + 0.05, abs=0.02)
    assert "forearm" in found.touching(worst.time)
    assert not found.touching(0.0)


def test_the_arm_may_not_enter_the_floor_or_its_column() -> None:
    low = case(ArmSettings(elbow="down"), np.array([[1.0, 0.0, 0.1], [5.0, 0.0, 0.1]]), (), 60)
    assert "floor" in {one.obstacle for one in low.clearance.contacts}
    near = ArmSettings(base=(3.0, 0.0, 0.0), a3=3, a4=1.5, a5=1.2)
    through = case(near, np.array([[3.2, 0.1, 1.2], [3.3, 0.6, 1.2]]), (), 60)
    assert {"turret", "base_link"} & {one.obstacle for one in through.clearance.contacts}
    assert through.clearance.certificate is None


def test_a_box_on_the_column_is_seen() -> None:
    box = Box(size=(0.5, 0.5, 0.5), position=(3.0, -3.0, 1.0))
    found = case(ArmSettings(), np.array([[1.0, 1.0, 3.0], [5.0, 1.0, 3.0]]), (box,), 31)
    links = {one.link for one in found.clearance.contacts}
    assert {"base_link", "turret"} & links


@given(SEED)
@settings(max_examples=20)
def test_a_capsule_left_unmeasured_is_neither_the_nearest_nor_touching(seed: int) -> None:
    random = np.random.default_rng(seed)
    obstacles = ObstacleSet(tuple(random_obstacle(random) for _ in range(3)))
    arm, far = paper_arm(ArmSettings(base=(3.0, -3.0, 0.0))), np.inf
    collision_world = paper_arm_world(arm, obstacles, 0.0)
    positions = np.zeros((60, 6))
    first, last = random.uniform(-1.5, 1.5, (2, 3))
    positions[:, :3] = np.linspace(first, last, 60)
    ends, rows = arm.place(positions), collision_world.beyond(0.0)
    count = len(arm.capsules)
    together, one_by_one = np.empty((60, count)), np.empty((60, count))
    rows_of = np.empty(count, dtype=np.int32)
    capsule_clearances(
        *(flat(ends), arm.capsule_rows, rows, far, together.ravel()),
        np.empty(60 * count, dtype=np.int32),
    )
    for pose, distances in zip(ends, one_by_one, strict=True):
        for capsule in range(count):  # each alone, so that none is left out for another
            alone = np.zeros((count, len(rows.margins)), dtype=np.bool_)
            alone[capsule] = collision_world.asked[capsule]
            of_one = np.empty(count)
            capsule_clearances(
                *(flat(pose), arm.capsule_rows, rows._replace(asked=read_only(alone.ravel()))),
                *(far, of_one, rows_of),
            )
            distances[capsule] = of_one[capsule]
    measured = np.isfinite(together)
    assert np.allclose(together[measured], one_by_one[measured], rtol=0, atol=1e-12)
    assert np.allclose(together.min(axis=1), one_by_one.min(axis=1), rtol=0, atol=1e-12)
    assert measured[one_by_one <= 0].all()


@given(SEED)
@settings(max_examples=20)
def test_the_nearest_capsule_and_those_that_touch_a_mesh_are_measured(seed: int) -> None:
    random = np.random.default_rng(seed)
    source = mesh_source()
    obstacles = ObstacleSet(
        tuple(
            MeshShape.model_validate(
                {"file": name, "scale": 0.5, "position": tuple(random.uniform(0, 4, 3).tolist())},
                context={"meshes": source},
            )
            for name in random.choice(list(source.files), 5)
        )
    )
    arm = paper_arm(ArmSettings(base=(3.0, -3.0, 0.0)))
    positions = np.zeros((40, 6))
    first, last = random.uniform(-1.5, 1.5, (2, 3))
    positions[:, :3] = np.linspace(first, last, 40)
    ends = arm.place(positions)
    count = ends.shape[0] * ends.shape[1]
    found, nearest = np.full(count, np.inf), np.empty(count, dtype=np.int32)
    capsules_near_meshes(flat(ends), arm.capsule_rows, obstacles.surfaces, found, nearest)

    radii = np.tile([one.radius for one in arm.capsules], 40)
    segments = ends[:, :, 0].reshape(-1, 3), ends[:, :, 1].reshape(-1, 3)
    away = np.stack([one.segment_distance(*segments) - radii for one in obstacles.meshes])
    outside = np.isfinite(found) & (found > 0)
    assert np.allclose(found[outside], away.min(axis=0)[outside], rtol=0, atol=1e-9)
    assert (found[away.min(axis=0) <= -1e-9] <= 0).all()
    if away.min() > 0:
        assert found.min() == pytest.approx(away.min(), abs=1e-9)
    picked = np.flatnonzero(outside)
    assert np.allclose(away[nearest[picked], picked], found[picked], rtol=0, atol=1e-9)


@given(SEED)
@settings(max_examples=10)
def test_what_is_told_of_a_contact_with_a_mesh_is_the_deepest_of_all_its_poses(seed: int) -> None:
    random = np.random.default_rng(seed)
    shapes = [
        MeshShape.of(clean(*mesh), position=tuple(random.uniform(0, 4, 3).tolist()))
        for mesh in (meshes.room(5), meshes.sphere(2), meshes.knot(500), meshes.soup(50))
    ]
    obstacles = ObstacleSet(tuple(shapes[: random.integers(1, 5)]))
    arm = paper_arm(ArmSettings(base=(3.0, -1.0, 0.0)))
    positions = np.zeros((60, 6))
    first, last = random.uniform(-1.5, 1.5, (2, 3))
    positions[:, :3] = np.linspace(first, last, 60)
    ends, moving = arm.place(positions), len(arm.capsules)
    beside = np.where(random.random((60, moving)) < 0.05, random.uniform(-0.2, 0), np.inf)
    found, nearest = beside.copy(), np.empty((60, moving), dtype=np.int32)
    capsules_near_meshes(
        flat(ends), arm.capsule_rows, obstacles.surfaces, found.ravel(), nearest.ravel()
    )

    p, q = ends[:, :, 0].reshape(-1, 3), ends[:, :, 1].reshape(-1, 3)
    radii = np.array([one.radius for one in arm.capsules])
    each = [one.segment_distance(p, q).reshape(-1, moving) - radii for one in obstacles.meshes]
    away = np.stack([beside, *each])
    whose, least = away.argmin(axis=0) - 1, away.min(axis=0)
    assert np.array_equal(found <= 0, least <= 0)
    assert np.array_equal(nearest[least <= 0], whose[least <= 0])
    for c in range(moving):
        changes = np.flatnonzero(np.diff(np.where(least[:, c] <= 0, whose[:, c], -2)))
        for pose in np.split(np.arange(60), changes + 1):
            if least[pose[0], c] <= 0:
                assert found[pose, c].min() == pytest.approx(least[pose, c].min(), abs=1e-9)
                assert (found[pose, c] >= least[pose, c] - 1e-9).all()

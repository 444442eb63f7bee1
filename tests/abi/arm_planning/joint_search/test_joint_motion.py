"""Motions of the joints: with as many samples as the proof between them takes."""

from __future__ import annotations

import numpy as np

from abi.arm_planning.certificates.chain_certificate import chain_refutation
from abi.arm_planning.joint_search.joint_motion import passage_of, proven_motion, slow_rates
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.joint_search.joint_spline import joint_spline, spline_near
from abi.arm_planning.joint_search.search_joints import JointSearchEffort, search_joints
from abi.arm_planning.motion_law import motion_law
from abi.arm_planning.world.arm_worlds import chain_world
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitives import Sphere
from abi.scene.settings import MotionSettings
from tests.abi.arm_planning.test_chain_certificate import some_arm

LAW = MotionSettings(speed=0.5, acceleration=1.0, deceleration=1.0, law="three_phase")
FEW = JointSearchEffort(samples=400, nodes=400, shortcuts=20)
SAMPLES = 5


def test_a_motion_whose_samples_are_too_far_apart_to_be_proven_gets_more() -> None:
    arm, taken = some_arm("ur5e"), set()
    low, high = arm.chain.usual_range().T * arm.scales
    for seed in range(12):
        ends = np.random.default_rng(seed).uniform(low, high, (2, len(low)))
        x, y, z = arm.tool(ends.mean(axis=0)[None])[0].tolist()
        obstacles = ObstacleSet((Sphere(radius=0.15 * arm.reach, position=(x, y, z)),))
        around = chain_world(arm, obstacles, -1e3)
        space = JointSpace(arm, around, 0.0)
        if not all(space.clear(np.stack([pose, pose])) for pose in ends):
            continue
        found = search_joints(space, ends[:1], ends[1:], FEW)
        spline = None if found.path is None else spline_near(space, found.path)
        if spline is None:
            continue
        passage = passage_of(spline, arm)
        profile = motion_law(passage, LAW)
        motion, clearance = proven_motion(passage, profile, SAMPLES, around, 0.0)
        refuted = chain_refutation(arm, motion.positions, around, 0.0) is not None
        assert clearance.certified != refuted
        times = (len(motion.time) - 1) / (SAMPLES - 1)
        for fewer in (1, 2):
            if fewer < times:
                before = passage.motion(profile, fewer * (SAMPLES - 1) + 1).positions
                assert chain_refutation(arm, before, around, 0.0) is not None
        taken.add(times)
        print(seed, times, refuted)
    assert {1.0} < taken <= {1.0, 2.0, 4.0}


def test_a_slow_part_takes_more_of_the_way_and_is_passed_by_the_same_joints() -> None:
    arm = some_arm("ur5e")
    spline = joint_spline(np.random.default_rng(3).uniform(-1, 1, (7, 6)))
    whole = passage_of(spline, arm)
    slow = (0.3, 0.6), 4.0
    rates = slow_rates(np.linspace(0, 1, 1001), *slow)
    assert (rates[[0, 299, 601, 1000]] == 1).all()
    assert rates.max() == 4
    assert np.abs(np.diff(rates)).max() < 0.07  # no jumps
    assert (slow_rates(np.zeros(1), (0.0, 0.5), 4.0) == 4).all()
    slower = passage_of(spline, arm, *slow)
    assert slower.length > whole.length
    # far from the part nothing has changed but the length of the whole
    before = np.linspace(0, 0.1 * whole.length, 50)
    assert np.abs(slower.at(before) - whole.at(before)).max() < 1e-3
    ends = np.array([0.0, slower.length])
    assert np.abs(slower.at(ends) - whole.at(np.array([0.0, whole.length]))).max() < 1e-9

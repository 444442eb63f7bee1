"""What is remembered of an arm along its ways, against asking anew each time."""

from __future__ import annotations

from functools import partial

import numpy as np

from abi.arm_planning.branch.followed import Followed
from abi.arm_planning.branch.segment_memory import SegmentMemory
from abi.arm_planning.certificates.chain_certificate import chain_refutation
from abi.arm_planning.world.arm_worlds import chain_world
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.curves.clearance.certificate import Refutation
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitives import Box
from tests.abi.arm_planning.test_chain_certificate import joint_path, some_arm

MARGIN = 0.01


class Asked:
    """Answers about an arm, and how often and how they were asked for."""

    def __init__(self) -> None:
        self.arm = some_arm("sliding")
        self.whole = self.parts = 0

    def refutation(
        self, followed: Followed, around: CollisionWorld, with_itself: bool
    ) -> Refutation | None:
        self.whole += with_itself
        self.parts += not with_itself
        return chain_refutation(self.arm, followed.joints, around, MARGIN, with_itself=with_itself)


def some_box(random: np.random.Generator) -> Box:
    x, y, z = (np.array([1.0, 2.0, 3.4]) + random.uniform(-1.2, 1.2, 3)).tolist()
    return Box(size=(0.2, 0.3, 0.2), position=(x, y, z))


def test_what_is_remembered_is_what_asking_anew_tells() -> None:
    asked, random, memory = Asked(), np.random.default_rng(0), SegmentMemory()
    nothing = np.zeros(7)
    ways = [Followed(nothing, joint_path(asked.arm, random, 0.1), nothing) for _ in range(12)]
    shapes, seen, answers = [some_box(random) for _ in range(4)], set(), 0
    for step in range(40):
        if step % 4:  # every fourth time nothing has moved
            shapes[int(random.integers(len(shapes)))] = some_box(random)
        obstacles = ObstacleSet(tuple(shapes[: len(shapes) - (step // 8) % 2]))
        floor = 2.6 if step // 6 == 3 else -10.0  # of another one nothing is known
        around = chain_world(asked.arm, obstacles, floor)
        memory.enter(around)
        for number, way in enumerate(ways):
            expected = chain_refutation(asked.arm, way.joints, around, MARGIN)
            follow = partial(ways.__getitem__, number)
            _, found = memory.examined((number,), follow, asked.refutation)
            answers += 1
            assert (found is None) == (expected is None)
            seen.add(None if found is None else found.obstacle >= 0)
            if found is not None and found.obstacle >= 0:
                alone = around.only(around.numbers == found.obstacle)
                assert chain_refutation(asked.arm, way.joints, alone, MARGIN) is not None
    assert {None, True} <= seen
    assert asked.parts > 0
    assert asked.whole + asked.parts < 0.8 * answers

"""Proofs of which parts are remembered, against proofs made anew each time."""

from __future__ import annotations

import numpy as np

from abi.arm_planning.certificates.chain_certificate import certify_chain
from abi.arm_planning.motion.proof_memory import ProofMemory
from abi.arm_planning.world.arm_worlds import chain_world
from abi.arrays import FloatArray
from abi.curves.clearance.certificate import Certificate
from abi.obstacles.obstacle_set import ObstacleSet
from tests.abi.arm_planning.test_chain_certificate import joint_path, some_arm
from tests.abi.arm_planning.test_segment_memory import some_box


def rows(proof: Certificate) -> FloatArray:
    """What a proof says, a row for each direction, in an order of its own."""
    assert proof.closer is not None
    columns = proof.obstacle, proof.capsule, proof.poses, proof.closer
    table = np.column_stack([*columns, proof.pieces, proof.directions])
    return table[np.lexsort(table.T[:6])]


def test_a_proof_of_which_parts_are_remembered_is_the_one_made_anew() -> None:
    arm, random = some_arm("sliding"), np.random.default_rng(1)
    memory, shapes = ProofMemory(arm), [some_box(random) for _ in range(4)]
    positions, margin, proven, refuted = joint_path(arm, random, 0.1), 0.01, 0, 0
    for step in range(60):
        if step % 12 == 11:
            positions, margin = joint_path(arm, random, 0.1), 0.2 * (step % 4)
        if step % 4:  # every fourth time nothing has moved
            shapes[int(random.integers(len(shapes)))] = some_box(random)
        obstacles = ObstacleSet(tuple(shapes[: len(shapes) - (step // 8) % 5]))
        floor = 3.0 if step // 3 % 4 == 3 else -10.0  # of another one nothing is known
        around = chain_world(arm, obstacles, floor)
        asked = margin if step % 5 else margin / 2
        expected = certify_chain(arm, positions, around, asked)
        found = memory.certify(positions, around, asked)
        assert type(found) is type(expected)
        if isinstance(found, Certificate) and isinstance(expected, Certificate):
            proven += 1
            assert found.margin == expected.margin
            np.testing.assert_allclose(rows(found), rows(expected), atol=1e-12)
        else:
            refuted += 1
    assert proven >= 15
    assert refuted >= 3

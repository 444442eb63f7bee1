"""Poses, Jacobians and torques against those that Pinocchio gave (see ``pinocchio_answers``)."""

from __future__ import annotations

import numpy as np
import pytest

from tests.abi.robot.pinocchio_answers import BOUND, RECORD, TIPS, Answers, chain_of, differences


def recorded(name: str) -> Answers:
    with np.load(RECORD) as arrays:
        assert str(arrays["pinocchio"]) == "4.1.0", "name the version that was asked"
        return Answers.of(arrays, name)


@pytest.mark.parametrize("name", TIPS)
def test_every_answer_is_pinocchios(name: str) -> None:
    chain, answers = chain_of(name), recorded(name)
    assert answers.places.shape == (len(answers.positions), len(chain.robot.links), 7)
    assert max(differences(chain, answers).values()) < BOUND


@pytest.mark.parametrize(
    ("field", "key"), [("places", "pose"), ("jacobians", "jacobian"), ("torques", "torque")]
)
def test_a_wrong_answer_is_noticed(field: str, key: str) -> None:
    answers = recorded("panda")
    wrong = getattr(answers, field).copy()
    wrong[7].flat[0] += 1e-6 * np.abs(wrong).max()
    found = differences(chain_of("panda"), answers._replace(**{field: wrong}))
    assert [name for name, by in found.items() if by > BOUND] == [key]

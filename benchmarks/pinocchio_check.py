"""Poses, Jacobians and torques of the arms beside those of Pinocchio.

    python -m benchmarks.pinocchio_check

At random positions, speeds and accelerations within the limits; the largest differences, of torques
as a part of the largest torque. Above 1e-9 the run fails. ``--record`` keeps Pinocchio's answers at
a few of the positions for the tests, which do without it.
"""

from __future__ import annotations

import argparse

import numpy as np
import pinocchio

from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.inverse_dynamics import GRAVITY
from benchmarks.report import Row, table
from tests.abi.robot.pinocchio_answers import (
    BOUND,
    RECORD,
    TIPS,
    Answers,
    chain_of,
    differences,
    path_of,
)

_STATES = 200
_RECORDED = 40


def measure(states: int, seed: int = 0) -> list[Row]:
    """A row for each arm.

    Raises:
        AssertionError: something differs by more than the bound.
    """
    rows = []
    for name in TIPS:
        found = differences(chain_of(name), ask(name, states, seed))
        rows.append({"arm": name, "states": states, **found})
        assert max(found.values()) < BOUND, rows[-1]
    return rows


def ask(name: str, states: int, seed: int) -> Answers:
    """Pinocchio's answers for an arm at random states."""
    chain = chain_of(name)
    model = _model(name, chain)
    data, tip = model.createData(), model.getFrameId(TIPS[name])
    links = [model.getFrameId(link, pinocchio.FrameType.BODY) for link in chain.frames]
    random = np.random.default_rng(seed)
    low, high = chain.limits.T
    positions = random.uniform(low, high, (states, len(low)))
    speeds, growth = random.normal(size=(2, states, len(low)))
    places, jacobians, torques = [], [], []
    for q, v, a in zip(positions, speeds, growth, strict=True):
        torques.append(pinocchio.rnea(model, data, q, v, a).copy())
        jacobians.append(
            pinocchio.computeFrameJacobian(model, data, q, tip, pinocchio.LOCAL_WORLD_ALIGNED)
        )
        pinocchio.framesForwardKinematics(model, data, q)
        xyzquat = np.stack([pinocchio.SE3ToXYZQUAT(data.oMf[link]) for link in links])
        places.append(xyzquat[:, [0, 1, 2, 6, 3, 4, 5]])
    return Answers(
        positions, speeds, growth, np.stack(places), np.stack(jacobians), np.stack(torques)
    )


def _model(name: str, chain: Chain) -> pinocchio.Model:
    """Pinocchio's model of the same joints, the others, such as fingers, at rest."""
    model = pinocchio.buildModelFromUrdf(str(path_of(name)))
    others = [
        number for number in range(1, model.njoints) if model.names[number] not in chain.names
    ]
    reduced = pinocchio.buildReducedModel(model, others, pinocchio.neutral(model))
    assert tuple(reduced.names)[1:] == chain.names
    reduced.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
    return reduced


def record() -> None:
    """Write Pinocchio's answers for the tests, with its version."""
    arrays = {
        f"{name} {field}": values
        for name in TIPS
        for field, values in ask(name, _RECORDED, seed=1)._asdict().items()
    }
    np.savez_compressed(RECORD, pinocchio=np.array(pinocchio.__version__), **arrays)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--states", type=int, default=_STATES)
    parser.add_argument("--record", action="store_true", help="write the record of the tests")
    options = parser.parse_args()
    if options.record:
        record()
    print(table(measure(options.states)))


if __name__ == "__main__":
    main()

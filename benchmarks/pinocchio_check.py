"""Poses, Jacobians and torques of the shipped arms beside those of Pinocchio.

    python -m benchmarks.pinocchio_check

At random positions, speeds and accelerations within the limits; the largest differences, of torques
as a part of the largest torque. Above 1e-9 the run fails.
"""

from __future__ import annotations

import argparse

import numpy as np
import pinocchio

from abi import assets
from abi.arm.chain import Chain
from abi.arm.chain_kernels import fill_jacobian
from abi.arm.inverse_dynamics import GRAVITY, joint_torques
from abi.arrays import FloatArray
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.robot_files import SHIPPED, load_robot
from benchmarks.report import Row, table

BOUND = 1e-9
_STATES = 200


def measure(states: int, seed: int = 0) -> list[Row]:
    """A row for each shipped arm.

    Raises:
        AssertionError: something differs by more than :data:`BOUND`.
    """
    rows = [_compare(name, states, seed) for name in SHIPPED]
    for row in rows:
        assert max(row[key] for key in ("pose", "jacobian", "torque")) < BOUND, row
    return rows


def _compare(name: str, states: int, seed: int) -> Row:
    chain = Chain.of(load_robot(name, MeshSource()), SHIPPED[name])
    model = _model(name, chain)
    data, tip = model.createData(), model.getFrameId(SHIPPED[name])
    random = np.random.default_rng(seed)
    count = len(chain.names)
    low, high = chain.limits.T
    positions = random.uniform(low, high, (states, count))
    speeds, growth = random.normal(size=(2, states, count))
    torques = joint_torques(chain, positions, speeds, growth)
    poses = chain.poses(positions)
    pose = jacobian = torque = 0.0
    for k in range(states):
        wanted = pinocchio.rnea(model, data, positions[k], speeds[k], growth[k])
        torque = max(torque, float(np.abs(torques[k] - wanted).max() / np.abs(wanted).max()))
        rows = pinocchio.computeFrameJacobian(
            model, data, positions[k], tip, pinocchio.LOCAL_WORLD_ALIGNED
        )
        axis = poses[k, -1, :, 2]
        rows[3:] -= np.outer(axis, axis @ rows[3:])  # about itself it may turn
        jacobian = max(jacobian, float(np.abs(_jacobian(chain, poses[k]) - rows).max()))
        pinocchio.framesForwardKinematics(model, data, positions[k])
        frame = data.oMf[tip].homogeneous[:3]
        pose = max(pose, float(np.abs(poses[k, -1] - frame).max()))
    return {"arm": name, "states": states, "pose": pose, "jacobian": jacobian, "torque": torque}


def _model(name: str, chain: Chain) -> pinocchio.Model:
    """Pinocchio's model of the same joints, the others, such as fingers, at rest."""
    model = pinocchio.buildModelFromUrdf(str(assets.path("urdf", name, f"{name}.urdf")))
    others = [
        number for number in range(1, model.njoints) if model.names[number] not in chain.names
    ]
    reduced = pinocchio.buildReducedModel(model, others, pinocchio.neutral(model))
    assert tuple(reduced.names)[1:] == chain.names
    reduced.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
    return reduced


def _jacobian(chain: Chain, poses: FloatArray) -> FloatArray:
    """Derivatives of the tip's place and of its z axis's turn by the coordinates, (6, n)."""
    count = len(chain.names)
    flat = np.concatenate([np.append(pose[:, :3].ravel(), pose[:, 3]) for pose in poses])
    filled = np.empty(6 * count)
    fill_jacobian(chain.table, flat, 6, count, filled)
    rows = filled.reshape(6, count)
    rows[:3] *= chain.table.reach
    return rows


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--states", type=int, default=_STATES)
    options = parser.parse_args()
    print(table(measure(options.states)))


if __name__ == "__main__":
    main()

"""Pinocchio's poses, Jacobians and torques of arms, as recorded, and ours beside them.

``python -m benchmarks.pinocchio_check --record`` writes the record.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np

from abi import assets
from abi.arrays import FloatArray
from abi.obstacles.pose import rotation
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.chain_kernels import fill_jacobian
from abi.robot.kinematics.inverse_dynamics import joint_torques
from abi.robot.urdf.robot_files import SHIPPED, load_robot

RECORD = Path(__file__).parent / "pinocchio.npz"
BOUND = 1e-9
TIPS = {**SHIPPED, "abi": "tool"}
"""Tip of each arm; ``abi`` is the paper's as URDF."""


class Answers(NamedTuple):
    """Pinocchio's answers on an arm at k positions of its n joints; lengths in [m].

    Attributes:
        positions, speeds, accelerations: of the joints, (k, n).
        places: position and quaternion wxyz of every link, (k, links, 7), world.
        jacobians: of the tip's position and turn, along the world's axes, (k, 6, n).
        torques: of the joints, (k, n).
    """

    positions: FloatArray
    speeds: FloatArray
    accelerations: FloatArray
    places: FloatArray
    jacobians: FloatArray
    torques: FloatArray

    @classmethod
    def of(cls, arrays: Mapping[str, FloatArray], name: str) -> Self:
        """Those of one arm among the arrays of a record."""
        return cls(*(arrays[f"{name} {field}"] for field in cls._fields))


def chain_of(name: str) -> Chain:
    """The chain of an arm, standing at the origin."""
    file = name if name in SHIPPED else f"{name}.urdf"
    return Chain.of(load_robot(file, MeshSource(folder=assets.path("urdf"))), TIPS[name])


def path_of(name: str) -> Path:
    """The URDF of an arm."""
    return assets.path("urdf", *([name] if name in SHIPPED else []), f"{name}.urdf")


def differences(chain: Chain, answers: Answers) -> dict[str, float]:
    """Largest differences of poses, Jacobians and torques, the latter over the largest torque."""
    poses = chain.poses(answers.positions)
    torques = joint_torques(chain, *answers[:3])
    jacobians = np.stack([_jacobian(chain, one) for one in poses])
    wanted = answers.jacobians.copy()
    axes = poses[:, -1, :, 2]  # the tip may turn about its own axis
    wanted[:, 3:] -= axes[:, :, None] * np.einsum("ki,kij->kj", axes, wanted[:, 3:])[:, None]
    return {
        "pose": float(np.abs(_links(chain, poses) - _matrices(answers.places)).max()),
        "jacobian": float(np.abs(jacobians - wanted).max()),
        "torque": float(np.abs(torques - answers.torques).max() / np.abs(answers.torques).max()),
    }


def _links(chain: Chain, poses: FloatArray) -> FloatArray:
    """Poses (k, links, 3, 4) of the links, in the order in which the chain carries them."""
    found = []
    for link, frame in chain.frames.items():
        pose = chain.places[link][:3]
        if frame < 0:
            found.append(np.broadcast_to(pose, (len(poses), 3, 4)))
        else:
            turn, place = poses[:, frame, :, :3], poses[:, frame, :, 3:]
            found.append(turn @ pose + place * np.array([0.0, 0.0, 0.0, 1.0]))
    return np.stack(found, axis=1)


def _matrices(places: FloatArray) -> FloatArray:
    """Poses (k, links, 3, 4) of positions and quaternions (k, links, 7)."""
    flat = places.reshape(-1, 7)
    turns = np.stack([rotation(tuple(wxyz)) for wxyz in flat[:, 3:].tolist()])
    return np.concatenate([turns, flat[:, :3, None]], axis=2).reshape(*places.shape[:2], 3, 4)


def _jacobian(chain: Chain, poses: FloatArray) -> FloatArray:
    """Derivatives of the tip's place and of its z axis's turn by the coordinates, (6, n)."""
    count = len(chain.names)
    flat = np.concatenate([np.append(pose[:, :3].ravel(), pose[:, 3]) for pose in poses])
    filled = np.empty(6 * count)
    fill_jacobian(chain.table, flat, 6, count, filled)
    rows = filled.reshape(6, count)
    rows[:3] *= chain.table.reach
    return rows

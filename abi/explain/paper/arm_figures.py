"""The paper's statements on the arm, stage 6, beside our figures."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from abi.arm_planning.paper_arm_model import paper_arm
from abi.arm_planning.wrist_drives import wrist_positions
from abi.arrays import FloatArray
from abi.explain.paper import printed
from abi.explain.paper.comparison import PaperComparison
from abi.robot.paper_arm.inverse_kinematics import solve
from abi.robot.paper_arm.paper_arm import PaperArm, forward
from abi.scene.scene import Scene

_POSES = 10_000


def of_kinematics(scene: Scene) -> Iterator[PaperComparison]:
    """Forward and inverse kinematics: the printed formulas in random poses, and ours."""
    section = "stage 6, arm"
    arm = paper_arm(scene.arm.model_copy(update={"base": (0.0, 0.0, 0.0)}))
    poses, tool = _facing_poses(arm)
    solved = np.zeros_like(poses)
    solved[:, :3], _ = solve(arm, tool, np.zeros(_POSES), "up", np.zeros_like(tool))
    error = float(np.abs(forward(arm, solved) - tool).max())
    r = arm.a3 * np.sin(poses[:, 1]) + (arm.a4 + arm.a5) * np.sin(poses[:, 1] + poses[:, 2])
    formulas = {
        "y = cos q1·r": (np.cos(poses[:, 0]) * r, tool[:, 1]),
        "y = −cos q1·r": (-np.cos(poses[:, 0]) * r, tool[:, 1]),
        "q1 by arccos": (printed.q1(tool), poses[:, 0]),
        "q1 = atan2(x, −y)": (np.arctan2(tool[:, 0], -tool[:, 1]), poses[:, 0]),
        "q2 with a3²·Pza": (printed.cos_q2(arm, tool, "printed"), np.cos(poses[:, 1])),
        "q2 with a3³·Pza": (printed.cos_q2(arm, tool, "corrected"), np.cos(poses[:, 1])),
    }
    shares = {name: _share(*sides) for name, sides in formulas.items()}
    for wrong, corrected in zip(list(shares)[::2], list(shares)[1::2], strict=True):
        yield PaperComparison(
            section,
            wrong,
            "the solution",
            f"right in {shares[wrong]:.0f} % of {_POSES:,} poses; {corrected}: "
            f"{shares[corrected]:.0f} %",
            "does not hold",
        )
    yield PaperComparison(
        section,
        "forward after inverse kinematics",
        "gives the tool tip's place back",
        f"within {error:.0e} in {_POSES:,} poses",
        "holds",
    )


def of_drives(scene: Scene) -> Iterator[PaperComparison]:
    """Motion of the wrist, q4, under a constant force."""
    still = scene.arm.model_copy(update={"forces": (1.0, 1.0, 1.0), "q5": 0.0})
    inertia = sum(mass * i**2 for mass, i in zip(still.masses, still.radii, strict=True))
    time = np.linspace(0, 1, 1001)
    forces = {}
    for dynamics in ("as_printed", "corrected"):
        q4 = wrist_positions(still.model_copy(update={"dynamics": dynamics}), time)[:, 0]
        forces[dynamics] = inertia * float(np.diff(q4, 2).mean()) / time[1] ** 2
    yield PaperComparison(
        "stage 6, drives",
        "q4 = t²·Q / I under the force Q",
        "the solution",
        f"it takes {forces['as_printed']:.3f} Q; t²·Q / (2·I) takes {forces['corrected']:.3f} Q",
        "does not hold",
    )


def _facing_poses(arm: PaperArm) -> tuple[FloatArray, FloatArray]:
    """Random poses (n, 6), [rad], with the tool in front of the arm, and its positions (n, 3)."""
    poses = np.zeros((_POSES, 6))
    rng = np.random.default_rng(0)
    poses[:, :3] = rng.uniform(-np.pi, np.pi, (_POSES, 3))
    r = arm.a3 * np.sin(poses[:, 1]) + (arm.a4 + arm.a5) * np.sin(poses[:, 1] + poses[:, 2])
    # the same tool position with the arm turned round
    poses[:, 0] = np.where(r < 0, np.angle(-np.exp(1j * poses[:, 0])), poses[:, 0])
    poses[:, 1:3] *= np.where(r < 0, -1, 1)[:, None]
    return poses, forward(arm, poses)


def _share(values: FloatArray, expected: FloatArray) -> float:
    """Percentage of poses in which one of the values (n,) or (k, n) is the expected one (n,)."""
    equal = np.abs(values - expected) < 1e-6
    return 100 * float(equal.reshape(-1, len(expected)).any(axis=0).mean())

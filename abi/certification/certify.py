"""``abi.certify``: the verdict on a motion given as arrays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from abi.certification.certify_motion import certify_motion
from abi.certification.clearance_proof import MOST_TRIES
from abi.certification.motion import Motion
from abi.certification.robot_scene import robot_scene
from abi.certification.verdict import MotionVerdict
from abi.errors import ArgumentError
from abi.scene.scene import Scene


def certify(
    robot: str | Path | None,
    joints: Sequence[str],
    times: ArrayLike | None,
    positions: ArrayLike,
    scene: Scene | None = None,
    *,
    velocities: ArrayLike | None = None,
    accelerations: ArrayLike | None = None,
    start: Mapping[str, float] | None = None,
    clearance: float = 0.0,
    acceleration: float | None = None,
    most_tries: int = MOST_TRIES,
) -> MotionVerdict:
    """Prove that a motion keeps a robot clear at all times, or find where it touches something.

    Between waypoints the joints move straight, by cubic polynomials where velocities are given, and
    by quintic ones where accelerations are given, too.

    Args:
        robot: a ``.urdf`` or ``.zip`` file, or a shipped arm's name; None for the scene's own.
        joints: names of the n joints.
        times: of the m waypoints, (m,), increasing, [s]; None if not known.
        positions: of the joints, shape (m, n), [rad], of sliding joints [m].
        scene: with the obstacles, and where the robot stands; None for the robot alone.
        velocities: shape (m, n), [rad/s] or [m/s]; None if not known.
        accelerations: shape (m, n), [rad/s²] or [m/s²]; None if not known.
        start: positions of joints in which the robot stands, [rad] or [m]; None if not known.
        clearance: distance to keep from obstacles, [unit].
        acceleration: largest of each joint, [rad/s²], of sliding ones [m/s²]; None for no limit.
        most_tries: pairs of bodies and obstacles to try at most.

    Raises:
        AbiError: the motion is wrong or none of the robot's; names row, joint and unit.
        SceneError: the robot cannot be read.
        ArgumentError: another argument is none of its kind.
    """
    if not isinstance(scene, Scene | None):
        raise ArgumentError("scene", scene, "a Scene, as abi.load_scene gives it, or None")
    if not isinstance(start, Mapping | None):
        raise ArgumentError("start", start, "positions by the names of joints, or None")
    if isinstance(joints, str) or not isinstance(joints, Iterable):
        raise ArgumentError("joints", joints, "the names of the joints")
    rows: Any = np.arange(len(np.atleast_1d(np.asarray(positions, dtype=object))))
    motion = Motion(
        joints=tuple(joints),
        times=rows if times is None else times,  # type: ignore[arg-type]
        positions=positions,  # type: ignore[arg-type]
        velocities=velocities,  # type: ignore[arg-type]
        accelerations=accelerations,  # type: ignore[arg-type]
        timed=times is not None,
    )
    place = robot_scene(robot, scene)
    return certify_motion(motion, place, start, clearance, acceleration, most_tries)

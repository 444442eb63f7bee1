"""Joint positions of the paper's arm along a curve, on one side of its elbow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from abi.arm_planning.certificates.paper_arm_certificate import certify_paper_arm, slide_bounds
from abi.arm_planning.exclusion import paper_arm_mask_kernels
from abi.arm_planning.motion import trajectory
from abi.arm_planning.motion.arm_clearance import ArmClearance, arm_clearance
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arm_planning.wrist_drives import wrist_positions
from abi.arrays import FloatArray, flat, read_only
from abi.curves.clearance.certificate import Refutation
from abi.curves.cubic_profile import CubicProfile, PathProfile
from abi.curves.curve import ArcLength, Curve
from abi.robot.paper_arm.inverse_kinematics import solve
from abi.robot.paper_arm.paper_arm import JOINT_SPEED, MOVED, PaperArm
from abi.scene.arm_settings import ArmSettings

_POSES_TO_REFUTE, _TRIES_TO_REFUTE = 49, 5_000


@dataclass(frozen=True)
class PaperArmJointPath:
    """Joint positions as a function of the distance along a curve, on one elbow branch."""

    curve: Curve
    arc: ArcLength
    arm: PaperArm
    settings: ArmSettings

    @property
    def length(self) -> float:
        """Arc length of the curve, [unit]."""
        return self.arc.length

    @property
    def is_timed(self) -> bool:
        """Whether q5 slides."""
        return self.settings.forces[1] != 0

    def rate_limits(self, acceleration: float) -> tuple[FloatArray, FloatArray]:
        """Nominal speeds and the accelerations of q1 to q3, (3,) each, [rad/s] and [rad/s²]."""
        return np.full(MOVED, JOINT_SPEED), np.full(MOVED, acceleration)

    def at(self, distances: FloatArray, times: FloatArray | None = None) -> FloatArray:
        """Positions of q1 to q3 at distances and times (k,) in order, (k, 3), [rad]."""
        times = np.zeros(len(distances)) if times is None else times
        parameters = self.arc.parameter(distances)
        tangents = self.curve(parameters, 1)
        lengths = np.linalg.norm(tangents, axis=1)
        tangents = tangents / np.where(lengths > 0, lengths, 1)[:, None]
        q5, points = wrist_positions(self.settings, times)[:, 1], self.curve(parameters)
        return solve(self.arm, points, q5, self.settings.branches[0], tangents)[0]

    def motion(self, profile: PathProfile, samples: int) -> ArmMotion:
        """Motion by a profile, at uniform times."""
        return trajectory.follow(self.curve, self.arc, profile, self.arm, self.settings, samples)

    def is_refuted(
        self,
        profile: Callable[[], PathProfile],
        collision_world: CollisionWorld,
        required: float,
    ) -> bool:
        """Check whether a few poses show that the arm is not clear.

        If q5 slides, a proof is tried instead, since q5 at a pose would have to be computed first;
        and nothing where only the duration bounds q5.
        """
        timed = profile()
        slide = slide_bounds(self.curve, self.arc, timed, self.settings)
        elbow = self.settings.branches[0]
        table = self.arm.table(elbow)
        low, high = float(slide.low.min()), float(slide.high.max())
        if low < high:
            if isinstance(timed, CubicProfile):
                return False
            tries = _TRIES_TO_REFUTE
            found = certify_paper_arm(
                self.curve, slide, self.arm, elbow, collision_world, required, tries
            )
            return isinstance(found, Refutation) and found.decided
        points = flat(self.curve(np.linspace(*self.curve.interval, _POSES_TO_REFUTE)))
        reached, touching = np.zeros((2, _POSES_TO_REFUTE), dtype=np.bool_)
        forearm = float(self.arm.forearm(low))
        paper_arm_mask_kernels.reached_places(points, table, forearm, 0.0, reached)
        if not reached.all():
            return True
        paper_arm_mask_kernels.touching_places(
            points,
            table,
            collision_world.beyond(required),
            forearm,
            0.0,
            read_only(reached),
            touching,
        )
        return bool(touching.any())

    def clearance(
        self,
        motion: ArmMotion,
        collision_world: CollisionWorld,
        required: float,
    ) -> ArmClearance:
        """Clearance of the whole arm in that motion, measured and proven."""
        return arm_clearance(motion, self.arm, collision_world, required)

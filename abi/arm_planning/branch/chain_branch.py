"""Tool positions, segments and curves that a URDF arm allows from one of its start poses."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Self

import numpy as np

from abi import arguments
from abi.arm_planning.arm_errors import beyond_reach
from abi.arm_planning.branch.followed import Followed
from abi.arm_planning.branch.segment_memory import SegmentMemory
from abi.arm_planning.certificates.chain_certificate import MOST_TRIES as CURVE_TRIES
from abi.arm_planning.certificates.chain_certificate import chain_refutation
from abi.arm_planning.exclusion.arm_path_kernels import MOST_TRIES
from abi.arm_planning.exclusion.node_configuration_kernels import touching_configurations
from abi.arm_planning.exclusion.node_configurations import NodeConfigurations
from abi.arm_planning.exclusion.touching import touching
from abi.arm_planning.motion.urdf_motion import ChainJointPath, joint_path_from
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arm_planning.world.collision_world_kernels import Obstacles
from abi.arm_planning.world.link_contact import link_gap
from abi.arrays import BoolArray, FloatArray, read_only
from abi.curves.clearance.certificate import Refutation
from abi.curves.curve import ArcLength, Curve
from abi.robot.kinematics.start_poses import REACHED
from abi.robot.urdf_arm import UrdfArm
from abi.tet_mesh.node_tree import NodeTree

_STEP = 1 / 60
"""Largest distance of the tool between two poses of a segment, over the arm's reach."""
_AT_LIMIT = 1e-3
"""Distance from its limit at which a joint counts as stopped by it, [rad] or [m]."""
_SAMPLES = 241
"""Number of points of a curve that are tested."""


@dataclass(frozen=True, eq=False)
class ChainBranch:
    """Edges and curves that a URDF arm allows its tool from one start pose.

    A redundant arm takes the configuration at a point that it reaches from the start pose, drawn
    towards a pose called home; segments begin with the configuration of the nearest node.

    Attributes:
        arm: the arm.
        name: the pose, as the beginning of a sentence.
        collision_world: obstacles and floor.
        configurations: its joints all over the mesh.
        clearance: distance that its links keep from obstacles, [unit].
        slack: distance that segments and nodes keep beyond that, [unit].
        most_tries: pairs of a capsule and an obstacle to try, to prove a segment or a node clear.
        memory: of segments that were asked about with these configurations before.
    """

    arm: UrdfArm
    name: str
    collision_world: CollisionWorld
    configurations: NodeConfigurations
    clearance: float
    slack: float
    most_tries: int = field(default=MOST_TRIES, kw_only=True)
    memory: SegmentMemory = field(default_factory=SegmentMemory, kw_only=True)

    @property
    def segments(self) -> None:
        """None, as the compiled loops do not support this arm."""

    @property
    def key(self) -> tuple[object, ...]:
        """Everything that the excluded nodes depend on, except the obstacles."""
        return self.arm, self.configurations, self.clearance, self.slack

    def scaled(self, slack: float = 1.0, tries: int = 1) -> Self:
        """A copy with multiples of the slack and the tries."""
        return replace(self, slack=slack * self.slack, most_tries=tries * self.most_tries)

    def refutation(self, curve: Curve) -> Refutation | None:
        """Find where on a curve the arm is not proven clear; None if it is clear throughout."""
        parameters = np.linspace(*curve.interval, _SAMPLES)
        points = curve(parameters)
        key = points.tobytes(), parameters.tobytes(), self.clearance
        follow = partial(self._follow_curve, parameters, points)
        refute = partial(self._refutation, self.clearance, CURVE_TRIES)
        return self.memory.examined(key, follow, refute)[1]

    def polyline_refutation(self, points: FloatArray) -> Refutation | None:
        """Why the arm is not clear along a polyline (k, 3), [unit]; parameter k is its vertex k."""
        return self._examined(arguments.polyline("points", points), None)[1]

    def link_gap(self, point: FloatArray, pair: tuple[str, int | str]) -> float | None:
        """Distance of the first of a pair itself from the other at a point (3,), [unit]."""
        point = arguments.numbers("point", point, (3,))
        _, joints, _ = self._follow_polyline(np.stack([point, point]), None)
        return link_gap(self.arm, self.collision_world, joints[-1], pair)

    def unreached(self, point: FloatArray) -> str:
        """Why the arm does not reach a point (3,), [unit], world, as a predicate; else empty."""
        point = arguments.numbers("point", point, (3,))
        if self.configurations.near(point) is None:
            return ""
        _, joints, missed = self._follow_polyline(np.stack([point, point]), None)
        if missed[-1] <= REACHED * self.arm.reach:
            return ""
        room = np.abs(self.arm.limits - joints[-1][:, None])
        joint, side = divmod(int(room.argmin()), 2)
        if room[joint, side] > _AT_LIMIT * self.arm.scales[joint]:
            return beyond_reach(float(missed[-1]))
        limit, slides = float(self.arm.limits[joint, side]), self.arm.chain.slides[joint]
        return beyond_reach(float(missed[-1]), self.arm.joints[joint], limit, bool(slides))

    def clear_segments(self, points: FloatArray) -> BoolArray:
        """Check if the arm is proven clear on each segment (k - 1,) of a polyline (k, 3), k >= 2.

        Each begins with the pose in which the one before ended; after one that is not clear, with
        the configuration of the nearest node.
        """
        points = arguments.polyline("points", points)
        clear = np.zeros(len(points) - 1, dtype=np.bool_)
        pose: tuple[FloatArray, FloatArray] | None = None
        for k in range(len(clear)):
            followed, fault = self._examined(points[k : k + 2], pose)
            clear[k] = fault is None
            pose = (points[k + 1], followed.joints[-1]) if clear[k] else None
        return clear

    def joint_path(self, curve: Curve, arc: ArcLength) -> ChainJointPath:
        """The joints along a curve, from that pose; cached by curve."""
        places = curve(np.linspace(*curve.interval, _SAMPLES)).tobytes()
        if self.memory.joint_path is None or self.memory.joint_path[0] != places:
            first, home = self.configurations.first, self.configurations.home
            self.memory.joint_path = places, joint_path_from(first, curve, arc, self.arm, home)
        return self.memory.joint_path[1]

    def reached(self, points: FloatArray) -> BoolArray:
        """Check whether the arm reaches nodes (n, 3), clear of the floor and itself, (n,)."""
        reached = self.configurations.reached
        arguments.numbers("points", points, (len(reached), 3))
        collision_world = self.collision_world.only(self.collision_world.numbers < 0).beyond(
            self._beyond
        )
        coordinates = self.configurations.coordinates
        return reached & ~touching(self.arm, coordinates, collision_world, self.slack, reached)

    def touching(
        self, points: FloatArray, number: int, reached: BoolArray, tree: NodeTree | None = None
    ) -> BoolArray:
        """Check if it nearly touches obstacle ``number`` at nodes (n, 3) that it reaches, (n,)."""
        reached = arguments.flags("reached", reached, self.configurations.reached.shape)
        arguments.numbers("points", points, (len(reached), 3))
        row = self.collision_world.first_row(number)
        if not touching_configurations.compiled:  # a tree would take longer than it saves
            alone = self._around._replace(outer=read_only(np.array([row], dtype=np.int32)))
            return touching(self.arm, self.configurations.coordinates, alone, -1.0, reached)
        found, known = np.zeros(len(reached), dtype=np.bool_), self.configurations
        touching_configurations(
            *(self.arm.chain.table, self.arm.bodies, known.coordinates, known.tree),
            *((self._around, row), -1.0, reached, found),
        )
        return found

    @property
    def _beyond(self) -> float:
        """Distance that segments and places keep, [unit]."""
        return self.clearance + self.slack

    @cached_property
    def _around(self) -> Obstacles:
        return self.collision_world.beyond(self._beyond)

    def _examined(
        self, vertices: FloatArray, begin: tuple[FloatArray, FloatArray] | None
    ) -> tuple[Followed, Refutation | None]:
        """Joints along a polyline, and where the arm is not clear; see :meth:`_follow_polyline`."""
        first = b"" if begin is None else begin[0].tobytes() + begin[1].tobytes()
        key = vertices.tobytes(), first, self._beyond, self.most_tries
        follow = partial(self._follow_polyline, vertices, begin)
        return self.memory.examined(
            key, follow, partial(self._refutation, self._beyond, self.most_tries)
        )

    def _follow_curve(self, parameters: FloatArray, points: FloatArray) -> Followed:
        """Joints at points (k, 3) of a curve, from the first pose."""
        first, home = self.configurations.first, self.configurations.home
        return Followed(parameters, *self.arm.follow(first, points, home))

    def _follow_polyline(
        self, vertices: FloatArray, begin: tuple[FloatArray, FloatArray] | None
    ) -> Followed:
        """Joints along a polyline (k, 3), k >= 1.

        Args:
            vertices: of the polyline, [unit], world.
            begin: place and joints to begin with; the way to the first vertex is left out. None for
                the configuration of the nearest node.
        """
        begin = begin or self.configurations.near(vertices[0])
        if begin is None:  # no node is reached
            nowhere = np.full((1, len(self.configurations.first)), np.nan)
            return Followed(np.zeros(1), nowhere, np.full(1, np.inf))
        lengths = np.linalg.norm(np.diff(vertices, axis=0), axis=1)
        counts = np.ceil(lengths / (_STEP * self.arm.reach)).astype(int).clip(1)
        parameters = np.concatenate(
            [[0.0], *(k + np.arange(1, n + 1) / n for k, n in enumerate(counts))]
        )
        rows = np.arange(len(vertices))
        targets = np.stack([np.interp(parameters, rows, part) for part in vertices.T], axis=1)
        points = np.concatenate([[begin[0]], targets])
        joints, missed = self.arm.follow(begin[1], points, self.configurations.home)
        return Followed(parameters, joints[1:], missed[1:])

    def _refutation(
        self,
        margin: float,
        tries: int,
        followed: Followed,
        around: CollisionWorld,
        with_itself: bool = True,
    ) -> Refutation | None:
        """Place at which joint positions miss their points, or are not proven clear."""
        parameters, joints, missed = followed
        beyond = np.flatnonzero(missed > REACHED * self.arm.reach)
        if len(beyond):
            return Refutation(float(parameters[beyond[0]]), -1, True)
        found = chain_refutation(self.arm, joints, around, margin, tries, with_itself)
        if found is None:
            return None
        at = float(np.interp(found.parameter, np.arange(len(parameters)), parameters))
        return replace(found, parameter=at)

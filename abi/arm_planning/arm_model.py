"""The questions that the planner asks of any arm."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, Protocol, Self

from abi.arm_planning.arm_errors import LinkContact
from abi.arm_planning.exclusion.arm_path_kernels import ArmSegments
from abi.arm_planning.motion.arm_clearance import ArmClearance
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arrays import BoolArray, FloatArray
from abi.curves.bspline import BSpline
from abi.curves.clearance.certificate import Refutation
from abi.curves.cubic_profile import PathProfile
from abi.curves.curve import ArcLength, Curve
from abi.curves.quadratic import Quadratic
from abi.errors import format_length
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.any_arm import AnyArm
from abi.robot.urdf_arm import UrdfArm
from abi.scene.arm_settings import ArmSettings
from abi.scene.scene import Scene
from abi.tet_mesh.node_tree import NodeTree
from abi.tet_mesh.tet_mesh import TetMesh


class JointPath(Protocol):
    """Joint positions of an arm along its tool's curve, for one elbow side or one start pose."""

    @property
    def length(self) -> float:
        """Distance from start to goal, [unit]: usually the arc length of the tool's curve."""

    @property
    def is_timed(self) -> bool:
        """Whether these joints also depend on the time, as another joint moves meanwhile."""

    def at(self, distances: FloatArray, times: FloatArray | None = None) -> FloatArray:
        """Positions of these joints at distances along the curve and times (k,) in order, (k, n).

        Without times they are those at the start.
        """

    def rate_limits(self, acceleration: float) -> tuple[FloatArray, FloatArray]:
        """Largest speeds and accelerations of these joints, (n,) each, [rad] or [unit] by [s].

        Args:
            acceleration: largest of each joint, [rad/s²], of sliding ones [m/s²].
        """

    def motion(self, profile: PathProfile, samples: int) -> ArmMotion:
        """The motion by a profile, at uniform times."""

    def is_refuted(
        self,
        profile: Callable[[], PathProfile],
        collision_world: CollisionWorld,
        required: float,
    ) -> bool:
        """Quick check that the arm is not clear; False if that would take long.

        Args:
            profile: makes the motion along it, which is asked for only where it counts.
            collision_world: everything around the arm.
            required: clearance that the links are to keep from obstacles, [unit].
        """

    def clearance(
        self,
        motion: ArmMotion,
        collision_world: CollisionWorld,
        required: float,
    ) -> ArmClearance:
        """Clearance of the whole arm in that motion, measured and proven."""


class ArmBranch(Protocol):
    """Nodes, edges and curves that an arm allows on one branch, such as an elbow of the paper's."""

    @property
    def name(self) -> str:
        """The branch, as the beginning of a sentence."""

    @property
    def key(self) -> tuple[object, ...]:
        """Key for caches: all that the excluded nodes depend on, except the obstacles."""

    def reached(self, points: FloatArray) -> BoolArray:
        """Flag the nodes (n, 3) of the mesh that the arm reaches, clear of the floor and itself."""

    def touching(
        self, points: FloatArray, number: int, reached: BoolArray, tree: NodeTree | None = None
    ) -> BoolArray:
        """Check whether the arm touches, or nearly touches, an obstacle at nodes (n, 3), (n,).

        Args:
            points: the nodes, [unit], world.
            number: of the obstacle, from 0.
            reached: nodes to look at.
            tree: over the nodes: quicker near an obstacle of many parts.
        """

    @property
    def segments(self) -> ArmSegments | None:
        """Data with which compiled loops test segments; None if they do not support the arm."""

    def refutation(self, curve: BSpline | Quadratic) -> Refutation | None:
        """Find where on a curve the arm is not proven clear; None if it is clear throughout."""

    def polyline_refutation(self, points: FloatArray) -> Refutation | None:
        """Why the arm is not clear along a polyline (k, 3), k >= 1; None if it is proven clear.

        The parameter of a refutation counts vertices: k is vertex k.
        """

    def unreached(self, point: FloatArray) -> Unreached | None:
        """Reason why the arm does not reach a point (3,); None if it is not known."""

    def link_contact(self, point: FloatArray, pair: tuple[str, int | str]) -> LinkContact | None:
        """Whether the first of a pair touches the other by its own shapes at a point (3,); or
        None."""

    def clear_segments(self, points: FloatArray) -> BoolArray:
        """Check if the arm is proven clear on each segment (k - 1,) of a polyline (k, 3)."""

    def joint_path(self, curve: Curve, arc: ArcLength) -> JointPath:
        """The joints along a curve."""

    def scaled(self, slack: float = 1.0, tries: int = 1) -> Self:
        """A copy with multiples of the margin beyond the clearance and of a proof's tries."""


class Unreached(NamedTuple):
    """A point that is out of an arm's reach, or takes a joint past its limit.

    Attributes:
        shortfall: distance by which the point is out of reach, [unit]: > 0 too far, < 0 too near to
            the shoulder, 0 where a limit alone is in the way.
        joint: name of a joint that is at its limit, or would be past it; empty for none.
        value: position of that joint, [rad] or [unit].
        limit: its limit, [rad] or [unit].
        slides: whether it slides.
        room: distance that its turn has to keep from the limit, [rad].
        part: of an arm, where the joint is, for people who do not know its name; or empty.
    """

    shortfall: float
    joint: str = ""
    value: float = 0.0
    limit: float = 0.0
    slides: bool = False
    room: float = 0.0
    part: str = ""

    @property
    def words(self) -> str:
        """Predicate of a sentence on the arm, with the unit's placeholder after lengths."""
        value, limit = map(self._position, (self.value, self.limit))
        if self.shortfall == 0.0:
            side = "past its limit of"
            if abs(self.value) <= abs(self.limit):
                room = math.degrees(self.room)
                side = f"which leaves less than {room:.1f}° to its limit of"
            where = f" (the {self.part})" if self.part else ""
            return f"would need {self.joint}{where} at {value}, {side} {limit},"
        near = ", too near to its shoulder," if self.shortfall < 0 else ""
        at_limit = f", with {self.joint} at its limit of {limit}," if self.joint else ""
        return f"is out of reach by {format_length(abs(self.shortfall))}{near}{at_limit}"

    def _position(self, value: float) -> str:
        return format_length(value) if self.slides else f"{math.degrees(value):.1f}°"


class BranchProblem(NamedTuple):
    """What the branches of an arm are made from: scene, mesh, collision world and margin.

    Attributes:
        scene: the scene.
        collision_world: everything around the arm.
        mesh: whose nodes may be asked about.
        slack: distance that segments and places keep beyond the clearance, [unit].
    """

    scene: Scene
    collision_world: CollisionWorld
    mesh: TetMesh
    slack: float


class ArmModel(Protocol):
    """An arm and its inverse kinematics, by formulas or by damped least squares."""

    @property
    def arm(self) -> AnyArm:
        """The arm."""

    @property
    def chain_arm(self) -> UrdfArm | None:
        """The arm, if motions can be sought in the space of its joints."""

    def collision_world(self, obstacles: ObstacleSet, lowest: float) -> CollisionWorld:
        """The arm's collision world, above a floor no higher than ``lowest``, [unit]."""

    def joint_paths(
        self,
        curve: Curve,
        arc: ArcLength,
        settings: ArmSettings,
        collision_world: CollisionWorld,
        hasty: bool = False,
    ) -> Sequence[JointPath]:
        """Joint positions along a curve on each allowed branch, the preferred first.

        In haste the branch preferred last will do where it leads far from obstacles.
        """

    def is_refuted(
        self,
        curve: Curve,
        arc: ArcLength,
        collision_world: CollisionWorld,
        required: float,
    ) -> bool:
        """Check if a few poses show that the arm is not clear along a curve on any branch.

        Args:
            curve: path of the tool.
            arc: its arc length.
            collision_world: everything around the arm.
            required: clearance that the links are to keep from obstacles, [unit].
        """

    def branches(self, problem: BranchProblem, only: str = "") -> Sequence[ArmBranch]:
        """The allowed branches; if one is named, it alone or none."""

    def branches_in_turn(self, problem: BranchProblem) -> Iterator[ArmBranch]:
        """The allowed branches, each made on demand, that of the last joint path first."""

    def other_branches(self, problem: BranchProblem) -> tuple[Iterator[ArmBranch], str]:
        """Further branches, tried if none of the first leads to a motion, each made on demand.

        With them comes a sentence on why there are none; empty if that is not known.
        """

"""The questions that the planner asks of any arm."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol, Self

from abi.arm.any_arm import AnyArm
from abi.arm.arm_certificate import ArmRefutation
from abi.arm.arm_clearance import ArmClearance
from abi.arm.leg_kernels import ArmLegs
from abi.arm.surroundings import Surroundings
from abi.arm.trajectory import ArmMotion
from abi.arrays import BoolArray, FloatArray
from abi.curves.bspline import BSpline
from abi.curves.curve import ArcLength, Curve
from abi.curves.quadratic import Quadratic
from abi.curves.timed_profile import PathProfile
from abi.obstacles.obstacle_set import ObstacleSet
from abi.scene.scene import Scene
from abi.scene.settings import ArmSettings
from abi.tet_mesh.node_tree import NodeTree
from abi.tet_mesh.tet_mesh import TetMesh


class Course(Protocol):
    """Joints of an arm along a curve, on one of its branches."""

    @property
    def curve(self) -> Curve:
        """Path of the tool."""

    @property
    def arc(self) -> ArcLength:
        """Arc length of the curve."""

    @property
    def speeds(self) -> FloatArray:
        """Largest speed of each joint that the inverse kinematics moves, (n,)."""

    @property
    def scales(self) -> FloatArray:
        """A limit of [rad/s²] or [m/s²] in the unit of each joint, (n,)."""

    def at(self, distances: FloatArray) -> FloatArray:
        """Positions of these joints at distances (k,) along the curve, (k, n)."""

    def motion(self, profile: PathProfile, samples: int) -> ArmMotion:
        """The motion by a profile, at uniform times."""

    def is_refuted(self, profile: PathProfile, around: Surroundings, required: float) -> bool:
        """Whether it shows at once that the arm is not clear; False where that takes long."""

    def clearance(
        self, motion: ArmMotion, obstacles: ObstacleSet, around: Surroundings, required: float
    ) -> ArmClearance:
        """Clearance of the whole arm in that motion, measured and proven."""


class Places(Protocol):
    """Nodes of a mesh that an arm excludes on one branch."""

    @property
    def key(self) -> tuple[object, ...]:
        """All that they depend on, beside the obstacles."""

    def reached(self, points: FloatArray) -> BoolArray:
        """Nodes (n, 3) of the mesh that the arm reaches, clear of floor and itself, (n,)."""

    def touching(
        self, points: FloatArray, number: int, reached: BoolArray, tree: NodeTree | None = None
    ) -> BoolArray:
        """Nodes (n, 3) at which the arm touches an obstacle, or nearly, of those reached (n,).

        Args:
            points: the nodes, [unit], world.
            number: of the obstacle, from 0.
            reached: nodes to look at.
            tree: over the nodes: quicker near an obstacle of many parts.
        """


class Sight(Places, Protocol):
    """Questions to an arm on one branch; see :class:`abi.arm.arm_sight.ArmSight`."""

    @property
    def branch(self) -> str:
        """The branch, as the beginning of a sentence."""

    @property
    def legs(self) -> ArmLegs | None:
        """Surroundings of legs for compiled loops; None where these do not know the arm."""

    def refutation(self, curve: BSpline | Quadratic) -> ArmRefutation | None:
        """Place of a curve at which the arm is not proven clear; None for a clear curve."""

    def leg_refutation(self, points: FloatArray) -> ArmRefutation | None:
        """The same of a polyline (k, 3), k >= 1; parameter k is its vertex k."""

    def clear_legs(self, points: FloatArray) -> BoolArray:
        """Legs (k - 1,) of a polyline (k, 3), k >= 2, on which the arm is proven clear."""

    def course(self, curve: Curve, arc: ArcLength) -> Course:
        """The joints along a curve."""

    def wider(self, times: float) -> Self:
        """The same with so many times the distance that legs keep beyond the clearance."""

    def patient(self, times: int) -> Self:
        """The same with so many times the tries to prove a leg clear."""


class OtherSights(NamedTuple):
    """Further sights, tried where no branch leads to a motion.

    Attributes:
        sights: made one by one when they are asked for.
        note: sentence on why there are none; empty where it is not known.
    """

    sights: Iterator[Sight]
    note: str = ""


class ArmModel(Protocol):
    """An arm, and how its joints are found: by formulas, or by damped least squares."""

    @property
    def arm(self) -> AnyArm:
        """The arm."""

    def surroundings(self, obstacles: ObstacleSet, lowest: float) -> Surroundings:
        """Everything around it, above a floor no higher than ``lowest``, [unit]."""

    def courses(
        self,
        curve: Curve,
        arc: ArcLength,
        settings: ArmSettings,
        obstacles: ObstacleSet,
        around: Surroundings,
    ) -> Sequence[Course]:
        """Its joints along a curve, on each branch that may be taken, the preferred first."""

    def sights(
        self, scene: Scene, mesh: TetMesh, around: Surroundings, slack: float
    ) -> Sequence[Sight]:
        """Questions to it on each branch that may be taken.

        Args:
            scene: the scene.
            mesh: whose nodes may be asked about.
            around: everything around it.
            slack: distance that legs and places keep beyond the clearance, [unit].
        """

    def other_sights(
        self, scene: Scene, mesh: TetMesh, around: Surroundings, slack: float
    ) -> OtherSights:
        """Questions to it on further branches, after :meth:`sights`; arguments as there."""

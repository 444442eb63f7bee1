"""What the stages give: the result of each, and those that a plan of a scene has."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

from abi.arm_planning.joint_search.search_joints import JointSearch
from abi.arm_planning.motion.arm_clearance import ArmClearance, is_clear
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.curves.bspline import BSpline
from abi.curves.cubic_profile import PathProfile
from abi.curves.curve import ArcLength
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.search.graph import Graph
from abi.search.search import SearchResult
from abi.search.taut.lower_bound import Bound
from abi.search.taut.taut_path import TautPath
from abi.tet_mesh.exclusion import FreeMesh
from abi.tet_mesh.tet_mesh import TetMesh

AnyFit: TypeAlias = Fit[BSpline] | Fit[Quadratic]
CurveName: TypeAlias = Literal["bspline", "quadratic"]


class ShortestPath(NamedTuple):
    """Result of stage 3.

    Attributes:
        graph: in which it was found: that of stage 2, without edges that turned out not to be free.
        path: result of the search that the scene chooses.
        clearance: distance of the path to the obstacles, [unit].
    """

    graph: Graph
    path: SearchResult
    clearance: float


class TimedMotion(NamedTuple):
    """Result of stage 6: the motion along the curve, the joints over time, and their clearance."""

    profile: PathProfile
    motion: ArmMotion
    clearance: ArmClearance

    @property
    def is_clear(self) -> bool:
        """Whether the whole arm is proven clear all along it, in reach and range."""
        return is_clear(self.motion, self.clearance)


@dataclass(frozen=True, eq=False, kw_only=True)
class StageResults:
    """Results of the stages of a scene, or of a branch, so far; what was not reached is None.

    Lengths are in the scene's [unit], points in the world frame.

    Attributes:
        free: stage 1, the mesh without the nodes and edges that the obstacles exclude.
        graph: stage 2, the free mesh with start and goal.
        searches: stage 3, the result of each search.
        path: the result of the search that the scene chooses.
        path_clearance: distance of that path to the obstacles; inf without obstacles.
        taut: stage 3½, the path pulled taut; None if that is switched off.
        optimum: lower bound of the length of any curve that keeps the clearance.
        bspline: stage 4, the B-spline, its clearance and its arc length.
        quadratic: stage 5, the quadratic, its clearance and its arc length.
        followed: ``bspline`` or ``quadratic``, whichever the arm follows.
        profile: stage 5, the motion along that curve.
        motion: stage 6, the arm's joint positions over time.
        arm_clearance: distance of its links to the obstacles along the motion.
        tool_only: the curve planned for the tool alone, if the whole arm follows another one.
        joint_search: the search in the space of the joints, if the motion is found there; the arm
            then follows no curve of the tool.
    """

    free: FreeMesh | None = None
    graph: Graph | None = None
    searches: tuple[SearchResult, ...] = ()
    path: SearchResult | None = None
    path_clearance: float = math.inf
    taut: TautPath | None = None
    optimum: Bound | None = None
    bspline: Fit[BSpline] | None = None
    quadratic: Fit[Quadratic] | None = None
    followed: CurveName | None = None
    profile: PathProfile | None = None
    motion: ArmMotion | None = None
    arm_clearance: ArmClearance | None = None
    tool_only: AnyFit | None = None
    joint_search: JointSearch | None = None

    @property
    def mesh(self) -> TetMesh | None:
        """The tetrahedral mesh of the whole workspace."""
        return None if self.free is None else self.free.mesh

    @property
    def curves(self) -> dict[str, AnyFit | None]:
        """Curves of stages 4 and 5 by name."""
        return {"bspline": self.bspline, "quadratic": self.quadratic}

    @property
    def followed_curve(self) -> AnyFit | None:
        """The curve that the arm executes."""
        return self.curves[self.followed] if self.followed else None

    @property
    def bspline_arc(self) -> ArcLength | None:
        """Arc length of the B-spline."""
        return None if self.bspline is None else self.bspline.arc

    @property
    def quadratic_arc(self) -> ArcLength | None:
        """Arc length of the quadratic."""
        return None if self.quadratic is None else self.quadratic.arc

    @property
    def followed_arc(self) -> ArcLength | None:
        """Arc length of the curve that the arm executes."""
        return None if self.followed_curve is None else self.followed_curve.arc

    @property
    def moves_along(self) -> str | None:
        """Name of the curve that is followed: one of the tool, or ``joints``."""
        return self.followed if self.joint_search is None else "joints"

    @property
    def is_arm_clear(self) -> bool:
        """Whether the whole arm is proven clear all along its motion, in reach and range."""
        if self.motion is None or self.arm_clearance is None:
            return False
        return is_clear(self.motion, self.arm_clearance)

    @property
    def lengths(self) -> dict[str, float | None]:
        """Lengths of paths and curves by stage, [unit]; None for a stage without a result."""
        path, taut, spline, quadratic = self.path, self.taut, self.bspline_arc, self.quadratic_arc
        return {
            "path": None if path is None else path.length,
            "taut": None if taut is None else taut.length,
            "bspline": None if spline is None else spline.length,
            "quadratic": None if quadratic is None else quadratic.length,
        }

    @property
    def kept_lengths(self) -> dict[str, float]:
        """Lengths of the paths and curves proven to keep the clearance, by stage, [unit]."""
        lacking = {name for name, fit in self.curves.items() if fit is None or not fit.holds}
        kept = {name: length for name, length in self.lengths.items() if name not in lacking}
        return {name: length for name, length in kept.items() if length is not None}

    @property
    def best_known(self) -> float | None:
        """Length of the shortest of this plan's curves that keep the clearance, [unit]."""
        return min(self.kept_lengths.values(), default=None)

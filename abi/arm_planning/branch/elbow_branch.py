"""Tool positions, segments and curves that the paper's arm allows on one elbow branch."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, Self

import numpy as np

from abi import arguments
from abi.arm_planning.arm_errors import beyond_limit, beyond_reach
from abi.arm_planning.branch.paper_arm_joint_path import PaperArmJointPath
from abi.arm_planning.certificates.paper_arm_certificate import certify_paper_arm
from abi.arm_planning.certificates.separate_paper_arm_kernels import UNREACHED, Slide, separate_arm
from abi.arm_planning.exclusion import (
    arm_path_kernels,
    paper_arm_mask_kernels,
    paper_arm_node_tree_kernels,
)
from abi.arm_planning.exclusion.arm_path_kernels import MOST_TRIES, ArmSegments
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arrays import BoolArray, FloatArray, flat, read_only
from abi.curves.bezier import Bezier
from abi.curves.clearance.certificate import Certificate, Refutation
from abi.curves.clearance.separation_kernels import CERTIFIED, MOST_HALVINGS, REFUTED
from abi.curves.curve import ArcLength, Curve
from abi.robot.paper_arm.inverse_kinematics import solve
from abi.robot.paper_arm.paper_arm import JOINTS, PaperArm
from abi.robot.paper_arm.pose_kernels import ArmTable
from abi.scene.arm_settings import ArmSettings
from abi.tet_mesh.node_tree import NodeTree

_SPARE = 0.01
"""Distance of segments from the limits of q2 and q3, as room for rounded corners, [rad]."""


@dataclass(frozen=True, eq=False)
class ElbowBranch:
    """Edges and curves that the paper's arm allows on one elbow branch, its slide in a range.

    Attributes:
        arm: the arm.
        elbow: its branch.
        collision_world: obstacles, floor and column.
        extensions: least and greatest q5 while it moves, [unit].
        clearance: distance that its links keep from obstacles, [unit].
        slack: distance that segments and nodes keep beyond that, so that a curve may round them,
            [unit].
        most_tries: pairs of a capsule and an obstacle to try, to prove a segment or a node clear.
        settings: of the arm's drives.
    """

    arm: PaperArm
    elbow: Literal["up", "down"]
    collision_world: CollisionWorld
    extensions: tuple[float, float]
    clearance: float
    slack: float
    most_tries: int = field(default=MOST_TRIES, kw_only=True)
    settings: ArmSettings = field(default_factory=ArmSettings, kw_only=True)

    @property
    def name(self) -> str:
        """The branch, as the beginning of a sentence."""
        return f"With the elbow {self.elbow}"

    @property
    def key(self) -> tuple[object, ...]:
        """Everything that the excluded nodes depend on, except the obstacles."""
        return self.arm, self.elbow, self.extensions, self.clearance, self.slack

    def scaled(self, slack: float = 1.0, tries: int = 1) -> Self:
        """A copy with multiples of the slack and the tries."""
        return replace(self, slack=slack * self.slack, most_tries=tries * self.most_tries)

    def refutation(self, curve: Curve | Bezier) -> Refutation | None:
        """Find where on a curve the arm is not proven clear; None if it is clear throughout."""
        slide = Slide(flat(curve.bezier().breaks[[0, -1]]), *self._extensions)
        result = certify_paper_arm(
            curve, slide, self.arm, self.elbow, self.collision_world, self.clearance
        )
        return None if isinstance(result, Certificate) else result

    def polyline_refutation(self, points: FloatArray) -> Refutation | None:
        """Why the arm is not clear along a polyline (k, 3), [unit]; parameter k is its vertex k."""
        vertices = arguments.polyline("points", points)
        fault = self._refuted(vertices, self.segments.arm)
        if fault is not None and fault.capsule < 0 and len(points) == 1:
            # a link that touches something is seen there, and room that is short is not
            touching = self._refuted(vertices, self.arm.table(self.elbow))
            fault = fault if touching is None else touching
        return fault

    def _refuted(self, vertices: FloatArray, table: ArmTable) -> Refutation | None:
        """Find where an arm with the limits of a ``table`` is not clear along a polyline (k, 3)."""
        count = len(vertices) - 1
        segments = np.stack([vertices[:-1], vertices[1:]], axis=1)
        breaks = read_only(np.arange(count + 1, dtype=float))
        room = np.zeros(6 * (count + 2 * MOST_HALVINGS + 2))
        slide = Slide(read_only(np.array([0.0, count])), *self._extensions)
        status, at, pair, _, _ = separate_arm(
            flat(segments),
            breaks,
            room,
            table,
            self.segments.around,
            slide,
            self.most_tries,
        )
        if status == CERTIFIED:
            return None
        capsule, row = divmod(pair, len(self.collision_world.numbers)) if pair >= 0 else (-1, -1)
        decided = status in (REFUTED, UNREACHED)
        return Refutation(at, int(self.collision_world.numbers[row]), decided, capsule)

    def link_gap(self, point: FloatArray, pair: tuple[str, int | str]) -> None:
        """None, as the bodies are the links' own shapes."""

    def unreached(self, point: FloatArray) -> str:
        """Why the arm does not reach a point (3,), [unit], world, as a predicate; else empty."""
        point = arguments.numbers("point", point, (3,))
        extensions = np.array(self.extensions)
        places, still = np.stack([point, point]), np.zeros((2, 3))
        joints, shortfalls = solve(self.arm, places, extensions, self.elbow, still)
        shortfall = float(min(shortfalls, key=abs))
        if shortfall:
            return beyond_reach(shortfall)
        nearest = joints[np.abs(shortfalls).argmin()]
        for number, part in ((1, "shoulder"), (2, "elbow")):
            angle = nearest[number]
            limit = math.copysign(self.arm.limits[number, 1], angle)
            if abs(angle) > abs(limit) - _SPARE:
                return beyond_limit(JOINTS[number], part, float(angle), limit, _SPARE)
        return ""

    def joint_path(self, curve: Curve, arc: ArcLength) -> PaperArmJointPath:
        """The joints along a curve."""
        return PaperArmJointPath(curve, arc, self.arm, self.settings.on(self.elbow))

    def clear_segments(self, points: FloatArray) -> BoolArray:
        """Check if the arm is proven clear on each segment (k - 1,) of a polyline (k, 3)."""
        points = arguments.polyline("points", points)
        clear = np.zeros(len(points) - 1, dtype=np.bool_)
        arm_path_kernels.clear_segments(flat(points), self.segments, clear)
        return clear

    def reached(self, points: FloatArray) -> BoolArray:
        """Check whether the arm reaches points (n, 3), clear of floor and column, (n,)."""
        points = arguments.points("points", points)
        reached = np.zeros(len(points), dtype=np.bool_)
        paper_arm_mask_kernels.reached_places(
            flat(points), self.segments.arm, *self._forearm, reached
        )
        return reached & ~self._touching(
            points, self.collision_world.only(self.collision_world.numbers < 0), reached
        )

    def touching(
        self, points: FloatArray, number: int, reached: BoolArray, tree: NodeTree | None = None
    ) -> BoolArray:
        """Check if it nearly touches obstacle ``number`` at points (n, 3) that it reaches, (n,)."""
        points = arguments.points("points", points)
        reached = arguments.flags("reached", reached, points.shape[:1])
        collision_world = self.collision_world.only(self.collision_world.numbers == number)
        forearm, slide = self._forearm
        if tree is None or slide > 0:
            return self._touching(points, collision_world, reached)
        touching = np.zeros(len(points), dtype=np.bool_)
        obstacle = (
            collision_world.beyond(self.clearance + self.slack),
            self.collision_world.first_row(number),
        )
        paper_arm_node_tree_kernels.places_touching(
            tree, self.arm.table(self.elbow), obstacle, forearm, reached, touching
        )
        return touching

    def _touching(
        self, points: FloatArray, collision_world: CollisionWorld, reached: BoolArray
    ) -> BoolArray:
        touching = np.zeros(len(points), dtype=np.bool_)
        paper_arm_mask_kernels.touching_places(
            flat(points),
            self.arm.table(self.elbow),
            collision_world.beyond(self.clearance + self.slack),
            *self._forearm,
            reached,
            touching,
        )
        return touching

    @cached_property
    def segments(self) -> ArmSegments:
        """Obstacles of the tool's segments in the format of the kernels."""
        table, beyond = self.arm.table(self.elbow, _SPARE), self.clearance + self.slack
        around = self.collision_world.beyond(beyond)
        return ArmSegments(table, around, *self._forearm, self.most_tries)

    @cached_property
    def _extensions(self) -> tuple[FloatArray, FloatArray]:
        """Bounds of q5 at both ends of any path, (2,) each, [unit]."""
        low, high = self.extensions
        return read_only(np.full(2, low)), read_only(np.full(2, high))

    @cached_property
    def _forearm(self) -> tuple[float, float]:
        """Midpoint of a6 and half of its range, [unit]."""
        low, high = map(float, self.extensions)
        return self.arm.a4 + self.arm.a5 + (low + high) / 2, (high - low) / 2

"""Contacts of the exact shapes of a robot's links with obstacles, the floor and other links."""

from __future__ import annotations

import numpy as np

from abi.certification.clearance_proof import MotionProblem
from abi.robot.bodies.link_solids import LinkSolids, link_solids
from abi.robot.bodies.solid_contact import SolidPose, compile_kernels, depth, distance, touch


class ContactFinder:
    """Contacts of a motion's links at poses.

    Args:
        problem: the motion, the bodies and what they keep clear of.
    """

    def __init__(self, problem: MotionProblem) -> None:
        compile_kernels()
        self._task = problem
        self._links = {one.link: one for one in problem.bodies.chain.carried}
        self._obstacles = [LinkSolids((shape,)) for shape in problem.obstacles]

    def touches(self, parameter: float, link: str, other: int | str) -> bool:
        """Decide whether a link touches an obstacle, another link, or the floor.

        Args:
            parameter: of the motion.
            link: name of the link.
            other: number of the obstacle, name of the link, or ``floor``.
        """
        parts = self._beside(parameter, link, other)
        if parts is None:
            return self._height(parameter, link) <= 0
        return touch(parts[0], self._solids(link), parts[1])

    def depth(self, parameter: float, link: str, other: int | str) -> float:
        """How far a link is in something, at least, [unit]; arguments as for :meth:`touches`."""
        parts = self._beside(parameter, link, other)
        if parts is None:
            return max(-self._height(parameter, link), 0.0)
        return depth(parts[0], self._solids(link), parts[1])

    def distance(self, parameter: float, link: str, other: int | str) -> float:
        """Distance at a parameter of a link's corners from something, and the other way, [unit].

        It is at least that of the shapes, and negative inside.
        """
        parts = self._beside(parameter, link, other)
        if parts is None:
            return self._height(parameter, link)
        return distance(parts[0], self._solids(link), parts[1])

    def _beside(
        self, parameter: float, link: str, other: int | str
    ) -> tuple[LinkSolids, SolidPose] | None:
        """The body that a link may touch, and the link's pose in its frame; None for the floor."""
        pose = self._pose(link, parameter)
        if isinstance(other, int):
            return self._obstacles[other], pose
        if other == "floor":
            return None
        base = self._pose(other, parameter)
        place = base.turn.T @ (pose.origin - base.origin)
        return self._solids(other), SolidPose(base.turn.T @ pose.turn, place)

    def _height(self, parameter: float, link: str) -> float:
        """Height of a link's lowest corner above the floor, [unit]."""
        turn, origin = self._pose(link, parameter)
        heights = (self._solids(link).corners @ turn.T + origin)[:, 2]
        return float(heights.min(initial=np.inf)) - self._task.around.floor

    def _solids(self, link: str) -> LinkSolids:
        return link_solids(self._task.bodies.chain.robot.links[link], 1 / self._task.bodies.metres)

    def _pose(self, link: str, parameter: float) -> SolidPose:
        """World from link, [unit]."""
        carried, scale = self._links[link], 1 / self._task.bodies.metres
        turn, origin = carried.pose[:3, :3], carried.pose[:3, 3]
        if carried.frame >= 0:
            positions = self._task.motion.positions_at(np.array([parameter]))
            frame = self._task.bodies.chain.poses(positions)[0, carried.frame]
            turn, origin = frame[:, :3] @ turn, frame[:, :3] @ origin + frame[:, 3]
        return SolidPose(turn, scale * origin)

"""Contacts of the exact shapes of a robot's links with obstacles, the floor and other links.

Each is asked of a motion at a parameter: of a link by its name, and of what it may touch, which is
the number of an obstacle, the name of another link, or ``floor``.
"""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray
from abi.certification.clearance_proof import MotionProblem
from abi.robot.bodies import solid_contact
from abi.robot.bodies.link_solids import LinkSolids, link_solids


def touches(problem: MotionProblem, parameter: float, link: str, other: int | str) -> bool:
    """Decide whether a link touches something."""
    if other == "floor":
        return _height(problem, parameter, link) <= 0
    return solid_contact.touch(*_beside(problem, parameter, link, other))


def may_touch(problem: MotionProblem, parameter: float, link: str, other: int | str) -> bool:
    """Decide whether a link touches something, or comes as near as cylinders' edges are inexact."""
    return solid_contact.may_touch(*_beside(problem, parameter, link, other))


def depth(problem: MotionProblem, parameter: float, link: str, other: int | str) -> float:
    """How far a link is in something, at least, [unit]."""
    if other == "floor":
        return max(-_height(problem, parameter, link), 0.0)
    return solid_contact.depth(*_beside(problem, parameter, link, other))


def distance(problem: MotionProblem, parameter: float, link: str, other: int | str) -> float:
    """Distance of a link's corners from something, and the other way, [unit].

    It is at least that of the shapes, and negative inside.
    """
    if other == "floor":
        return _height(problem, parameter, link)
    return solid_contact.distance(*_beside(problem, parameter, link, other))


def _beside(
    problem: MotionProblem, parameter: float, link: str, other: int | str
) -> tuple[LinkSolids, LinkSolids, FloatArray, FloatArray]:
    """The body that a link may touch, the link, and its rotation and origin in the frame of that.

    That body is an obstacle or another link.
    """
    solid_contact.compile_kernels()
    turn, origin = _pose(problem, link, parameter)
    solids = _solids(problem, link)
    if isinstance(other, int):
        return problem.solids[other], solids, turn, origin
    base, place = _pose(problem, other, parameter)
    return _solids(problem, other), solids, base.T @ turn, base.T @ (origin - place)


def _height(problem: MotionProblem, parameter: float, link: str) -> float:
    """Height of a link's lowest point above the floor, [unit]."""
    return _solids(problem, link).lowest(*_pose(problem, link, parameter)) - problem.around.floor


def _solids(problem: MotionProblem, link: str) -> LinkSolids:
    return link_solids(problem.chain.robot.links[link], 1 / problem.metres)


def _pose(problem: MotionProblem, link: str, parameter: float) -> tuple[FloatArray, FloatArray]:
    """Rotation and origin of a link, [unit], world."""
    chain = problem.chain
    turn, origin = chain.places[link][:3, :3], chain.places[link][:3, 3]
    if chain.frames[link] >= 0:
        positions = problem.motion.positions_at(np.array([parameter]))
        frame = chain.poses(positions)[0, chain.frames[link]]
        turn, origin = frame[:, :3] @ turn, frame[:, :3] @ origin + frame[:, 3]
    return turn, 1 / problem.metres * origin

"""Contacts of links decided by their given shapes instead of the convex pieces around them."""

from __future__ import annotations

import numpy as np

from abi import arguments
from abi.arm_planning.arm_errors import LinkContact
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.bodies.link_solids import LinkSolids, link_solids
from abi.robot.bodies.solid_contact import SolidPose, compile_kernels, depth, distance, touch
from abi.robot.urdf_arm import UrdfArm

_WORLD = SolidPose(np.eye(3), np.zeros(3))
_MOST = 20_000
"""Most triangles of a link that are compared; more would take seconds."""


def link_contact(
    arm: UrdfArm,
    obstacles: ObstacleSet,
    around: CollisionWorld,
    pose: FloatArray,
    pair: tuple[str, int | str],
    clearance: float,
) -> LinkContact | None:
    """Decide whether a link touches what one of its bodies comes too near to.

    Of links without shapes, and of those with very many triangles, that is not decided: the result
    is None.

    Args:
        arm: the arm.
        obstacles: the obstacles.
        around: they and the floor.
        pose: joint positions, (n,), [rad] or [unit].
        pair: name of the link, and number of an obstacle, name of another link, or ``floor``.
        clearance: distance that it is to keep from obstacles, [unit].
    """
    pose = arguments.numbers("pose", pose, arm.scales.shape)
    link, other = pair
    if not _is_decided(arm, *(name for name in pair if isinstance(name, str) and name != "floor")):
        return None
    compile_kernels()
    placed, solids = _placed(arm, link, pose), _solids(arm, link)
    if other == "floor":
        heights = (solids.corners @ placed.turn.T + placed.origin)[:, 2]
        height = float(heights.min(initial=np.inf)) - around.floor
        return LinkContact(height <= 0, max(-height, 0.0), height, 0.0)
    if isinstance(other, int):
        beside, base = LinkSolids((obstacles[other],)), _WORLD
    else:
        clearance = 0.0
        beside, base = _solids(arm, other), _placed(arm, other, pose)
    both = beside, solids, _from(base, placed)
    if touch(*both):
        return LinkContact(True, depth(*both), 0.0, clearance)
    return LinkContact(False, 0.0, distance(*both), clearance)


def are_apart(arm: UrdfArm, pose: FloatArray, link: str, other: str) -> bool:
    """Whether two links are known to be apart, as :func:`link_contact` decides it.

    Args:
        arm: the arm.
        pose: joint positions, (n,), [rad] or [unit].
        link: name of the one.
        other: name of the other.
    """
    pose = arguments.numbers("pose", pose, arm.scales.shape)
    if not _is_decided(arm, link, other):
        return False
    compile_kernels()
    placed, base = _placed(arm, link, pose), _placed(arm, other, pose)
    return not touch(_solids(arm, other), _solids(arm, link), _from(base, placed))


def _is_decided(arm: UrdfArm, *names: str) -> bool:
    """Whether all of some links have shapes, and not too many triangles."""
    links = [arm.chain.robot.links[name] for name in names]
    if not all(one.shapes for one in links):
        return False
    return max(sum(len(shape.faces) for shape in one.shapes) for one in links) <= _MOST


def _from(base: SolidPose, placed: SolidPose) -> SolidPose:
    """A pose in the frame of another."""
    return SolidPose(base.turn.T @ placed.turn, base.turn.T @ (placed.origin - base.origin))


def _solids(arm: UrdfArm, link: str) -> LinkSolids:
    return link_solids(arm.chain.robot.links[link], 1 / arm.metres)


def _placed(arm: UrdfArm, link: str, pose: FloatArray) -> SolidPose:
    """Pose of a link, ``world_from_link``, [unit]."""
    carried = next(one for one in arm.chain.carried if one.link == link)
    turn, origin = carried.pose[:3, :3], carried.pose[:3, 3]
    if carried.frame >= 0:
        frame = arm.chain.poses(pose[None] / arm.scales)[0, carried.frame]
        turn, origin = frame[:, :3] @ turn, frame[:, :3] @ origin + frame[:, 3]
    return SolidPose(turn, origin / arm.metres)

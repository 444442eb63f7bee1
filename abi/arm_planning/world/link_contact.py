"""Contacts of links decided by their given shapes instead of the convex pieces around them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from abi import arguments
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arrays import FloatArray, IntArray, read_only
from abi.robot.bodies.chain_capsules import meeting
from abi.robot.bodies.link_solids import LinkSolids, link_solids
from abi.robot.bodies.solid_contact import compile_kernels, depth, distance, may_touch, touch
from abi.robot.urdf_arm import UrdfArm

_Pose = tuple[FloatArray, FloatArray]
"""Rotation (3, 3) and origin (3,), [unit]."""
_APART = 1e-12
"""Least distance of what does not touch, however near it is by rounding, [unit]."""
_MOST = 20_000
"""Most triangles of a link that are compared; more would take seconds."""


def link_gap(
    arm: UrdfArm, around: CollisionWorld, pose: FloatArray, pair: tuple[str, int | str]
) -> float | None:
    """Distance of a link from what one of its bodies comes too near to, [unit].

    It is above 0, and at least their distance, where they do not touch; otherwise it is how far the
    link is in the other, at least, as a negative number, or 0. Of links without shapes, of those
    with very many triangles, and where only the roundness of cylinders decides, that is not
    decided: the result is None.

    Args:
        arm: the arm.
        around: obstacles and floor.
        pose: joint positions, (n,), [rad] or [unit].
        pair: name of the link, and number of an obstacle, name of another link, or ``floor``.
    """
    pose = arguments.numbers("pose", pose, arm.scales.shape)
    link, other = pair
    if not _is_decided(arm, *(name for name in pair if isinstance(name, str) and name != "floor")):
        return None
    compile_kernels()
    if isinstance(other, str) and other != "floor":
        return _own_gap(arm, link, other, pose[_between(arm, link, other)].tobytes())
    placed, solids = _placed(arm, link, _frames(arm, pose)), _solids(arm, link)
    if isinstance(other, str):
        return solids.lowest(*placed) - around.floor
    return _gap(LinkSolids((around.obstacles[other],)), solids, placed)


def _gap(beside: LinkSolids, solids: LinkSolids, placed: _Pose) -> float | None:
    """Distance of a link from another body, in whose frame it is placed, as of a pair."""
    both = beside, solids, *placed
    if touch(*both):
        return -depth(*both)
    return None if may_touch(*both) else max(distance(*both), _APART)


@lru_cache(maxsize=256)
def _own_gap(arm: UrdfArm, link: str, other: str, between: bytes) -> float | None:
    """Distance of two links, by the positions of the joints between them; cached."""
    beside = _beside(arm, link, other, between)
    return _gap(_solids(arm, other), _solids(arm, link), beside)


@lru_cache(maxsize=1024)
def _own_touch(arm: UrdfArm, link: str, other: str, between: bytes) -> bool:
    """Whether two links touch, by the positions of the joints between them; cached."""
    beside = _beside(arm, link, other, between)
    return touch(_solids(arm, other), _solids(arm, link), *beside)


@lru_cache(maxsize=1024)
def _between(arm: UrdfArm, link: str, other: str) -> IntArray:
    """Numbers of the coordinates that move one link beside another."""
    chain = arm.chain
    frames = chain.frames[link], chain.frames[other]
    common, found = meeting(chain, *frames), set[int]()
    for frame in frames:
        for joint in chain.behind(frame):
            if joint == common:
                break
            found.add(int(chain.table.source[joint]))
    return read_only(np.array(sorted(found), dtype=np.int32))


def _beside(arm: UrdfArm, link: str, other: str, between: bytes) -> _Pose:
    """Pose of a link in the frame of another, by the positions of the joints between them."""
    pose = arm.limits.mean(axis=1)
    pose[_between(arm, link, other)] = np.frombuffer(between)
    frames = _frames(arm, pose)
    (base, place), (turn, origin) = (_placed(arm, name, frames) for name in (other, link))
    return base.T @ turn, base.T @ (origin - place)


def are_apart(arm: UrdfArm, pose: FloatArray, link: str, other: str) -> bool:
    """Whether two links are known to be apart, as :func:`link_gap` decides it.

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
    return not _own_touch(arm, link, other, pose[_between(arm, link, other)].tobytes())


@lru_cache(maxsize=1024)
def _is_decided(arm: UrdfArm, *names: str) -> bool:
    """Whether all of some links have shapes, and not too many triangles."""
    links = [arm.chain.robot.links[name] for name in names]
    if not all(one.shapes for one in links):
        return False
    return max(sum(len(shape.faces) for shape in one.shapes) for one in links) <= _MOST


def _solids(arm: UrdfArm, link: str) -> LinkSolids:
    return link_solids(arm.chain.robot.links[link], 1 / arm.metres)


def _frames(arm: UrdfArm, pose: FloatArray) -> FloatArray:
    """World from frame behind each joint and of the tip, (m + 1, 3, 4), [m], at a pose (n,)."""
    return np.asarray(arm.chain.poses(pose[None] / arm.scales)[0])


def _placed(arm: UrdfArm, link: str, frames: FloatArray) -> _Pose:
    """Pose of a link, ``world_from_link``, [unit], by those of all frames, [m]."""
    number, pose = arm.chain.frames[link], arm.chain.places[link]
    turn, origin = pose[:3, :3], pose[:3, 3]
    if number >= 0:
        frame = frames[number]
        turn, origin = frame[:, :3] @ turn, frame[:, :3] @ origin + frame[:, 3]
    return turn, origin / arm.metres

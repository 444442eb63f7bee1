"""Poses of links in the frames of others."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray
from abi.robot.kinematics.chain import Chain


def relative_poses(
    chain: Chain, first: str | None, second: str, positions: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rotations (k, 3, 3) and origins (k, 3) of a link in the frame of another, [m].

    Args:
        chain: the joints that move.
        first: name of the other link; None for the world.
        second: name of the link.
        positions: coordinates, (k, n).
    """
    return placed_beside(chain, first, second, chain.poses(positions))


def placed_beside(
    chain: Chain, first: str | None, second: str, poses: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rotations and origins of a link in another one's frame, or the world's where that is None.

    Args:
        chain: the robot's chain.
        first: the other link.
        second: the link.
        poses: of the joints, (k, m + 1, 3, 4), world.
    """
    turns, origins = _placed(chain, second, poses)
    if first is None:
        return turns, origins
    others, places = _placed(chain, first, poses)
    back = others.swapaxes(1, 2)
    return back @ turns, (back @ (origins - places)[..., None])[..., 0]


def _placed(chain: Chain, link: str, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotations and origins of a link where joints have poses (k, m, 3, 4), world."""
    turn, origin = chain.places[link][:3, :3], chain.places[link][:3, 3]
    if chain.frames[link] < 0:
        count = len(poses)
        return np.broadcast_to(turn, (count, 3, 3)), np.broadcast_to(origin, (count, 3))
    frames = poses[:, chain.frames[link]]
    return frames[:, :, :3] @ turn, frames[:, :, :3] @ origin + frames[:, :, 3]

"""Poses of links in the frames of others."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray
from abi.robot.kinematics.chain import Chain


class LinkPoses(NamedTuple):
    """Rotations (k, 3, 3) and origins (k, 3), [m]."""

    turns: FloatArray
    origins: FloatArray


def relative_poses(
    chain: Chain, first: str | None, second: str, positions: FloatArray
) -> LinkPoses:
    """Poses of a link in the frame of another.

    Args:
        chain: the joints that move.
        first: name of the other link; None for the world.
        second: name of the link.
        positions: coordinates, (k, n).
    """
    poses = chain.poses(positions)
    turns, origins = _placed(chain, second, poses)
    if first is None:
        return LinkPoses(turns, origins)
    others, places = _placed(chain, first, poses)
    back = others.swapaxes(1, 2)
    return LinkPoses(back @ turns, (back @ (origins - places)[..., None])[..., 0])


def _placed(chain: Chain, link: str, poses: FloatArray) -> LinkPoses:
    """Poses of a link where joints have poses (k, m, 3, 4), world."""
    carried = next(one for one in chain.carried if one.link == link)
    turn, origin = carried.pose[:3, :3], carried.pose[:3, 3]
    if carried.frame < 0:
        count = len(poses)
        return LinkPoses(np.broadcast_to(turn, (count, 3, 3)), np.broadcast_to(origin, (count, 3)))
    frames = poses[:, carried.frame]
    return LinkPoses(frames[:, :, :3] @ turn, frames[:, :, :3] @ origin + frames[:, :, 3])

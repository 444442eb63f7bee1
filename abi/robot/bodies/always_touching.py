"""Links that touch by their given shapes, not just by the bodies that contain them, in any pose."""

from __future__ import annotations

import hashlib

import numpy as np

from abi.arrays import FloatArray
from abi.robot.bodies import body_store, link_solids, solid_contact
from abi.robot.bodies.link_solids import link_solids as solids_of
from abi.robot.bodies.solid_contact import SolidPose, compile_kernels, touch
from abi.robot.kinematics.chain import Chain

_POSES, _AT_ENDS = 96, 2
"""Random poses, and those at each end of each coordinate's range."""


def always_touch(chain: Chain, first: str, second: str) -> bool:
    """Check whether the shapes of two links touch in each of some random poses, also at limits.

    What is found is kept from one start to the next.

    Args:
        chain: the joints that move.
        first: name of a link.
        second: name of another.
    """
    low, high = chain.usual_range().T
    positions = np.random.default_rng(1).uniform(low, high, (_POSES, len(low)))
    # links that part at the end of a range part where few random poses are
    for column, ends in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
        at_ends = np.random.default_rng(2).uniform(low, high, (2 * _AT_ENDS, len(low)))
        at_ends[:, column] = np.repeat(ends, _AT_ENDS)
        positions = np.concatenate([positions, at_ends])
    poses = chain.poses(positions)
    (turns, origins), (others, places) = (_placed(chain, one, poses) for one in (first, second))
    back = turns.swapaxes(1, 2)
    turned, moved = back @ others, (back @ (places - origins)[..., None])[..., 0]
    one, other = (chain.robot.links[name] for name in (first, second))
    shapes = (*one.shapes, *other.shapes)
    code = (__file__, solid_contact.__file__, link_solids.__file__)
    key = body_store.key_of(shapes, code)
    for array in (turned, moved):
        key = hashlib.sha256(key.encode() + np.round(array, 9).tobytes()).hexdigest()
    kept = body_store.find(key)
    if kept is None:
        compile_kernels()
        both = solids_of(one, 1.0), solids_of(other, 1.0)
        beside = (SolidPose(turn, place) for turn, place in zip(turned, moved, strict=True))
        kept = [np.array([float(all(touch(*both, pose) for pose in beside))])]
        body_store.keep(key, kept)
    return bool(kept[0][0])


def _placed(chain: Chain, link: str, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Turns (k, 3, 3) and origins (k, 3) of a link where joints have poses (k, m, 3, 4), world."""
    carried = next(one for one in chain.carried if one.link == link)
    turn, origin = carried.pose[:3, :3], carried.pose[:3, 3]
    if carried.frame < 0:
        return np.broadcast_to(turn, (len(poses), 3, 3)), np.broadcast_to(origin, (len(poses), 3))
    frames = poses[:, carried.frame]
    return frames[:, :, :3] @ turn, frames[:, :, :3] @ origin + frames[:, :, 3]

"""Links that touch by their given shapes, not just by the bodies that contain them, in any pose."""

from __future__ import annotations

import hashlib
from dataclasses import replace

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, read_only
from abi.robot.bodies import body_store, link_poses, link_solids, solid_contact
from abi.robot.bodies.link_poses import relative_poses
from abi.robot.bodies.link_solids import link_solids as solids_of
from abi.robot.bodies.solid_contact import compile_kernels, touch
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.link import Link
from abi.robot.urdf.robot import joints_between

_POSES, _AT_ENDS = 96, 2
"""Random poses, and those at each end of each coordinate's range."""


def always_touch(chain: Chain, first: str, second: str) -> bool:
    """Check whether the shapes of two links touch in each of some random poses, also at limits.

    A link without shapes touches nothing. What is found is kept from one start to the next.

    Args:
        chain: the joints that move.
        first: name of a link.
        second: name of another.
    """
    one, other = (chain.robot.links[name] for name in (first, second))
    if not one.shapes or not other.shapes:
        return False
    chain = with_held(chain, first, second)
    low, high = chain.usual_range().T
    positions = np.random.default_rng(1).uniform(low, high, (_POSES, len(low)))
    # links that part at the end of a range part where few random poses are
    for column, ends in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
        at_ends = np.random.default_rng(2).uniform(low, high, (2 * _AT_ENDS, len(low)))
        at_ends[:, column] = np.repeat(ends, _AT_ENDS)
        positions = np.concatenate([positions, at_ends])
    return touch_in_all(one, other, *relative_poses(chain, first, second, positions))


def with_held(chain: Chain, first: str, second: str) -> Chain:
    """A chain, or one in which the joints that it holds between two links move, too."""
    between = {joint.coordinate for joint in joints_between(chain.robot, first, second)}
    names = tuple(one for one in sorted(between) if one in chain.held)
    if not names:
        return chain
    free = {joint.name for joint in chain.robot.joints if joint.follows is None}
    held = {name: at for name, at in chain.held.items() if name in free and name not in names}
    moved = Chain.moved_by(chain.robot, (*chain.names, *names), held=held)
    # where a motion passes limits, those of its chain are wider
    limits = np.concatenate([chain.limits, moved.limits[len(chain.names) :]])
    return replace(moved, limits=read_only(limits))


def touch_in_all(one: Link, other: Link, turned: FloatArray, moved: FloatArray) -> bool:
    """Check whether the shapes of two links touch in all of some poses; what is found is kept.

    Args:
        one: a link.
        other: another.
        turned: its rotations in the frame of the first, (k, 3, 3).
        moved: its origins there, (k, 3), [m].
    """
    turned = arguments.numbers("turned", turned, (-1, 3, 3))
    moved = arguments.numbers("moved", moved, (len(turned), 3))
    shapes = (*one.shapes, *other.shapes)
    code = (__file__, link_poses.__file__, solid_contact.__file__, link_solids.__file__)
    key = f"{body_store.key_of(shapes, code)} {len(one.shapes)}"
    for array in (turned, moved):
        key = hashlib.sha256(key.encode() + np.round(array, 9).tobytes()).hexdigest()
    kept = body_store.find(key)
    if kept is None:
        compile_kernels()
        both = solids_of(one, 1.0), solids_of(other, 1.0)
        beside = zip(turned, moved, strict=True)
        kept = [np.array([float(all(touch(*both, *pose) for pose in beside))])]
        body_store.keep(key, kept)
    return bool(kept[0][0])

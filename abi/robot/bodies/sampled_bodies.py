"""Bodies of a chain in random poses: which of them overlap."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abi import arguments
from abi.arrays import BoolArray, FloatArray, read_only
from abi.robot.bodies.chain_capsules import hulls_of, segment_distances
from abi.robot.bodies.hull_kernels import hull_distances
from abi.robot.bodies.link_bodies import Body
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.chain_kernels import POSE


def sampled_poses(chain: Chain, count: int) -> FloatArray:
    """Random poses of a chain, which are the same at every call.

    Returns:
        Those of its frames, as the kernels have them, flat (12 (m + 1) k,), [m].
    """
    low, high = chain.usual_range().T
    return chain.packed_poses(np.random.default_rng(0).uniform(low, high, (count, len(low))))


def near_pairs(
    capsules: Sequence[Body], ends: FloatArray, pairs: Sequence[tuple[int, int]]
) -> BoolArray:
    """Check which capsules of each pair overlap in each of k poses, (k, p).

    Args:
        capsules: the bodies.
        ends: of their capsules in these poses, (k, c, 2, 3), [m].
        pairs: numbers of two bodies each.
    """
    radii = [capsules[i].radius + capsules[j].radius for i, j in pairs]
    gaps = [segment_distances(ends[:, i], ends[:, j]) for i, j in pairs]
    return np.asarray(np.stack(gaps, axis=1) <= radii)


def overlapping_pairs(
    chain: Chain,
    capsules: Sequence[Body],
    poses: FloatArray,
    pairs: Sequence[tuple[int, int]],
    asked: BoolArray,
) -> BoolArray:
    """Check which bodies of each pair overlap, in the poses in which it is asked, (k, p).

    Args:
        chain: the chain.
        capsules: its bodies.
        poses: of its frames, as :func:`sampled_poses` gives them.
        pairs: numbers of two bodies each.
        asked: whether a pair is asked about in a pose, (k, p).

    Raises:
        ArgumentError: there are no such pairs, or flags are missing.
    """
    listed = np.array(pairs, dtype=np.int32).reshape(-1, 2)
    each = arguments.ids("pairs", listed, (-1, 2), len(capsules))
    count = len(poses) // (POSE * (len(chain.joints) + 1))
    asked = arguments.flags("asked", asked, (count, len(each)))
    bodies = hulls_of(chain, capsules, 1.0)._replace(pairs=read_only(each.reshape(-1)))
    rows = np.argwhere(asked).astype(np.int32)
    distances, found = np.empty(len(rows)), np.zeros(asked.shape, dtype=np.bool_)
    hull_distances(bodies, poses, rows.reshape(-1), 0.0, 0, distances)
    found[tuple(rows.T)] = distances <= 0
    return found

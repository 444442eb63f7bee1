"""Bodies of a chain in random poses: which of them overlap."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np

from abi import arguments
from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.robot.bodies.chain_capsules import hulls_of, place, segment_distances
from abi.robot.bodies.hull_kernels import hull_distances
from abi.robot.bodies.link_bodies import Body
from abi.robot.kinematics.chain import Chain


class SampledBodies(NamedTuple):
    """Bodies of a chain in random poses.

    Attributes:
        chain: the chain.
        capsules: its bodies.
        poses: of its frames in k poses, as the kernels have them, flat (12 (m + 1) k,), [m].
        ends: of the capsules there, (k, c, 2, 3), [m].
    """

    chain: Chain
    capsules: tuple[Body, ...]
    poses: FloatArray
    ends: FloatArray

    @classmethod
    def of(cls, chain: Chain, capsules: tuple[Body, ...], count: int) -> Self:
        """Bodies in ``count`` poses, which are the same at every call."""
        low, high = chain.usual_range().T
        positions = np.random.default_rng(0).uniform(low, high, (count, len(low)))
        poses = chain.packed_poses(positions)
        return cls(chain, capsules, poses, place(capsules, chain.unpacked(poses)))

    def near(self, pairs: Sequence[tuple[int, int]]) -> BoolArray:
        """Check which capsules of each pair overlap in each pose, (k, p)."""
        radii = [self.capsules[i].radius + self.capsules[j].radius for i, j in pairs]
        gaps = [segment_distances(self.ends[:, i], self.ends[:, j]) for i, j in pairs]
        return np.asarray(np.stack(gaps, axis=1) <= radii)

    def overlap(self, pairs: Sequence[tuple[int, int]], asked: BoolArray) -> BoolArray:
        """Check which bodies of each pair overlap, in the poses in which it is asked, (k, p).

        Raises:
            ArgumentError: there are no such pairs, or flags are missing.
        """
        listed = np.array(pairs, dtype=np.int32).reshape(-1, 2)
        each = arguments.ids("pairs", listed, (-1, 2), len(self.capsules))
        asked = arguments.flags("asked", asked, (len(self.ends), len(each)))
        found = np.zeros(asked.shape, dtype=np.bool_)
        poses, numbers = (one.astype(np.int32) for one in np.nonzero(asked))
        found[poses, numbers] = self._distances(each, poses, numbers) <= 0
        return found

    def _distances(self, pairs: IntArray, poses: IntArray, numbers: IntArray) -> FloatArray:
        """Distances (m,) of bodies in poses, each by its number and that of the pair, [m]."""
        bodies = hulls_of(self.chain, self.capsules, 1.0)._replace(
            pairs=read_only(pairs.reshape(-1))
        )
        asked = np.stack([poses, numbers], axis=1).astype(np.int32)
        distances = np.empty(len(asked))
        hull_distances(bodies, self.poses, asked.reshape(-1), 0.0, 0, distances)
        return distances

"""Bounds of a signed distance from its values on a coarse grid, for thousands of points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from abi.arrays import FloatArray, IntArray, read_only

_NODES = 30_000
_BORDER = 0.1
"""Grid around the surface on each side, as a part of its longest side."""


@dataclass(frozen=True, eq=False)
class DistanceGrid:
    """A signed distance s at the nodes of a grid around a surface.

    s is 1-Lipschitz, so between its value at any node g and at a point x

        s(g) - |x - g| <= s(x) <= s(g) + |x - g|.

    Attributes:
        low: (3,) first node.
        step: distance between neighbouring nodes, the same along each axis.
        values: (a, b, c) signed distances.
        box: (2, 3) bounding box of the surface; outside it s is at least the distance to it.
        slack: bound of the error of the values.
    """

    low: FloatArray
    step: float
    values: FloatArray
    box: FloatArray
    slack: float

    @classmethod
    def of(
        cls, vertices: FloatArray, signed_distance: Callable[[FloatArray], FloatArray], error: float
    ) -> DistanceGrid:
        """Sample a distance, off by up to ``error``, around the box of the vertices (n, 3)."""
        box = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
        border = _BORDER * float(np.ptp(box, axis=0).max())
        size = np.ptp(box, axis=0) + 2 * border
        step = float(np.prod(size) / _NODES) ** (1 / 3)
        counts = np.ceil(size / step).astype(int) + 1
        low = box.mean(axis=0) - (counts - 1) * step / 2
        nodes = np.indices(tuple(counts)).reshape(3, -1).T * step + low
        values = signed_distance(nodes).reshape(tuple(counts))
        return cls(
            read_only(low), step, read_only(values), read_only(box), error + 1e-12 * size.max()
        )

    def bounds(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bounds (n,) of the signed distance at points (n, 3)."""
        last = np.array(self.values.shape) - 1
        cell = (points - self.low) / self.step
        corner = np.clip(cell.astype(np.int32), 0, last - 1)
        lower = np.sqrt(
            (np.maximum(np.maximum(self.box[0] - points, points - self.box[1]), 0.0) ** 2).sum(
                axis=1
            )
        )
        lower = np.where(lower > 0, lower, -np.inf)
        upper = np.full(len(points), np.inf)
        for offset in np.ndindex(2, 2, 2):
            node: IntArray = corner + np.array(offset, dtype=np.int32)
            distance = self.step * np.sqrt(((cell - node) ** 2).sum(axis=1))
            value = self.values[tuple(node.T)]
            np.maximum(lower, value - distance, out=lower)
            np.minimum(upper, value + distance, out=upper)
        return lower - self.slack, upper + self.slack

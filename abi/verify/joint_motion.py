"""A motion of joints in exact numbers, and what a plane separates all along a piece of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from abi.verify.certificate import CertifiedPlane
from abi.verify.exact.chain import ExactChain
from abi.verify.exact.frame import BITS, ONE, Exact, ExactFrame, wholes
from abi.verify.exact.solids import MovedHull, Vec3, times_length
from abi.verify.exact_path import ExactPath, positions_at, rows_around
from abi.verify.fault import Fault


@dataclass(frozen=True, eq=False)
class JointMotion:
    """Joints on their path, with cached poses and displacements, and levers of the hulls.

    The limits of the chain hold the whole motion, and whoever asks keeps the hulls.
    """

    chain: ExactChain
    path: ExactPath
    frames: dict[Fraction, list[ExactFrame]] = field(default_factory=dict)
    ways: dict[tuple[Fraction, Fraction, Fraction], list[Fraction]] = field(default_factory=dict)
    levers: dict[tuple[int, int], list[Fraction]] = field(default_factory=dict)
    wholes: dict[int, Exact] = field(default_factory=dict)

    def least(self, hull: MovedHull, plane: CertifiedPlane) -> Fraction:
        """Lower bound of a plane's product with a hull all along its piece.

        Raises:
            Fault: the piece is not on the motion.
        """
        frames, ways = self._near(plane)
        way = self._way(hull, -1, ways) + hull.radius
        return self.products(frames, hull, plane.normal)[0] - times_length(way, plane.normal)

    def apart(self, first: MovedHull, second: MovedHull, plane: CertifiedPlane) -> Fraction:
        """Lower bound of a plane's product with the second hull, which it keeps from the first.

        Raises:
            Fault: it does not all along its piece, or that is not on the motion.
        """
        frames, ways = self._near(plane)
        _, highest = self.products(frames, first, plane.normal)
        least, _ = self.products(frames, second, plane.normal)
        common = self.chain.meeting(first.frame, second.frame)
        way = self._way(first, common, ways) + self._way(second, common, ways)
        way += first.radius + second.radius
        if least - highest <= times_length(way, plane.normal):
            raise Fault(f"the piece from {float(plane.start):g} is not separated")
        return least

    def products(
        self, frames: list[ExactFrame], hull: MovedHull, normal: Vec3
    ) -> tuple[Fraction, Fraction]:
        """Bounds of the products of a direction with a hull's points at a pose.

        The direction is turned into the hull's frame, so that each point takes one product.
        """
        if id(hull) not in self.wholes:
            self.wholes[id(hull)] = wholes(np.array(hull.points, dtype=object))
        points = self.wholes[id(hull)]
        n = wholes(np.array(normal, dtype=object))
        size, length = int(abs(points).max()) + 1, int(abs(n).max()) + 1
        if hull.frame < 0:
            turned, shift, slack = n, 0, 0
        else:
            turn, origin, turn_error, origin_error = frames[hull.frame]
            turned = (turn.T @ n) >> BITS
            shift = int((origin @ n) >> BITS)
            # each entry of the turned direction is wrong by the rotation's error and by rounding
            error = 3 * (length * turn_error // ONE + 1) + 6 + 1
            far = int(abs(origin).max()) + 1
            slack = 3 * (size * error // ONE + 1) + 6
            slack += 3 * ((length * origin_error + far) // ONE + 1) + 6
        products = (points @ turned) >> BITS
        slack += 3 * (size + length) // ONE + 9  # rounding of the points and of the direction
        low, high = int(products.min()) + shift, int(products.max()) + shift
        return Fraction(low - slack, ONE), Fraction(high + 1 + slack, ONE)

    def _near(self, plane: CertifiedPlane) -> tuple[list[ExactFrame], list[Fraction]]:
        """Frames at the pose of a plane, and how far each coordinate gets from it."""
        start, end, at = plane.start, plane.end, plane.at
        if not 0 <= start <= at <= end <= len(self.path):
            raise Fault(f"a piece from {float(start):g} is not on the motion")
        if at not in self.frames:
            self.frames[at] = self.chain.place(positions_at(self.path, at))
        key = start, end, at
        if key not in self.ways:
            here = positions_at(self.path, at)
            columns = zip(*rows_around(self.path, start, end), strict=True)
            self.ways[key] = [
                max(max(column) - middle, middle - min(column))
                for column, middle in zip(columns, here, strict=True)
            ]
        return self.frames[at], self.ways[key]

    def _way(self, hull: MovedHull, behind: int, ways: list[Fraction]) -> Fraction:
        """Bound of the displacement of a hull's points relative to the frame ``behind``, [unit]."""
        key = id(hull), behind
        if key not in self.levers:
            self.levers[key] = self.chain.levers(hull.points, hull.frame, behind)
        pairs = zip(self.levers[key], ways, strict=True)
        return sum((lever * way for lever, way in pairs), Fraction(0))

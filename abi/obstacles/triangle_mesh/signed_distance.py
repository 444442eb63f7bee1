"""Signed distances to a surface: of points by VTK, of segments by a tree, bounds by a grid.

Inside is where the surface winds around a point (Jacobson, Kavan and Sorkine-Hornung, Robust
inside-outside segmentation using generalized winding numbers, 2013). Around a closed surface that
number is whole, so an approximation decides. Points and distances are in the coordinates of the
surface's file.
"""

from __future__ import annotations

from functools import cached_property, lru_cache

import numpy as np

from abi.arrays import BoolArray, FloatArray
from abi.obstacles.triangle_mesh import winding_kernels
from abi.obstacles.triangle_mesh.bvh import Dipoles, TriangleTree, build_tree, dipoles
from abi.obstacles.triangle_mesh.closest_points import ClosestPoints
from abi.obstacles.triangle_mesh.distance_grid import DistanceGrid
from abi.obstacles.triangle_mesh.segment_kernels import segment_distances
from abi.obstacles.triangle_mesh.surface import Surface

_DOUBT = 1e-14
"""Part of the surface's size: nearer points may be on either side, by rounding."""

_ROUNDING = 1e-8
"""Part of a segment's length: error of its distance to a nearly parallel edge."""

_SAMPLES = 32
"""Parts into which a segment that enters a solid is cut to bound its depth."""


class SurfaceDistance:
    """Signed distance of points and segments to one surface; tables are made at their first use."""

    def __init__(self, surface: Surface) -> None:
        # around the origin, where coordinates have the most digits
        self._centre = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
        self._vertices = surface.vertices - self._centre
        self._faces = surface.faces
        self._extent = surface.extent
        self._closed = surface.closed

    def prepare(self) -> None:
        """Build the trees and the grid, and compile the kernels."""
        origin = np.zeros((1, 3))
        self.grid.bounds(origin)
        self.segment_distance(origin, origin)

    @cached_property
    def grid(self) -> DistanceGrid:
        """Signed distances around the surface."""
        return DistanceGrid.of(self._vertices, self._signed_distance, 2 * self.closest_points.error)

    @cached_property
    def closest_points(self) -> ClosestPoints:
        """The triangles, for distances of points."""
        return ClosestPoints(self._vertices, self._faces)

    @cached_property
    def tree(self) -> TriangleTree:
        """The triangles, for distances of segments."""
        return build_tree(self._vertices[self._faces])

    @cached_property
    def dipoles(self) -> Dipoles:
        """The tree's far field, for winding numbers."""
        return dipoles(self.tree)

    def signed_distance(self, points: FloatArray) -> FloatArray:
        """Signed distance (n,) of points (n, 3); nowhere negative around an open surface."""
        return self._signed_distance(points - self._centre)

    def distance_bounds(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bounds (n,) of the signed distance, by the grid."""
        return self.grid.bounds(points - self._centre)

    def within(self, points: FloatArray, margin: float) -> BoolArray:
        """Mask (n,) of the points (n, 3) with a signed distance under ``margin``.

        The grid decides most of them.
        """
        x = points - self._centre
        lower, upper = self.grid.bounds(x)
        within: BoolArray = upper < margin
        undecided = np.flatnonzero(~within & (lower < margin))
        within[undecided] = self._signed_distance(x[undecided]) < margin
        return within

    def gradient(self, points: FloatArray) -> FloatArray:
        """Unit vectors (n, 3) away from the closest point, towards it inside a solid.

        On the surface itself they are along the normal of a triangle there.
        """
        x = points - self._centre
        offset, triangle = self.closest_points.offsets(x)
        distance = np.linalg.norm(offset, axis=1)
        a, b, c = self._vertices[self._faces[triangle]].transpose(1, 0, 2)
        touching = distance <= 1e-12 * self._extent
        offset = np.where(touching[:, None], np.cross(b - a, c - a), offset)
        offset[~touching] *= np.where(self._inside(x, distance), -1.0, 1.0)[~touching, None]
        return np.asarray(offset / np.linalg.norm(offset, axis=1)[:, None])

    def segment_distance(self, p: FloatArray, q: FloatArray) -> FloatArray:
        """Least signed distance (n,) along segments; a lower bound where it is negative."""
        a, b = p - self._centre, q - self._centre
        distance = self._to_surface(a, b, np.zeros(len(a)), np.full(len(a), np.inf))
        if self._closed:
            rows = np.flatnonzero(self._inside(a, distance) | (distance == 0))
            distance[rows] = self._depths(a[rows], b[rows])
        return distance

    def blocks(self, p: FloatArray, q: FloatArray, margins: FloatArray) -> BoolArray:
        """Mask (n,) of the segments that come nearer than ``margins`` (n,), or touch.

        At a point m of a segment at a distance h from its farther end, a signed distance between l
        and u keeps it clear where l - h is at least the margin, and blocks it where u is under it.
        Bounds at quarter points decide most segments; the others are measured whole.
        """
        a, b = p - self._centre, q - self._centre
        length = np.linalg.norm(b - a, axis=1)
        least = np.maximum(margins, 1e-12 * self._extent) + _ROUNDING * length
        stations = np.array([1, 3, 5, 7]) / 8
        between = a[:, None] + stations[:, None] * (b - a)[:, None]
        lower, upper = (v.reshape(-1, 4) for v in self.grid.bounds(between.reshape(-1, 3)))
        blocked: BoolArray = upper.min(axis=1) < margins
        clear = lower.min(axis=1) - length / 8 >= least
        rows = np.flatnonzero(~blocked & ~clear)
        limit = least[rows]
        near = self._to_surface(a[rows], b[rows], limit, limit) <= limit
        # a segment that nothing touches is inside or outside as a whole
        apart = rows[~near & ~(lower[rows] > 0).any(axis=1)]
        blocked[rows] = near
        blocked[apart] = self._signed_distance(a[apart]) < 0
        return blocked

    def _to_surface(
        self, a: FloatArray, b: FloatArray, enough: FloatArray, most: FloatArray
    ) -> FloatArray:
        """Distance (n,) of segments from a (n, 3) to b (n, 3), see ``segment_distances``."""
        a, b = np.ascontiguousarray(a), np.ascontiguousarray(b)
        return np.asarray(segment_distances(self.tree, a, b, enough, most))

    def _signed_distance(self, x: FloatArray) -> FloatArray:
        """Signed distance (n,), shortened by the bound of its error."""
        offset, _ = self.closest_points.offsets(x)
        distance: FloatArray = np.linalg.norm(offset, axis=1)
        error = self.closest_points.error
        if not self._closed:
            return np.asarray(np.maximum(distance - error, 0.0))
        return np.where(self._inside(x, distance - error), -distance, distance) - error

    def _inside(self, x: FloatArray, distance: FloatArray) -> BoolArray:
        """Mask (n,) of the points (n, 3) inside, given their distance (n,) or less.

        Points nearer than ``_DOUBT`` count as inside, which only shortens a distance.
        """
        if not self._closed:
            return np.zeros(len(x), dtype=np.bool_)
        tree, doubt = (self.tree, self.dipoles), _DOUBT * self._extent
        return np.asarray(winding_kernels.inside(*tree, np.ascontiguousarray(x), distance, doubt))

    def _depths(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """Lower bound (n,) of the signed distance along segments.

        Between two samples s and t at a distance l, the signed distance is at least (s + t - l) / 2
        and the least at most s and t: so the bound is off by at most 1/64 of the length.
        """
        share = np.linspace(0, 1, _SAMPLES + 1)[:, None]
        samples = a[:, None] + share * (b - a)[:, None]
        at = self._signed_distance(samples.reshape(-1, 3)).reshape(-1, _SAMPLES + 1)
        step = np.linalg.norm(b - a, axis=1) / _SAMPLES
        return np.asarray((at[:, :-1] + at[:, 1:]).min(axis=1) / 2 - step / 2)


@lru_cache(maxsize=16)
def surface_distance(surface: Surface) -> SurfaceDistance:
    """Signed distance to a surface; those of the last 16 surfaces are kept."""
    return SurfaceDistance(surface)

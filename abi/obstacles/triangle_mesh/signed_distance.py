"""Distances to a surface: of points by a library, of segments by a tree, and bounds for most.

Inside is where the surface winds around a point (Jacobson, Kavan and Sorkine-Hornung, Robust
inside-outside segmentation using generalized winding numbers, 2013). Around a closed surface that
number is whole, so an approximation decides. Points and distances are in the coordinates of the
surface's file.
"""

from __future__ import annotations

from functools import cached_property, lru_cache

import numpy as np

from abi.arrays import BoolArray, FloatArray
from abi.obstacles.triangle_mesh import winding_kernels as winding
from abi.obstacles.triangle_mesh.bvh import Dipoles, TriangleTree, build, dipoles
from abi.obstacles.triangle_mesh.closest_points import NearestPlaces
from abi.obstacles.triangle_mesh.distance_grid import DistanceGrid
from abi.obstacles.triangle_mesh.repair import Surface
from abi.obstacles.triangle_mesh.segment_kernels import segment_distances

_DOUBT = 1e-14
"""Nearer than this part of the surface's size rounding may hide the side of a point."""

_ROUNDING = 1e-8
"""Of a segment's length: what its distance to a nearly parallel edge can be off by."""

_SAMPLES = 32
"""Parts into which a segment that enters a solid is cut to bound its depth."""


class SurfaceDistance:
    """Signed distance of points and segments to one surface."""

    def __init__(self, surface: Surface) -> None:
        # around the origin, where coordinates have the most digits
        self._centre = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
        self._vertices = surface.vertices - self._centre
        self._faces = surface.faces
        self._extent = surface.extent
        self._closed = surface.closed

    def prepare(self) -> None:
        """Build the trees and the grid, and compile what measures."""
        at = np.zeros((1, 3))
        self.grid.bounds(at)
        self.along(at, at)

    @cached_property
    def grid(self) -> DistanceGrid:
        """Signed distances around the surface, sampled when first asked for."""
        return DistanceGrid.of(self._vertices, self._signed, 2 * self.places.error)

    @cached_property
    def places(self) -> NearestPlaces:
        """The triangles, for distances of points; sorted when first asked for."""
        return NearestPlaces(self._vertices, self._faces)

    @cached_property
    def tree(self) -> TriangleTree:
        """The triangles, for distances of segments; built when first asked for."""
        return build(self._vertices[self._faces])

    @cached_property
    def dipoles(self) -> Dipoles:
        """The tree's far field, for winding numbers; built when first asked for."""
        return dipoles(self.tree)

    def signed(self, points: FloatArray) -> FloatArray:
        """Signed distance (n,) of points (n, 3); nowhere negative around an open surface."""
        return self._signed(points - self._centre)

    def bounds(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """A bound from below and one from above (n,) of the signed distance, by the grid."""
        return self.grid.bounds(points - self._centre)

    def closer(self, points: FloatArray, margin: float) -> BoolArray:
        """Which points (n, 3) have a signed distance under ``margin``, (n,).

        The grid decides most of them.
        """
        x = points - self._centre
        lower, upper = self.grid.bounds(x)
        found: BoolArray = upper < margin
        open_ = np.flatnonzero(~found & (lower < margin))
        found[open_] = self._signed(x[open_]) < margin
        return found

    def outward(self, points: FloatArray) -> FloatArray:
        """Unit vectors (n, 3) away from the nearest place, towards it inside a solid.

        On the surface itself they are along the normal of a triangle there.
        """
        x = points - self._centre
        way, triangle = self.places.to(x)
        distance = np.linalg.norm(way, axis=1)
        a, b, c = self._vertices[self._faces[triangle]].transpose(1, 0, 2)
        touching = distance <= 1e-12 * self._extent
        way = np.where(touching[:, None], np.cross(b - a, c - a), way)
        way[~touching] *= np.where(self._inside(x, distance), -1.0, 1.0)[~touching, None]
        return np.asarray(way / np.linalg.norm(way, axis=1)[:, None])

    def along(self, p: FloatArray, q: FloatArray) -> FloatArray:
        """Least signed distance (n,) along segments; a bound from below where it is negative."""
        a, b = p - self._centre, q - self._centre
        found = self._to_surface(a, b, np.zeros(len(a)), np.full(len(a), np.inf))
        if self._closed:
            rows = np.flatnonzero(self._inside(a, found) | (found == 0))
            found[rows] = self._depths(a[rows], b[rows])
        return found

    def blocks(self, p: FloatArray, q: FloatArray, margins: FloatArray) -> BoolArray:
        """Which segments come nearer than ``margins`` (n,), or touch; (n,).

        At a point m of a segment with the way h to its farther end, a signed distance between l
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
        found = self._to_surface(a[rows], b[rows], limit, limit)
        near = found <= limit
        # a segment that nothing touches is inside or outside as a whole
        apart = rows[~near & ~(lower[rows] > 0).any(axis=1)]
        blocked[rows] = near
        blocked[apart] = self._signed(a[apart]) < 0
        return blocked

    def _to_surface(
        self, a: FloatArray, b: FloatArray, enough: FloatArray, most: FloatArray
    ) -> FloatArray:
        """Distance (n,) of segments from a (n, 3) to b (n, 3), see ``segment_distances``."""
        a, b = np.ascontiguousarray(a), np.ascontiguousarray(b)
        return np.asarray(segment_distances(self.tree, a, b, enough, most))

    def _signed(self, x: FloatArray) -> FloatArray:
        """Signed distance (n,), shortened by what the library may be off by."""
        way, _ = self.places.to(x)
        distance: FloatArray = np.linalg.norm(way, axis=1)
        if not self._closed:
            return np.asarray(np.maximum(distance - self.places.error, 0.0))
        inside = self._inside(x, distance - self.places.error)
        return np.where(inside, -distance, distance) - self.places.error

    def _inside(self, x: FloatArray, distance: FloatArray) -> BoolArray:
        """Which points (n, 3) the surface winds around, given their distance (n,) or less.

        What is ``_DOUBT`` near counts as inside, which only shortens a distance.
        """
        if not self._closed:
            return np.zeros(len(x), dtype=np.bool_)
        inside = winding.inside(
            self.tree,
            self.dipoles,
            np.ascontiguousarray(x),
            distance,
            _DOUBT * self._extent,
        )
        return np.asarray(inside)

    def _depths(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """A bound from below (n,) of the signed distance along segments.

        Between two samples s and t at a distance l, the signed distance is at least (s + t - l) / 2
        and the least at most s and t: so the bound is off by at most 1/64 of the length.
        """
        share = np.linspace(0, 1, _SAMPLES + 1)[:, None]
        samples = a[:, None] + share * (b - a)[:, None]
        at = self._signed(samples.reshape(-1, 3)).reshape(-1, _SAMPLES + 1)
        step = np.linalg.norm(b - a, axis=1) / _SAMPLES
        bound = (at[:, :-1] + at[:, 1:]).min(axis=1) / 2 - step / 2
        return np.asarray(bound)


@lru_cache(maxsize=16)
def distances(surface: Surface) -> SurfaceDistance:
    """The distances of a surface; those of the last 16 surfaces are kept."""
    return SurfaceDistance(surface)

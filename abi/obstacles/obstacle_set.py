"""The obstacles of a scene as one set, whatever their shapes.

Kernels measure primitives, and a triangle mesh is measured by its own tree; the nearest counts.
Both are in a tree of their bounds, so that a query looks only at those near it. Only code that
relies on convexity asks for ``primitives`` and ``meshes``. Lengths are in the scene's [unit],
points in the world frame.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Self

import numpy as np
from pydantic import Field

from abi import arguments
from abi.arrays import BoolArray, FloatArray, IntArray, ShortRepr, flat, read_only
from abi.errors import ArgumentError
from abi.obstacles import obstacle_set_kernels as kernels
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set_kernels import polyline_distances, polyline_distances_near_meshes
from abi.obstacles.packing import pack
from abi.obstacles.per_shape import per_shape
from abi.obstacles.primitive_kernels import BOUNDS, CORE, WIDTH
from abi.obstacles.primitives import Box, Primitive
from abi.obstacles.surface_set import surface_set
from abi.obstacles.triangle_mesh.surface_kernels import WIDER, SurfaceSet

Obstacle = Annotated[Primitive | MeshShape, Field(discriminator="shape")]
Obstacles = tuple[Obstacle, ...]

_TOUCH = 1e-9
"""Least margin to a mesh's bounds, [unit], as a touching point may lie on them."""


@dataclass(frozen=True, eq=False, repr=False)
class ObstacleSet(ShortRepr):
    """Obstacles and their distances; tables are made at their first use.

    Two sets are equal only if they are the same object: comparing obstacles one by one would cost
    more than most computations with them, so a planner makes one set for equal scenes.

    Attributes:
        obstacles: as the scene has them; an index into them is an obstacle's number.
    """

    obstacles: Obstacles = ()

    def __len__(self) -> int:
        return len(self.obstacles)

    def __iter__(self) -> Iterator[Obstacle]:
        return iter(self.obstacles)

    def __getitem__(self, number: int) -> Obstacle:
        return self.obstacles[number]

    @cached_property
    def primitives(self) -> tuple[Primitive, ...]:
        """The convex obstacles, (p,)."""
        return tuple(shape for shape in self.obstacles if not isinstance(shape, MeshShape))

    @cached_property
    def meshes(self) -> tuple[MeshShape, ...]:
        """The triangle meshes, (m,)."""
        return tuple(shape for shape in self.obstacles if isinstance(shape, MeshShape))

    @cached_property
    def primitive_numbers(self) -> IntArray:
        """Numbers of the primitives among the obstacles, ascending, (p,)."""
        return self._numbers(convex=True)

    @cached_property
    def mesh_numbers(self) -> IntArray:
        """Numbers of the meshes among the obstacles, ascending, (m,)."""
        return self._numbers(convex=False)

    @cached_property
    def rows(self) -> IntArray:
        """Numbers of the obstacles in the kernels' order, primitives first, (k,)."""
        return read_only(np.concatenate([self.primitive_numbers, self.mesh_numbers]))

    @property
    def all_convex(self) -> bool:
        """Whether there are no meshes: then every signed distance is a convex function."""
        return not self.meshes

    @cached_property
    def packed(self) -> FloatArray:
        """The primitives in the format of the kernels, flat (p ``WIDTH``,)."""
        return pack(self.primitives)

    @cached_property
    def surfaces(self) -> SurfaceSet:
        """The meshes in the format of the kernels."""
        return surface_set(self.meshes, self.packed_mesh_boxes)

    @cached_property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Low and high corners (k, 3) of the obstacles' axis-parallel boxes, [unit], world."""
        corners = np.empty((len(self.obstacles), 2, 3))
        of_primitives = self.packed.reshape(-1, WIDTH)[:, BOUNDS : BOUNDS + 6]
        corners[self.primitive_numbers] = of_primitives.reshape(-1, 2, 3)
        for number, mesh in zip(self.mesh_numbers, self.meshes, strict=True):
            corners[number] = mesh.bounds()
        return read_only(corners[:, 0].copy()), read_only(corners[:, 1].copy())

    @cached_property
    def least_depth(self) -> float:
        """Depth of the thinnest primitive's centre in it, [unit]; inf without any."""
        cores = self.packed.reshape(-1, WIDTH)[:, CORE : CORE + 4]
        return float((cores[:, :3].min(axis=1) + cores[:, 3]).min(initial=math.inf))

    @cached_property
    def boxed(self) -> Self:
        """The set with each mesh replaced by its bounding box; the set itself without meshes."""
        if self.all_convex:
            return self
        boxed = list(self.obstacles)
        for number, box in zip(self.mesh_numbers.tolist(), self._mesh_boxes, strict=True):
            boxed[number] = box
        return type(self)(tuple(boxed))

    @cached_property
    def meshes_alone(self) -> Self:
        """The set of the meshes, for work that a kernel has already done for the primitives."""
        return type(self)(self.meshes)

    def nearest(self, points: FloatArray) -> tuple[FloatArray, IntArray]:
        """Least signed distance (n,) of points (n, 3), [unit], and number (n,) of that obstacle.

        The first obstacle counts on a tie; without obstacles the distance is inf, the number -1.
        """
        points = arguments.points("points", points)
        distance, row = self._from_primitives(points)
        number = np.full(len(points), -1, dtype=np.int32)
        of_primitive = row >= 0
        number[of_primitive] = self.primitive_numbers[row[of_primitive]]
        for k, mesh, rows in self.near_meshes(points, points, distance):
            to_mesh = mesh.signed_distance(points[rows])
            before = distance[rows]
            nearer = (to_mesh < before) | ((to_mesh == before) & (k < number[rows]))
            distance[rows[nearer]], number[rows[nearer]] = to_mesh[nearer], k
        return distance, number

    def signed_distance(self, points: FloatArray, enough: float = math.inf) -> FloatArray:
        """Least signed distance (n,) of points (n, 3), [unit]; inf without obstacles.

        If the true value is at least ``enough``, the result may be any number from there on.
        """
        points = arguments.points("points", points)
        enough = arguments.number("enough", enough, infinite=True)
        distance, _ = self._from_primitives(points)
        for _, mesh, rows in self.near_meshes(points, points, np.minimum(distance, enough)):
            distance[rows] = np.minimum(distance[rows], mesh.signed_distance(points[rows]))
        return distance

    def distances_up_to(self, limit: float, points: FloatArray) -> FloatArray:
        """Signed distance (n, k) of points (n, 3) to each obstacle, [unit].

        Exact below ``limit``; larger ones may be any distance from there on.
        """
        points = arguments.points("points", points)
        limit = arguments.number("limit", limit, infinite=True)
        distances = np.empty((len(points), len(self.obstacles)))
        of_primitives = np.empty(len(points) * len(self.primitives))
        kernels.signed_distances(flat(points), self.packed, of_primitives)
        distances[:, self.primitive_numbers] = of_primitives.reshape(
            len(points), len(self.primitives)
        )
        distances[:, self.mesh_numbers] = np.inf
        limits = np.full(len(points), limit)
        for number, mesh, rows in self.near_meshes(points, points, limits):
            distances[rows, number] = mesh.signed_distance(points[rows])
        return distances

    def signed_distance_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Least signed distance (n,) of points (n, 3), [unit], and its gradient (n, 3), world.

        The gradient is a unit subgradient of a primitive's distance; without obstacles the distance
        is inf, the gradient 0.
        """
        points = arguments.points("points", points)
        distance, row = self._from_primitives(points)
        gradient = np.zeros((len(points), 3))
        kernels.gradients(flat(points), self.packed, row, gradient.ravel())
        for _, mesh, rows in self.near_meshes(points, points, distance):
            to_mesh, of_mesh = mesh.signed_distance_gradient(points[rows])
            is_nearer = to_mesh < distance[rows]
            nearer = rows[is_nearer]
            distance[nearer] = to_mesh[is_nearer]
            gradient[nearer] = of_mesh[is_nearer]
        return distance, gradient

    def blocked(
        self, starts: FloatArray, ends: FloatArray, margin: float | FloatArray
    ) -> BoolArray:
        """Mask (n,) of the segments that come nearer to an obstacle than ``margin``.

        Args:
            starts: first ends (n, 3), [unit], world.
            ends: second ends (n, 3), [unit], world.
            margin: [unit], one for all or one for each segment (n,).
        """
        starts = arguments.points("starts", starts)
        ends = arguments.numbers("ends", ends, starts.shape)
        margins = arguments.one_or_each("margin", margin, len(starts))
        blocked = np.zeros(len(starts), dtype=np.bool_)
        packed = flat(starts), flat(ends), flat(margins)
        if self.primitives:
            kernels.blocked_segments(*packed, self.packed, blocked)
        open_ = np.flatnonzero(~blocked)
        if not self.meshes or not len(open_):
            return blocked
        starts, ends, margins = starts[open_], ends[open_], margins[open_]
        # touching a surface blocks even without a margin
        for _, mesh, rows in self.near_meshes(starts, ends, np.maximum(margins, _TOUCH)):
            rows = rows[~blocked[open_[rows]]]
            blocked[open_[rows]] = mesh.blocks(starts[rows], ends[rows], margins[rows])
        return blocked

    def polyline_clearance(self, points: FloatArray) -> float:
        """Least signed distance of a polyline, [unit]; inf without obstacles.

        It is exact up to rounding, and a lower bound inside a closed mesh.

        Args:
            points: vertices (k, 3), k >= 1, [unit], world.
        """
        vertices = arguments.polyline("points", points)
        return float(self._of_polylines(vertices[None], math.inf)[0])

    def polyline_clearances(self, polylines: FloatArray, enough: float = math.inf) -> FloatArray:
        """Clearances (n,) of polylines of equally many vertices (n, k, 3), k >= 2, [unit].

        Except for the least of all, those of ``enough`` or more may be any number from there on.
        """
        polylines = arguments.numbers("polylines", polylines, (-1, -1, 3))
        enough = arguments.number("enough", enough, infinite=True)
        if polylines.shape[1] < 2:
            raise ArgumentError("vertices of each polyline", polylines.shape[1], "2 or more")
        return self._of_polylines(polylines, enough)

    def _of_polylines(self, polylines: FloatArray, enough: float) -> FloatArray:
        """Clearances (n,) of polylines (n, k, 3) that have been checked."""
        count, size, _ = polylines.shape
        clearances = np.empty(count)
        points, primitives = flat(polylines), self.packed
        if self.meshes:
            polyline_distances_near_meshes(
                points, size, primitives, self.surfaces, enough, clearances
            )
        else:
            polyline_distances(points, size, primitives, enough, clearances)
        return clearances

    def segment_clearances(self, points: FloatArray, enough: float = math.inf) -> FloatArray:
        """Clearances (k - 1,) of a polyline's segments, [unit].

        Args:
            points: vertices (k, 3), k >= 1, [unit], world; a single point counts as a segment.
            enough: as for :meth:`polyline_clearances`.
        """
        vertices = arguments.polyline("points", points)
        segments = np.stack([vertices[:-1], vertices[1:]], axis=1)
        return self.polyline_clearances(segments, enough)

    def near_meshes(
        self, starts: FloatArray, ends: FloatArray, limits: FloatArray
    ) -> Iterator[tuple[int, MeshShape, IntArray]]:
        """Meshes with the segments that may be nearer to them than a limit.

        Args:
            starts, ends: (n, 3), [unit], world.
            limits: (n,), [unit].

        Yields:
            Number of a mesh, the mesh, and rows (m,) of segments, m >= 1, ascending.
        """
        starts = arguments.points("starts", starts)
        ends = arguments.numbers("ends", ends, starts.shape)
        limits = arguments.numbers("limits", limits, starts.shape[:1], infinite=True)
        if not self.meshes:
            return
        if len(self.meshes) == 1 and np.isinf(limits).all():
            rows, boxes = np.arange(len(starts), dtype=np.int32), np.zeros(len(starts), np.int32)
        else:
            if np.isinf(limits).any():
                limits = np.minimum(limits, self.most_to_mesh(starts))
            segments = flat(starts), flat(ends), flat(limits * (1 + WIDER) + WIDER)
            rows, boxes = kernels.near_boxes(*segments, self.packed_mesh_boxes)
        if not len(boxes):
            return
        cuts = (np.flatnonzero(boxes[1:] != boxes[:-1]) + 1).tolist()
        for first, last in itertools.pairwise([0, *cuts, len(boxes)]):
            k = int(boxes[first])
            yield int(self.mesh_numbers[k]), self.meshes[k], rows[first:last]

    def most_to_mesh(self, points: FloatArray) -> FloatArray:
        """Upper bound (n,) of the distance of points (n, 3) to the nearest mesh, [unit]."""
        points = arguments.points("points", points)
        if not self.meshes:
            return np.full(len(points), np.inf)
        distance, row = np.empty(len(points)), np.empty(len(points), dtype=np.int32)
        kernels.nearest(flat(points), self.packed_mesh_boxes, distance, row)
        diagonals = np.array([math.hypot(*box.size) for box in self._mesh_boxes])
        return np.asarray(np.maximum(distance, 0) + diagonals[row])

    def _numbers(self, convex: bool) -> IntArray:
        chosen = [k for k, shape in enumerate(self.obstacles) if shape.convex == convex]
        return read_only(np.array(chosen, dtype=np.int32))

    @cached_property
    def _mesh_boxes(self) -> tuple[Box, ...]:
        """Bounding boxes of the meshes (m,)."""
        return tuple(_bounding_boxes(self.meshes))

    @cached_property
    def packed_mesh_boxes(self) -> FloatArray:
        """The meshes' bounding boxes as the kernels take primitives, flat (m ``WIDTH``,)."""
        return pack(self._mesh_boxes)

    def _from_primitives(self, points: FloatArray) -> tuple[FloatArray, IntArray]:
        """Least signed distance (n,) of points to a primitive, and that primitive's number (n,)."""
        distance, row = np.empty(len(points)), np.empty(len(points), dtype=np.int32)
        kernels.nearest(flat(points), self.packed, distance, row)
        return distance, row


NO_OBSTACLES = ObstacleSet()


@per_shape
def _bounding_boxes(mesh: MeshShape) -> Box:
    low, high = mesh.bounds()
    x, y, z = np.maximum(high - low, 1e-9).tolist()
    a, b, c = ((low + high) / 2).tolist()
    return Box(size=(x, y, z), position=(a, b, c))

"""Collision shapes that move as one, with their edges and corners, to be tested for contacts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy

from abi.arrays import FloatArray, read_only
from abi.obstacles.convex_shape import ConvexShape
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.pose import Quaternion
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from abi.obstacles.triangle_mesh.repair import clean
from abi.robot.urdf.link import Link, LinkShape

SIDES = 48
"""Corners on a cylinder's rim."""


@dataclass(frozen=True, eq=False)
class LinkSolids:
    """Shapes that move as one.

    Attributes:
        shapes: in their own frame, [unit].
    """

    shapes: tuple[Obstacle, ...]

    @cached_property
    def whole(self) -> ObstacleSet:
        """The shapes as one set."""
        return ObstacleSet(self.shapes)

    @cached_property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Low and high corner, (3,) each, of the box around all."""
        low, high = self.whole.bounds
        return read_only(low.min(axis=0)), read_only(high.max(axis=0))

    @cached_property
    def edges(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Ends (k, 3) and (k, 3) of all edges, and the radius of what each stands for, (k,)."""
        none = np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0)  # a link may have no shapes
        parts = [none, *map(_edges, self.shapes)]
        return tuple(read_only(np.concatenate(column)) for column in zip(*parts, strict=True))  # type: ignore[return-value]

    @cached_property
    def corners(self) -> FloatArray:
        """Ends of all edges that have no radius, once each, (k, 3)."""
        first, second, radii = self.edges
        sharp = radii == 0
        return read_only(np.unique(np.concatenate([first[sharp], second[sharp]]), axis=0))

    def lowest(self, turn: FloatArray, origin: FloatArray) -> float:
        """Height of the lowest point at a pose, [unit]; inf of no shapes.

        Args:
            turn: of the shapes' frame, (3, 3), world.
            origin: of that frame, (3,), [unit], world.
        """
        first, second, radii = self.edges
        ends = np.minimum(first @ turn[2], second @ turn[2])
        return float((ends - radii).min(initial=np.inf) + origin[2])

    @cached_property
    def bulge(self) -> float:
        """How far a cylinder is beyond the prism of its edges, at most, [unit]."""
        radii = [one.radius for one in self.shapes if isinstance(one, Cylinder)]
        return max(radii, default=0.0) * (1 - math.cos(math.pi / SIDES))

    @cached_property
    def anchors(self) -> FloatArray:
        """A vertex of each connected part, (k, 3): it stands for all where no surfaces cross.

        And the middle of what is no mesh: of two that coincide, all edges lie in the other's sides.
        """
        first, second, _ = self.edges
        points, numbers = np.unique(np.concatenate([first, second]), axis=0, return_inverse=True)
        pairs = numbers.reshape(2, -1)
        graph = scipy.sparse.coo_array((np.ones(pairs.shape[1]), pairs), (len(points),) * 2)
        _, parts = scipy.sparse.csgraph.connected_components(graph, directed=False)
        middles = [shape.position for shape in self.shapes if not isinstance(shape, MeshShape)]
        found = points[np.unique(parts, return_index=True)[1]]
        return read_only(np.concatenate([found, np.reshape(middles, (-1, 3))]))


@lru_cache(maxsize=256)
def link_solids(link: Link, scale: float) -> LinkSolids:
    """Collision shapes of a link in its frame, in units of which ``scale`` are one metre."""
    return LinkSolids(tuple(_obstacle(shape, scale) for shape in link.shapes))


def _obstacle(shape: LinkShape, scale: float) -> Obstacle:
    """A link's shape as an obstacle is, in the link's frame, [unit]."""
    x, y, z = (scale * shape.pose[:3, 3]).tolist()
    turn = scipy.spatial.transform.Rotation.from_matrix(shape.pose[:3, :3])
    qx, qy, qz, qw = turn.as_quat().tolist()
    place: tuple[float, float, float] = (x, y, z)
    wxyz: Quaternion = (qw, qx, qy, qz)
    a, b, c = (scale * size for size in shape.size)
    if shape.kind == "mesh":
        surface = clean(shape.vertices * scale, shape.faces)
        return MeshShape.of(surface, position=place, wxyz=wxyz)
    if shape.kind == "box":
        return Box(size=(a, b, c), position=place, wxyz=wxyz)
    if shape.kind == "sphere":
        return Sphere(radius=a, position=place)
    return Cylinder(radius=a, height=b, position=place, wxyz=wxyz)


def _edges(shape: Obstacle) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Both ends (k, 3) of a shape's edges, and the radius around each, (k,)."""
    if isinstance(shape, Sphere | Capsule):
        half = shape.height / 2 if isinstance(shape, Capsule) else 0.0
        axis = half * np.asarray(_axis(shape))
        centre = np.array(shape.position)
        return (centre - axis)[None], (centre + axis)[None], np.array([shape.radius])
    corners = shape.triangles(SIDES) if isinstance(shape, ConvexShape) else shape.triangles()
    pairs = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    pairs = np.unique(_ordered(pairs).reshape(-1, 6), axis=0).reshape(-1, 2, 3)
    return pairs[:, 0], pairs[:, 1], np.zeros(len(pairs))


def _axis(shape: Sphere | Capsule) -> FloatArray:
    """Direction of a shape's z axis in the world, (3,)."""
    w, x, y, z = shape.wxyz
    turn = scipy.spatial.transform.Rotation.from_quat((x, y, z, w))
    return np.asarray(turn.apply(np.array([0.0, 0.0, 1.0])))


def _ordered(pairs: FloatArray) -> FloatArray:
    """Pairs of points (k, 2, 3), each with the lesser point first: equal edges become equal."""
    first, second = pairs[:, 0], pairs[:, 1]
    differs = first != second
    axis = differs.argmax(axis=1)
    rows = np.arange(len(pairs))
    swap = first[rows, axis] > second[rows, axis]
    return np.where(swap[:, None, None], pairs[:, ::-1], pairs)

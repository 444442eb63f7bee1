"""Contacts of the exact shapes of a robot's links with obstacles, the floor and other links.

Two solids with edges meet where an edge of one enters the other, or where one is inside the other;
so the edges of both are tested against the surface of the other, and their corners are inside it. A
ball, or the axis of a capsule, is such an edge with a radius. A shape that is found to touch
touches indeed; contacts of a cylinder's rim shallower than that of 48 corners are not found.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from abi.arrays import FloatArray, read_only
from abi.certification.clearance_proof import MotionTask
from abi.obstacles.convex_shape import ConvexShape
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.pose import Quaternion
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from abi.obstacles.triangle_mesh.repair import clean
from abi.robot.urdf.robot import Link, LinkShape

_SIDES = 48
_ALONG = np.linspace(0, 1, 9)
"""Places along an edge that enters a solid at which its depth is measured, as shares of it."""


class ShapeContact(NamedTuple):
    """What two solids are to each other at a pose.

    Attributes:
        touches: whether they touch or overlap.
        depth: how far a corner or an edge is inside, at least, [unit]; 0 where they do not touch.
    """

    touches: bool
    depth: float


@dataclass(frozen=True, eq=False)
class LinkSolids:
    """LinkSolids that move as one.

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
        parts = [_edges(shape) for shape in self.shapes]
        return tuple(read_only(np.concatenate(column)) for column in zip(*parts, strict=True))  # type: ignore[return-value]

    @cached_property
    def corners(self) -> FloatArray:
        """Ends of all edges that have no radius, once each, (k, 3)."""
        first, second, radii = self.edges
        sharp = radii == 0
        return read_only(np.unique(np.concatenate([first[sharp], second[sharp]]), axis=0))


class SolidPose(NamedTuple):
    """Rotation (3, 3) and origin (3,), [unit]."""

    turn: FloatArray
    origin: FloatArray


UNMOVED = SolidPose(read_only(np.eye(3)), read_only(np.zeros(3)))


def distance(first: LinkSolids, second: LinkSolids, first_from_second: SolidPose) -> float:
    """Distance from the corners of each of two bodies to the other: at least their distance."""
    turn, origin = first_from_second
    there = first.whole.signed_distance(second.corners @ turn.T + origin)
    back = second.whole.signed_distance((first.corners - origin) @ turn)
    return float(min(there.min(initial=np.inf), back.min(initial=np.inf)))


def contact(first: LinkSolids, second: LinkSolids, first_from_second: SolidPose) -> ShapeContact:
    """Decide whether two bodies touch, and how deeply.

    Args:
        first: a body.
        second: another.
        first_from_second: pose of the second in the frame of the first.
    """
    turn, origin = first_from_second
    back = SolidPose(turn.T, -turn.T @ origin)
    touches, depth = False, 0.0
    for body, other, (r, t) in ((second, first, first_from_second), (first, second, back)):
        a, b, radii = body.edges
        a, b = a @ r.T + t, b @ r.T + t
        low, high = other.bounds
        beside = (np.minimum(a, b) - radii[:, None] > high) | (
            np.maximum(a, b) + radii[:, None] < low
        )
        near = ~beside.any(axis=1)
        entering = np.flatnonzero(near)[other.whole.blocked(a[near], b[near], radii[near])]
        touches |= len(entering) > 0
        corners = body.corners @ r.T + t
        corners = corners[((corners >= low) & (corners <= high)).all(axis=1)]
        along = a[entering] + _ALONG[:, None, None] * (b[entering] - a[entering])
        points = np.concatenate([corners, along.reshape(-1, 3)])
        if len(points):
            deep = -other.whole.signed_distance(points)
            deep[len(corners) :] += np.tile(radii[entering], len(_ALONG))
            depth = max(depth, float(deep.max()))
    return ShapeContact(touches or depth > 0, depth)


@lru_cache(maxsize=256)
def link_solids(link: Link, scale: float) -> LinkSolids:
    """Collision shapes of a link in its frame, in units of which ``scale`` are one metre."""
    return LinkSolids(tuple(_obstacle(shape, scale) for shape in link.shapes))


class ContactFinder:
    """Contacts of a motion's links at poses.

    Args:
        task: the motion, the bodies and what they keep clear of.
    """

    def __init__(self, task: MotionTask) -> None:
        self._task = task
        self._links = {one.link: one for one in task.bodies.chain.carried}
        self._obstacles = [LinkSolids((shape,)) for shape in task.obstacles]

    def at(self, parameter: float, link: str, other: int | str) -> ShapeContact:
        """ShapeContact at a parameter of a link with an obstacle, another link, or the floor.

        Args:
            parameter: of the motion.
            link: name of the link.
            other: number of the obstacle, name of the link, or ``floor``.
        """
        body, parts = self._solids(link), self._beside(parameter, link, other)
        if parts is None:
            low = self._height(parameter, link)
            return ShapeContact(low <= 0, max(-low, 0.0))
        return contact(parts[0], body, parts[1])

    def distance(self, parameter: float, link: str, other: int | str) -> float:
        """Distance at a parameter of a link's corners from something, and the other way, [unit].

        It is at least that of the shapes, and negative inside.
        """
        parts = self._beside(parameter, link, other)
        if parts is None:
            return self._height(parameter, link)
        return distance(parts[0], self._solids(link), parts[1])

    def _beside(
        self, parameter: float, link: str, other: int | str
    ) -> tuple[LinkSolids, SolidPose] | None:
        """What a link may touch, and the link's pose in the frame of that; None for the floor."""
        pose = self._pose(link, parameter)
        if isinstance(other, int):
            return self._obstacles[other], pose
        if other == "floor":
            return None
        base = self._pose(other, parameter)
        place = base.turn.T @ (pose.origin - base.origin)
        return self._solids(other), SolidPose(base.turn.T @ pose.turn, place)

    def _height(self, parameter: float, link: str) -> float:
        """Height of a link's lowest corner above the floor, [unit]."""
        turn, origin = self._pose(link, parameter)
        heights = (self._solids(link).corners @ turn.T + origin)[:, 2]
        return float(heights.min(initial=np.inf)) - self._task.around.floor

    def _solids(self, link: str) -> LinkSolids:
        return link_solids(self._task.bodies.chain.robot.links[link], 1 / self._task.bodies.metres)

    def _pose(self, link: str, parameter: float) -> SolidPose:
        """World from link, [unit]."""
        carried, scale = self._links[link], 1 / self._task.bodies.metres
        turn, origin = carried.pose[:3, :3], carried.pose[:3, 3]
        if carried.frame >= 0:
            positions = self._task.motion.positions_at(np.array([parameter]))
            frame = self._task.bodies.chain.poses(positions)[0, carried.frame]
            turn, origin = frame[:, :3] @ turn, frame[:, :3] @ origin + frame[:, 3]
        return SolidPose(turn, scale * origin)


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
    corners = shape.triangles(_SIDES) if isinstance(shape, ConvexShape) else shape.triangles()
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

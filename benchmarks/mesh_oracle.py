"""Contacts of a robot's exact meshes at poses, by coal, to confirm or refute what is proven."""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

import coal
import numpy as np

from abi.arm_planning.motion.arm_clearance import Contact
from abi.arrays import FloatArray
from abi.certification.clearance_proof import MotionProblem
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.pose import rotation
from abi.obstacles.primitives import Box, Cylinder, Sphere
from abi.robot.urdf.link import LinkShape

_SIZE = 20.0
"""Side of the box that stands for the floor, [m]."""
_TOUCHING = 1e-6
"""Distance of exact meshes at which coal calls them touching, [m]: about its rounding."""
_TOGETHER = 250
"""Poses that are looked at together."""
_DIRECTIONS = np.array([one for one in product((-1.0, 0.0, 1.0), repeat=3) if any(one)])


class _Part(NamedTuple):
    """A shape of a link: its object, the joint that moves it, its pose in that frame (4, 4), [m].

    ``middle`` (3,) in that frame and ``radius`` are of a ball around it.
    """

    solid: Any
    frame: int
    pose: FloatArray
    middle: FloatArray
    radius: float


class MeshOracle:
    """The exact shapes of a robot's links, and what they must not touch, at any pose.

    Args:
        problem: a motion in a scene in metres, whose robot, obstacles and pairs of links are meant.
    """

    def __init__(self, problem: MotionProblem) -> None:
        self._chain, self._floor = problem.chain, problem.around.floor
        self._obstacles = list(problem.around.obstacles)
        self._parts, self._links = list[_Part](), dict[str, list[int]]()
        for link, frame in self._chain.frames.items():
            for shape in self._chain.robot.links[link].shapes:
                self._links.setdefault(link, []).append(len(self._parts))
                self._parts.append(_part(shape, frame, self._chain.places[link] @ shape.pose))
        self._solids = [*map(obstacle_object, self._obstacles), _floor_object(self._floor)]
        self._frames = np.array([part.frame for part in self._parts])
        self._radii = np.array([part.radius for part in self._parts])
        names = [body.link for body in problem.bodies]
        links = sorted({(names[i], names[j]) for i, j in problem.pairs[0].tolist()})
        pairs = [
            both for one, other in links for both in product(self._links[one], self._links[other])
        ]
        self._pairs = np.array(pairs, dtype=int).reshape(-1, 2)
        self._request = coal.CollisionRequest()
        for part in self._parts:
            if part.frame < 0:
                _place(part.solid, part.pose)

    def touches(self, positions: FloatArray) -> bool:
        """Whether anything touches at any of some poses, (k, n), [rad] or [m]."""
        return any(
            self._touches(self._chain.poses(positions[first : first + _TOGETHER]))
            for first in range(0, len(positions), _TOGETHER)
        )

    def confirms(self, positions: FloatArray, touch: Contact) -> bool:
        """Whether a link touches what it is said to touch, at a pose (n,), to within rounding."""
        self._put(self._chain.poses(positions[None])[0])
        return self._meet(touch, _TOUCHING)

    def confirms_depth(self, positions: FloatArray, touch: Contact) -> bool:
        """Whether a link is still in contact when moved by less than its depth, in any of 26 ways.

        Args:
            positions: at the time of the depth, (n,), [rad] or [m].
            touch: the contact.
        """
        poses = self._chain.poses(positions[None])[0]
        moved = 0.99 * touch.depth * _DIRECTIONS
        moved /= np.linalg.norm(_DIRECTIONS, axis=1)[:, None]
        return all(self._meet_moved(poses, touch, way) for way in moved)

    def _meet_moved(self, poses: FloatArray, touch: Contact, way: FloatArray) -> bool:
        """Whether a link moved by ``way`` (3,) touches what it is said to touch."""
        self._put(poses)
        for number in self._links[touch.link]:
            solid = self._parts[number].solid
            solid.setTranslation(solid.getTranslation() + way)
        return self._meet(touch, 0.0)

    def _meet(self, touch: Contact, margin: float) -> bool:
        """Whether a link, where it is now, is nearer than a margin to what it is said to touch."""
        self._request.security_margin = margin
        other = touch.obstacle
        if other == "floor":
            others = self._solids[-1:]
        elif isinstance(other, int):
            others = [self._solids[other]]
        else:
            others = [self._parts[number].solid for number in self._links[other]]
        mine = [self._parts[number].solid for number in self._links[touch.link]]
        found = any(self._collide(one, two) for one, two in product(mine, others))
        self._request.security_margin = 0.0
        return found

    def _collide(self, first: Any, second: Any) -> bool:
        return bool(coal.collide(first, second, self._request, coal.CollisionResult()))

    def _put(self, poses: FloatArray) -> None:
        """Move all links to a pose of the chain, (m + 1, 3, 4)."""
        for part in self._parts:
            if part.frame >= 0:
                _place(part.solid, poses[part.frame] @ part.pose)

    def _touches(self, poses: FloatArray) -> bool:
        """Whether anything touches at poses of the chain, (k, m + 1, 3, 4)."""
        placed = np.full(len(self._parts), -1)
        for k, number, other in self._near(poses):
            for moved in (number, other if other >= 0 else number):
                part = self._parts[moved]
                if part.frame >= 0 and placed[moved] != k:
                    _place(part.solid, poses[k, part.frame] @ part.pose)
                    placed[moved] = k
            second = self._parts[other].solid if other >= 0 else self._solids[-1 - other]
            if self._collide(self._parts[number].solid, second):
                return True
        return False

    def _near(self, poses: FloatArray) -> list[tuple[int, int, int]]:
        """Poses, parts, and other parts or -1 less an obstacle, whose balls are not apart."""
        middles = np.stack(
            [
                poses[:, one.frame, :, :3] @ one.middle + poses[:, one.frame, :, 3]
                if one.frame >= 0
                else np.broadcast_to(one.middle, (len(poses), 3))
                for one in self._parts
            ],
            axis=1,
        )
        first, second = self._pairs.T
        between = np.linalg.norm(middles[:, first] - middles[:, second], axis=2)
        rows, pairs = np.nonzero(between <= self._radii[first] + self._radii[second])
        found = list(zip(rows.tolist(), first[pairs].tolist(), second[pairs].tolist(), strict=True))
        for number, obstacle in enumerate([*self._obstacles, None]):
            if obstacle is None:
                away = middles[:, :, 2] - self._floor
            else:
                away = _distance_of_box(obstacle, middles)
            near = (away <= self._radii) & (self._frames >= (1 if obstacle is None else 0))
            rows, parts = np.nonzero(near)
            found += [
                (k, part, -1 - number)
                for k, part in zip(rows.tolist(), parts.tolist(), strict=True)
            ]
        return sorted(found)


def _part(shape: LinkShape, frame: int, pose: FloatArray) -> _Part:
    """A shape of a link, with a ball around it."""
    if shape.kind == "mesh":
        low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        middle = (low + high) / 2
        radius = float(np.linalg.norm(shape.vertices - middle, axis=1).max())
    else:  # no solid is farther from its middle than all of its sizes together
        middle, radius = np.zeros(3), float(np.sum(shape.size))
    return _Part(
        coal.CollisionObject(geometry(shape)),
        frame,
        pose,
        pose[:3, :3] @ middle + pose[:3, 3],
        radius,
    )


def _distance_of_box(obstacle: Obstacle, points: FloatArray) -> FloatArray:
    """Distance (…,) of points (…, 3) from the box around an obstacle along its own axes, [m]."""
    if isinstance(obstacle, Box):
        half = np.array(obstacle.size) / 2
    elif isinstance(obstacle, Cylinder):
        half = np.array([obstacle.radius, obstacle.radius, obstacle.height / 2])
    else:
        assert isinstance(obstacle, Sphere)
        half = np.full(3, obstacle.radius)
    local = (points - np.array(obstacle.position)) @ rotation(obstacle.wxyz)
    return np.asarray(np.linalg.norm(np.maximum(np.abs(local) - half, 0.0), axis=-1))


@lru_cache(maxsize=256)
def geometry(shape: LinkShape) -> Any:
    """A link's shape in its own frame, [m]."""
    if shape.kind == "box":
        return coal.Box(*shape.size)
    if shape.kind == "sphere":
        return coal.Sphere(shape.size[0])
    if shape.kind == "cylinder":
        return coal.Cylinder(*shape.size[:2])
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(shape.faces), len(shape.vertices))
    points, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for point in shape.vertices:
        points.append(np.array(point))
    for face in shape.faces:
        faces.append(coal.Triangle(*map(int, face)))
    model.addSubModel(points, faces)
    model.endModel()
    return model


def obstacle_object(shape: Obstacle) -> Any:
    """An obstacle in its place, [m]."""
    place = coal.Transform3s(rotation(shape.wxyz).copy(), np.array(shape.position))
    if isinstance(shape, Box):
        return coal.CollisionObject(coal.Box(*shape.size), place)
    if isinstance(shape, Cylinder):
        return coal.CollisionObject(coal.Cylinder(shape.radius, shape.height), place)
    assert isinstance(shape, Sphere)
    return coal.CollisionObject(coal.Sphere(shape.radius), place)


def _floor_object(height: float) -> Any:
    place = coal.Transform3s(np.eye(3), np.array([0.0, 0.0, height - _SIZE / 2]))
    return coal.CollisionObject(coal.Box(_SIZE, _SIZE, _SIZE), place)


def _place(part: Any, pose: FloatArray) -> None:
    part.setTransform(coal.Transform3s(pose[:3, :3].copy(), pose[:3, 3].copy()))

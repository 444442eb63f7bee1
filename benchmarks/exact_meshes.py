"""Collisions of an arm by its collision shapes as they are given, with coal: an oracle of ours."""

from __future__ import annotations

import coal
import numpy as np

from abi.arrays import FloatArray
from abi.robot.urdf.link import Link, LinkShape
from abi.robot.urdf_arm import UrdfArm

_Placed = list[tuple[object, coal.Transform3s]]
"""Solids, each with its pose."""


class ExactArm:
    """Shapes of an arm's links, those that must keep apart, and a box that none may touch.

    Links that may touch each other by the arm's own rules are not compared; those that are said
    never to touch are.
    """

    def __init__(self, arm: UrdfArm, box: FloatArray | None = None) -> None:
        """Shapes of ``arm``, which stands in metres, and a ``box``: centre and extents, (2, 3)."""
        links = arm.chain.robot.links
        self._arm = arm
        shaped = (name for name in arm.chain.frames if any(links[name].shapes))
        self._solids = {name: _solids_of(links[name]) for name in shaped}
        names = [one.link for one in arm.capsules]
        never = {(one.link, str(one.other)) for one in arm.allowed if one.reason == "never"}
        self._pairs = sorted(never | {(names[i], names[j]) for i, j in arm.pairs.tolist()})
        self._box: _Placed = []
        if box is not None:
            at = coal.Transform3s(np.eye(3), box[0])
            self._box.append((coal.Box(*box[1].tolist()), at))

    def hits_itself(self, pose: FloatArray) -> bool:
        """Check whether two links collide at joint positions (n,)."""
        return self._hits_itself(self._placed(pose))

    def hits(self, pose: FloatArray) -> bool:
        """Check whether two links, or one that moves and the box, collide."""
        placed, frames = self._placed(pose), self._arm.chain.frames
        moving = (name for name in self._solids if frames[name] >= 0)
        on_box = any(_collide(placed[name], self._box) for name in moving)
        return on_box or self._hits_itself(placed)

    def box_stands_free(self) -> bool:
        """Check whether no link that stands still collides with the box."""
        chain = self._arm.chain
        placed = self._placed(chain.usual_range().mean(axis=1))
        standing = (name for name in self._solids if chain.frames[name] < 0)
        return not any(_collide(placed[name], self._box) for name in standing)

    def _hits_itself(self, placed: dict[str, _Placed]) -> bool:
        return any(_collide(placed[a], placed[b]) for a, b in self._pairs)

    def _placed(self, pose: FloatArray) -> dict[str, _Placed]:
        """Solids of each link, in the world."""
        chain, found = self._arm.chain, {}
        frames = chain.poses(pose[None])[0]
        for name, solids in self._solids.items():
            of_link = chain.places[name]
            if chain.frames[name] >= 0:
                of_link = np.vstack([frames[chain.frames[name]], [0, 0, 0, 1]]) @ of_link
            world = _transform(of_link)
            found[name] = [(solid, world * at) for solid, at in solids]
        return found


def _solids_of(link: Link) -> _Placed:
    """Collision shapes of a link in its frame."""
    return [(_solid(shape), _transform(shape.pose)) for shape in link.shapes]


def _transform(pose: FloatArray) -> coal.Transform3s:
    return coal.Transform3s(pose[:3, :3], pose[:3, 3])


def _solid(shape: LinkShape) -> object:
    """A shape as it is given: no triangles stand for what is round."""
    first, second, third = shape.size
    match shape.kind:
        case "box":
            return coal.Box(first, second, third)
        case "sphere":
            return coal.Sphere(first)
        case "cylinder":
            return coal.Cylinder(first, second)
    return _mesh(shape.vertices[shape.faces])


def _mesh(triangles: FloatArray) -> coal.BVHModelOBBRSS:
    vertices, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for number, corners in enumerate(triangles):
        for corner in corners:
            vertices.append(corner)
        faces.append(coal.Triangle(3 * number, 3 * number + 1, 3 * number + 2))
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(faces), len(vertices))
    mesh.addSubModel(vertices, faces)
    mesh.endModel()
    return mesh


def _collide(first: _Placed, second: _Placed) -> bool:
    """Check whether some solid of one collides with some solid of the other."""
    request, result = coal.CollisionRequest(), coal.CollisionResult()
    return any(
        coal.collide(a, at, b, other, request, result) for a, at in first for b, other in second
    )

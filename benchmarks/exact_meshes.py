"""Collisions of an arm by the triangles of its collision shapes, with coal: an oracle of ours."""

from __future__ import annotations

import coal
import numpy as np

from abi.arrays import FloatArray
from abi.robot.bodies.link_bodies import triangles_of
from abi.robot.urdf_arm import UrdfArm


class ExactArm:
    """Meshes of an arm's links, those that must keep apart, and a box that none may touch.

    Links that may touch each other by the arm's own rules are not compared.
    """

    def __init__(self, arm: UrdfArm, box: FloatArray | None = None) -> None:
        """Meshes of ``arm``, which stands in metres, and a ``box``: centre and extents, (2, 3)."""
        links = arm.chain.robot.links
        self._carried = {one.link: one for one in arm.chain.carried if any(links[one.link].shapes)}
        self._arm = arm
        self._meshes = {name: _mesh(triangles_of(links[name])) for name in self._carried}
        names = [one.link for one in arm.capsules]
        self._pairs = sorted({(names[i], names[j]) for i, j in arm.pairs.tolist()})
        self._box = None if box is None else coal.Box(*box[1].tolist())
        self._at = coal.Transform3s(np.eye(3), np.zeros(3) if box is None else box[0])

    def hits_itself(self, pose: FloatArray) -> bool:
        """Check whether two links collide at joint positions (n,)."""
        places = self._places(pose)
        return any(
            _collide(self._meshes[a], places[a], self._meshes[b], places[b]) for a, b in self._pairs
        )

    def hits(self, pose: FloatArray) -> bool:
        """Check whether two links, or one that moves and the box, collide."""
        places = self._places(pose)
        on_box = self._box is not None and any(
            _collide(self._meshes[name], places[name], self._box, self._at)
            for name, one in self._carried.items()
            if one.frame >= 0
        )
        return on_box or self.hits_itself(pose)

    def _places(self, pose: FloatArray) -> dict[str, coal.Transform3s]:
        frames = self._arm.chain.poses(pose[None])[0]
        found = {}
        for name, one in self._carried.items():
            placed = one.pose
            if one.frame >= 0:
                placed = np.vstack([frames[one.frame], [0, 0, 0, 1]]) @ one.pose
            found[name] = coal.Transform3s(placed[:3, :3], placed[:3, 3])
        return found


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


def _collide(first: object, at: object, second: object, other: object) -> bool:
    request, result = coal.CollisionRequest(), coal.CollisionResult()
    return bool(coal.collide(first, at, second, other, request, result))

"""A robot with an object that its tool holds: one link more, fixed to the tip."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import scipy

from abi.arrays import FloatArray, read_only
from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.pose import rotation
from abi.obstacles.primitives import Box, Capsule, Sphere
from abi.obstacles.triangle_mesh.surface import Surface
from abi.robot.urdf.joint import Joint
from abi.robot.urdf.link import Link, LinkShape
from abi.robot.urdf.robot import Robot

STANDING = 1e-3
"""Distance by which an object is taken as smaller on each side, so that it may stand, [m]; a corner
of a mesh is no more than twice as far from where it was."""
_LEAST = 0.1
"""Part of half its thickness by which it is taken as smaller at most."""
_NAME = "held_object"
_SOLID = "a solid: what is flat cannot be held"


@lru_cache(maxsize=64)
def with_object(
    robot: Robot, tip: str, shape: Obstacle, metres: float, inset: float = 0.0
) -> Robot:
    """A robot that holds an object.

    Of a mesh the convex hull counts. It is drawn as it is.

    Args:
        robot: the robot.
        tip: name of the link that holds it.
        shape: the object; its pose is that in the frame of the tip.
        metres: one [unit] of the shape in metres.
        inset: distance by which it counts as smaller on each side, [m]; with ``STANDING`` it no
            longer touches what it stands on.

    Raises:
        SceneError: a mesh is flat.
    """
    name, joints = _NAME, {one.name for one in robot.joints}
    while name in robot.links or f"{name}_joint" in joints:
        name = f"{name}_"
    nothing = np.zeros(3), np.zeros((3, 3))
    whole = tuple(_shapes(shape, metres, 0.0))
    link = Link(
        name,
        shapes=tuple(_shapes(shape, metres, inset)),
        mass=0.0,
        centre=read_only(nothing[0]),
        inertia=read_only(nothing[1]),
        visuals=(_drawn(shape, metres),) if isinstance(shape, MeshShape) else whole,
    )
    joint = Joint(
        name=f"{name}_joint",
        kind="fixed",
        parent=tip,
        child=name,
        origin=read_only(_pose(shape, metres)),
        axis=read_only(np.array([0.0, 0.0, 1.0])),
        low=0.0,
        high=0.0,
        speed=np.inf,
        effort=np.inf,
    )
    return replace(
        robot,
        links={**robot.links, name: link},
        joints=(*robot.joints, joint),
        attached=name,
        attached_key=(tip, shape, metres, inset),
    )


def _pose(shape: Obstacle, metres: float) -> FloatArray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation(shape.wxyz), np.array(shape.position) * metres
    return pose


def _shapes(shape: Obstacle, metres: float, inset: float) -> list[LinkShape]:
    """Shapes of a link whose frame is that of the object, each drawn in by a distance, [m]."""
    if isinstance(shape, Box):
        edges = np.array(shape.size) * metres
        a, b, c = (edges - 2 * min(inset, _LEAST * float(edges.min()) / 2)).tolist()
        return [_solid("box", (a, b, c))]
    if isinstance(shape, MeshShape):
        return [_hull(shape, metres, inset)]
    radius = shape.radius * metres
    if isinstance(shape, Sphere):
        return [_solid("sphere", (radius - min(inset, _LEAST * radius), 0.0, 0.0))]
    height = shape.height * metres
    if isinstance(shape, Capsule):
        radius -= min(inset, _LEAST * radius)
        ends = [_solid("sphere", (radius, 0.0, 0.0), up * height / 2) for up in (-1, 1)]
        return [_solid("cylinder", (radius, height, 0.0)), *ends]
    inset = min(inset, _LEAST * radius, _LEAST * height / 2)
    return [_solid("cylinder", (radius - inset, height - 2 * inset, 0.0))]


def _solid(kind: str, size: tuple[float, float, float], up: float = 0.0) -> LinkShape:
    pose = np.eye(4)
    pose[2, 3] = up
    return _link_shape(kind, size, pose, np.zeros((0, 3)), np.zeros((0, 3), np.int32))


def _link_shape(
    kind: str,
    size: tuple[float, float, float],
    pose: FloatArray,
    vertices: FloatArray,
    faces: np.ndarray,
) -> LinkShape:
    return LinkShape(
        kind=kind,  # type: ignore[arg-type]
        size=size,
        pose=read_only(pose),
        vertices=read_only(vertices),
        faces=read_only(np.ascontiguousarray(faces, dtype=np.int32)),
        colours=read_only(np.zeros((0, 3), dtype=np.uint8)),
    )


def _drawn(shape: MeshShape, metres: float) -> LinkShape:
    """A mesh as it is."""
    surface, scale = shape.surface, shape.factor * metres
    return _link_shape("mesh", (1.0, 1.0, 1.0), np.eye(4), surface.vertices * scale, surface.faces)


def _with_tips(corners: FloatArray, whole: FloatArray, depth: float) -> FloatArray:
    """Corners of a hull moved inwards by a distance, with tips that would lose more than twice it.

    Where sides meet at a small angle, a point that far from all of them is far from their corner.
    """
    apart, nearest = scipy.spatial.cKDTree(corners).query(whole)
    lost = apart > 2 * depth
    inwards = (corners[nearest[lost]] - whole[lost]) / apart[lost, None]
    return np.concatenate([corners, whole[lost] + 2 * depth * inwards])


def require_solid(field: str, shape: Obstacle) -> None:
    """Raise a SceneError that names a field if a mesh is flat, so that it cannot be held."""
    if isinstance(shape, MeshShape) and _is_flat(shape.surface):
        raise SceneError(field, shape.file, _SOLID)


@lru_cache(maxsize=64)
def _is_flat(surface: Surface) -> bool:
    try:
        scipy.spatial.ConvexHull(surface.vertices)
    except (scipy.spatial.QhullError, ValueError):
        return True
    return False


def _hull(shape: MeshShape, metres: float, inset: float) -> LinkShape:
    """Convex hull of a mesh, its sides moved inwards."""
    ones, scale = (1.0, 1.0, 1.0), shape.factor * metres
    try:
        sides = scipy.spatial.ConvexHull(shape.surface.vertices * scale).equations
        # the centre of the largest ball inside: the variables are its place and its radius
        found = scipy.optimize.linprog(
            [0, 0, 0, -1],
            A_ub=np.column_stack([sides[:, :3], np.ones(len(sides))]),
            b_ub=-sides[:, 3],
            bounds=[(None, None)] * 3 + [(0, None)],
        )
        depth, centre = min(inset, _LEAST * float(found.x[3])), found.x[:3]
        moved = sides.copy()
        moved[:, 3] += depth
        corners = scipy.spatial.HalfspaceIntersection(moved, centre).intersections
        if depth > 0:
            corners = _with_tips(corners, shape.surface.hull * scale, depth)
        faces = scipy.spatial.ConvexHull(corners).simplices
    except (scipy.spatial.QhullError, TypeError, ValueError):
        raise SceneError("arm.attached", shape.file, _SOLID) from None
    return _link_shape("mesh", ones, np.eye(4), corners, faces)

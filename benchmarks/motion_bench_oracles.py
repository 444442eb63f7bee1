"""Exact meshes of an arm by coal, and OMPL's RRTConnect, for MotionBenchMaker's problems."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arrays import FloatArray
from abi.certification.verdict import Touch
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.pose import rotation
from abi.obstacles.primitives import Box, Cylinder, Sphere
from abi.robot.urdf_arm import UrdfArm

_EVERY = 4
_SECONDS = 5.0
_RESOLUTION = 0.02
"""Way between two poses that OMPL tests on an edge, [rad]."""


def poses_touching(arm: UrdfArm, obstacles: ObstacleSet, positions: FloatArray) -> int:
    """Number of poses, of every fourth of some (k, n), at which a mesh touches an obstacle."""
    import coal

    solids = [(_solid(one), _placed(one)) for one in obstacles]
    request, touching = coal.CollisionRequest(), 0
    for poses in arm.chain.poses(positions[::_EVERY] / arm.scales):
        touching += any(
            coal.collide(mesh, _transform(poses, frame, pose), solid, place, request, _result())
            for mesh, frame, pose in _meshes(arm)
            for solid, place in solids
        )
    return touching


def _result() -> Any:
    import coal

    return coal.CollisionResult()


@lru_cache(maxsize=4)
def _meshes(arm: UrdfArm) -> list[tuple[Any, int, FloatArray]]:
    """Every mesh of a link, the joint that moves it, and its pose in that frame."""
    import coal

    found = []
    for carried in arm.chain.carried:
        for shape in arm.chain.robot.links[carried.link].shapes:
            assert shape.kind == "mesh"
            model = coal.BVHModelOBBRSS()
            model.beginModel(len(shape.faces), len(shape.vertices))
            points, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
            for point in shape.vertices:
                points.append(np.array(point))
            for face in shape.faces:
                faces.append(coal.Triangle(*map(int, face)))
            model.addSubModel(points, faces)
            model.endModel()
            found.append((model, carried.frame, carried.pose @ shape.pose))
    return found


def _transform(poses: FloatArray, frame: int, pose: FloatArray) -> Any:
    """World from shape at one pose of the arm, (m + 1, 3, 4)."""
    import coal

    world = pose if frame < 0 else np.vstack([poses[frame], [0, 0, 0, 1]]) @ pose
    return coal.Transform3s(world[:3, :3].copy(), world[:3, 3].copy())


def _solid(shape: Obstacle) -> Any:
    import coal

    if isinstance(shape, Box):
        return coal.Box(*shape.size)
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.height)
    assert isinstance(shape, Sphere)
    return coal.Sphere(shape.radius)


def _placed(shape: Obstacle) -> Any:
    import coal

    return coal.Transform3s(rotation(shape.wxyz).copy(), np.array(shape.position))


def solids_touch(
    arm: UrdfArm,
    obstacles: Sequence[Obstacle],
    pose: FloatArray,
    touch: Touch,
    margin: float,
) -> bool:
    """Whether coal has a link nearer than a margin to what it is said to touch, at a pose (n,).

    Args:
        arm: the arm, in metres.
        obstacles: the obstacles.
        pose: joint positions, [rad].
        touch: the contact.
        margin: [m].
    """
    import coal

    poses = arm.chain.poses(pose[None])[0]
    request = coal.CollisionRequest()
    request.security_margin = margin
    first = _of_link(arm, touch.link, poses)
    if isinstance(touch.obstacle, int):
        solid = obstacles[touch.obstacle]
        second = [(_solid(solid), _placed(solid))]
    else:
        second = _of_link(arm, touch.obstacle, poses)
    return any(
        coal.collide(mesh, at, other, there, request, _result())
        for mesh, at in first
        for other, there in second
    )


def _of_link(arm: UrdfArm, link: str, poses: FloatArray) -> list[tuple[Any, Any]]:
    """Meshes of a link, each with its place in the world."""
    names = [one.link for one in arm.chain.carried for _ in arm.chain.robot.links[one.link].shapes]
    return [
        (mesh, _transform(poses, frame, pose))
        for name, (mesh, frame, pose) in zip(names, _meshes(arm), strict=True)
        if name == link
    ]


def ompl_length(space: JointSpace, start: FloatArray, goal: FloatArray) -> float:
    """Length of OMPL's path with simplification, [rad]; inf if it finds none in five seconds."""
    path = ompl_path(space, start, goal)
    if path is None:
        return float("inf")
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def ompl_path(space: JointSpace, start: FloatArray, goal: FloatArray) -> FloatArray | None:
    """OMPL's path with simplification, (k, n), [rad]; None if it finds none in five seconds."""
    from ompl import base, geometric, util

    util.setLogLevel(util.LOG_NONE)
    count = len(start)
    joints = base.RealVectorStateSpace(count)
    bounds = base.RealVectorBounds(count)
    for k, (low, high) in enumerate(space.arm.limits.tolist()):
        bounds.setLow(k, low)
        bounds.setHigh(k, high)
    joints.setBounds(bounds)
    setup = geometric.SimpleSetup(joints)

    def is_clear(state: Any) -> bool:
        pose = np.array([state[k] for k in range(count)])
        return space.clear(np.stack([pose, pose]))

    setup.setStateValidityChecker(is_clear)
    setup.getSpaceInformation().setStateValidityCheckingResolution(
        _RESOLUTION / joints.getMaximumExtent()
    )
    ends = []
    for pose in (start, goal):
        state = joints.allocState()
        for k, value in enumerate(pose.tolist()):
            state[k] = value
        ends.append(state)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(geometric.RRTConnect(setup.getSpaceInformation()))
    if not setup.solve(_SECONDS) or not setup.haveExactSolutionPath():
        return None
    setup.simplifySolution()
    states = setup.getSolutionPath().getStates()
    return np.array([[state[k] for k in range(count)] for state in states])

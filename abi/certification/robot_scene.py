"""The scene in which a robot moves: that of a file with another robot, or the robot alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.kinematics.chain import strokes
from abi.robot.urdf.link import LinkShape
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import SHIPPED, file_of, load_robot
from abi.scene.scene import Scene

_OF_ONE_ROBOT = (
    *("srdf", "tip", "base_link", "gripper", "allowed", "grasping", "axis", "start", "goal"),
    "search",
)
"""Fields of an arm that mean nothing for another one."""
_ROOM = 100.0
"""Half of the room that a robot alone has around it, over its length: motions may pass limits."""
_MOST = 1e6
"""Largest half of a room, [m], as scenes have no larger numbers."""


def robot_scene(robot: str | Path | None, scene: Scene | None = None) -> Scene:
    """A scene with a robot.

    The robot stands at ``arm.base`` where the scene gives one or has a robot, else at the origin.
    What else a scene says of its own robot is not taken over for another one.

    Args:
        robot: a shipped arm's name, or a ``.urdf`` or ``.zip`` file; None for the scene's own.
        scene: with the obstacles; None for a room without any, in metres.

    Raises:
        SceneError: the robot cannot be read, there is none, or the scene's own holds an object.
    """
    if robot is None:
        if scene is None or scene.arm.model != "urdf":
            raise SceneError("robot", robot, "a URDF or zip file, or a scene with one")
        return scene
    name, files = _files(str(robot))
    if scene is None:
        return _alone(name, files)
    before = scene.arm
    if before.model == "urdf" and load_robot(name, MeshSource(files)) == before.whole_robot:
        return scene
    if before.attached is not None:
        expected = "none where another robot takes the place of the one that holds it"
        raise SceneError("arm.attached", before.attached.model_dump(), expected)
    fields = {name: type(before).model_fields[name] for name in _OF_ONE_ROBOT}
    arm: dict[str, Any] = {
        **{name: field.get_default(call_default_factory=True) for name, field in fields.items()},
        **{"model": "urdf", "urdf": name},
    }
    if before.model != "urdf" and "base" not in before.model_fields_set:
        arm["base"] = (0.0, 0.0, 0.0)  # the default is where the paper's arm stands
    return scene.replace(files=files, arm=arm, tasks=())


def _files(robot: str) -> tuple[str, dict[str, Robot]]:
    """Name of a robot as a scene has it, and what was read of its file."""
    if robot in SHIPPED:
        return robot, {}
    path, file = Path(robot), Path(file_of(robot))
    if file != path and file.is_file():  # one of several in a zip
        path, name = file, f"{file.name}/{path.relative_to(file).as_posix()}"
    else:
        name = path.name
    return name, {name: load_robot(name, MeshSource(folder=path.parent))}


def _alone(name: str, files: dict[str, Robot]) -> Scene:
    """A robot at the origin of a room that it cannot leave, whose floor it cannot reach."""
    length = max(_length(load_robot(name, MeshSource(files))), 0.1)
    half = min(_ROOM * length, _MOST)
    return Scene.from_dict(
        {
            "version": 1,
            "unit": "m",
            "workspace": {"min": [-half] * 3, "max": [half] * 3},
            "start": [0.0, 0.0, 0.0],
            "goal": [0.0, 0.0, half],
            "mesh": {"pitch": half / 4},
            "arm": {"model": "urdf", "urdf": name, "base": [0.0, 0.0, 0.0]},
        },
        MeshSource(files),
    )


def _length(robot: Robot) -> float:
    """Length of all joints and links of a robot in a row, slides as far out as limits let, [m]."""
    length = sum(float(np.linalg.norm(joint.origin[:3, 3])) for joint in robot.joints)
    shapes = [shape for link in robot.links.values() for shape in link.shapes]
    return length + strokes(robot, robot.joints) + max(map(_farthest, shapes), default=0.0)


def _farthest(shape: LinkShape) -> float:
    """Distance from a link's origin that no point of a shape exceeds, [m]."""
    away = float(np.linalg.norm(shape.pose[:3, 3]))
    if shape.kind == "mesh":
        return away + float(np.linalg.norm(shape.vertices, axis=1).max(initial=0.0))
    return away + sum(shape.size)

"""The Panda's problems of MotionBenchMaker, as VAMP's source distribution holds them.

Chamzas et al., MotionBenchMaker: A Tool to Generate and Benchmark Motion Planning Datasets, 2022.
"""

from __future__ import annotations

import re
import tarfile
import zipfile
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from ruamel.yaml import YAML

from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.primitives import Box, Cylinder, Sphere
from abi.robot.urdf.robot_files import robot_from_archive
from abi.robot.urdf_arm import UrdfArm, urdf_arm

TIP = "panda_hand"
JOINTS = tuple(f"panda_joint{number}" for number in range(1, 8))
_FOLDER = "resources/panda/"


class MotionProblem(NamedTuple):
    """A problem: obstacles, and joint positions at start and goal (7,) each, [rad].

    Attributes:
        environment: its name.
        number: from 1.
        obstacles: those of the scene, the object to grasp among them, [m].
        start: joint positions.
        goal: joint positions.
    """

    environment: str
    number: int
    obstacles: ObstacleSet
    start: FloatArray
    goal: FloatArray


def panda(archive: Path) -> UrdfArm:
    """The arm with its fingers open, as the source distribution describes it."""
    content = BytesIO()
    with zipfile.ZipFile(content, "w") as packed:
        for path, data in panda_files(archive).items():
            packed.writestr(path, data)
    return urdf_arm(robot_from_archive(content.getvalue()), TIP, (0.0, 0.0, 0.0))


def panda_files(archive: Path) -> dict[str, bytes]:
    """The URDF, its SRDF and its meshes, by their paths below the robot's folder."""
    found = {}
    with tarfile.open(archive) as files:
        for member in files.getmembers():
            _, _, inside = member.name.partition(_FOLDER)
            if member.isfile() and inside.endswith((".obj", "panda.urdf", "panda.srdf")):
                found[inside] = _read(files, member)
    return found


def problems(archive: Path, each: int) -> Iterator[MotionProblem]:
    """The first problems of each environment, at most so many of each."""
    texts: dict[tuple[str, int], dict[str, Any]] = {}
    yaml = YAML(typ="safe")
    with tarfile.open(archive) as files:
        member = next(one for one in files.getmembers() if one.name.endswith(_SET))
        with tarfile.open(fileobj=BytesIO(_read(files, member)), mode="r:bz2") as inner:
            for one in inner.getmembers():
                found = re.fullmatch(r"problems/(\w+)_panda/(scene|request)(\d+)\.yaml", one.name)
                if found and int(found[3]) <= each:
                    key = found[1], int(found[3])
                    texts.setdefault(key, {})[found[2]] = yaml.load(_read(inner, one))
    for (environment, number), data in sorted(texts.items()):
        state = data["request"]["start_state"]["joint_state"]
        start = dict(zip(state["name"], state["position"], strict=True))
        constraints = data["request"]["goal_constraints"][0]["joint_constraints"]
        goal = {one["joint_name"]: one["position"] for one in constraints}
        yield MotionProblem(
            environment,
            number,
            ObstacleSet(tuple(_obstacles(data["scene"]["world"]["collision_objects"]))),
            *(np.array([float(end[name]) for name in JOINTS]) for end in (start, goal)),
        )


_SET = f"{_FOLDER}problems.tar.bz2"


def _read(files: tarfile.TarFile, member: tarfile.TarInfo) -> bytes:
    content = files.extractfile(member)
    assert content is not None
    return content.read()


def _obstacles(objects: list[dict[str, Any]]) -> Iterator[Obstacle]:
    """Solids of a scene of MoveIt."""
    for one in objects:
        assert "pose" not in one, "the set places primitives alone"
        for primitive, pose in zip(one["primitives"], one["primitive_poses"], strict=True):
            x, y, z, w = map(float, pose["orientation"])
            place: dict[str, Any] = {
                "position": tuple(map(float, pose["position"])),
                "wxyz": (w, x, y, z),
            }
            sizes = [float(size) for size in primitive["dimensions"]]
            if primitive["type"] == "box":
                yield Box(size=(sizes[0], sizes[1], sizes[2]), **place)
            elif primitive["type"] == "cylinder":
                yield Cylinder(height=sizes[0], radius=sizes[1], **place)
            else:
                yield Sphere(radius=sizes[0], **place)

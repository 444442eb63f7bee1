"""RoboPlan's RRT-Connect with shortcuts, for MotionBenchMaker's problems."""

from __future__ import annotations

import time
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import roboplan.core as roboplan
from roboplan.rrt import RRT, RRTOptions

from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.pose import rotation
from abi.obstacles.primitives import Box, Cylinder, Sphere
from benchmarks.motion_bench_set import JOINTS, MotionProblem, panda_files

_GROUP, _WORLD = "panda_arm", "universe"
_NODES = 20_000
"""Its bound is of time as a clock shows it; this one does not depend on what else runs."""
_COLOUR = np.array([0.5, 0.5, 0.5, 1.0])


class RoboPlanAnswer(NamedTuple):
    """What RoboPlan says to a problem.

    Attributes:
        ms: processor time of search and shortcuts, [ms].
        length: of the path in the space of the joints, [rad]; inf without one.
    """

    ms: float
    length: float


class RoboPlanArm:
    """The Panda as RoboPlan reads it, with the exact meshes and its SRDF's allowed contacts.

    Edges are tested at samples, as far apart as RoboPlan's options are by default, 0.05 rad.

    Args:
        archive: VAMP's source distribution.
    """

    def __init__(self, archive: Path) -> None:
        with TemporaryDirectory() as name:
            folder = Path(name)
            for path, content in panda_files(archive).items():
                (folder / path).parent.mkdir(parents=True, exist_ok=True)
                (folder / path).write_bytes(content)
            described = roboplan.loadUrdfSceneDescription(folder / "panda.urdf", [folder])
            self._scene = roboplan.Scene("panda", described)
            self._scene.importSrdf((folder / "panda.srdf").read_text(encoding="utf-8"))

    def answer(self, problem: MotionProblem, seed: int) -> RoboPlanAnswer:
        """Solve a problem, among its obstacles alone."""
        names = [f"obstacle {number}" for number, _ in enumerate(problem.obstacles)]
        for name, obstacle in zip(names, problem.obstacles, strict=True):
            self._add(name, obstacle)
        self._scene.setCollisions(list(combinations(names, 2)), False)  # obstacles may overlap
        start, goal = _configuration(problem.start), _configuration(problem.goal)
        options = RRTOptions(group_name=_GROUP, max_nodes=_NODES, rrt_connect=True)
        search = RRT(self._scene, options)
        search.setRngSeed(seed)
        shortcuts = roboplan.PathShortcuttingOptions(group_name=_GROUP, seed=seed)
        shortcutter = roboplan.PathShortcutter(self._scene, shortcuts)
        begin = time.process_time()
        try:
            path = shortcutter.shortcut(search.plan(start, goal))
            length = _length(np.stack(path.positions))
        except RuntimeError:  # it found no path, or an end is not clear
            length = float("inf")
        took = 1e3 * (time.process_time() - begin)
        for name in names:
            self._scene.removeGeometry(name)
        return RoboPlanAnswer(took, length)

    def _add(self, name: str, obstacle: Obstacle) -> None:
        pose = np.eye(4, order="F")
        pose[:3, :3], pose[:3, 3] = rotation(obstacle.wxyz), obstacle.position
        scene, place = self._scene, (pose, _COLOUR)
        if isinstance(obstacle, Box):
            scene.addBoxGeometry(name, _WORLD, roboplan.Box(*obstacle.size), *place)
        elif isinstance(obstacle, Cylinder):
            solid = roboplan.Cylinder(obstacle.radius, obstacle.height)
            scene.addCylinderGeometry(name, _WORLD, solid, *place)
        else:
            assert isinstance(obstacle, Sphere)
            scene.addSphereGeometry(name, _WORLD, roboplan.Sphere(obstacle.radius), *place)


def _configuration(pose: FloatArray) -> roboplan.JointConfiguration:
    return roboplan.JointConfiguration(list(JOINTS), np.array(pose))


def _length(path: FloatArray) -> float:
    """Length of a path (k, n) in the space of the joints, [rad]."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())

"""OMPL's RRTConnect with simplification on arms of public packages, beside ours.

    pip install ompl
    python -m benchmarks.public_arms_ompl FOLDER… --match 'panda|ur5' --results ompl.jsonl

The arms and tasks are those of :mod:`benchmarks.arms`, without a floor. OMPL goes from joints to
joints, both clear by the collision shapes; ours gets the same joints, and finds its motion in the
space of the joints. OMPL asks coal whether poses are clear, in steps of a hundredth of its space;
ours proves whole motions. Lengths are sums of ways in the joints [rad] or [m]; ours is that of the
path found, before it is smoothed. Times are of the processor, [ms], OMPL's with its simplification;
most of it goes to coal, which is called from Python.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
from ompl import base, geometric, util

from abi import compiling
from abi.arrays import FloatArray
from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.planner import Planner
from abi.robot.urdf.robot_files import load_robot
from abi.robot.urdf.usual_tip import usual_tip
from abi.robot.urdf_arm import urdf_arm
from benchmarks.arms import chosen_files, scene_of, task
from benchmarks.exact_meshes import ExactArm
from benchmarks.report import Row, table

_SECONDS = 10.0

util.setLogLevel(util.LOG_NONE)


def ompl_path(exact: ExactArm, limits: FloatArray, ends: FloatArray) -> tuple[float | None, float]:
    """Length of OMPL's path between two poses (2, n), None without one, and its time, [ms].

    Args:
        exact: says which poses collide.
        limits: of the joints, (n, 2).
        ends: the poses.
    """
    space = base.RealVectorStateSpace(len(limits))
    bounds = base.RealVectorBounds(len(limits))
    for k, (low, high) in enumerate(limits.tolist()):
        bounds.setLow(k, low)
        bounds.setHigh(k, high)
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: not exact.hits(_pose(state, len(limits))))
    states = [space.allocState() for _ in ends]
    for state, pose in zip(states, ends.tolist(), strict=True):
        for k, at in enumerate(pose):
            state[k] = at
    setup.setStartAndGoalStates(*states)
    setup.setPlanner(geometric.RRTConnect(setup.getSpaceInformation()))
    begin = time.process_time()
    setup.solve(_SECONDS)
    if not setup.haveExactSolutionPath():
        return None, 1e3 * (time.process_time() - begin)
    setup.simplifySolution()
    taken = 1e3 * (time.process_time() - begin)
    path = setup.getSolutionPath()
    rows = [_pose(path.getState(k), len(limits)) for k in range(path.getStateCount())]
    return _length(np.array(rows)), taken


def _pose(state: Any, count: int) -> FloatArray:
    return np.array([state[k] for k in range(count)])


def _length(path: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def measure(name: str, files: MeshSource) -> Row | None:
    """Row of an arm; None where there is no task.

    Raises:
        SceneError: the file is not read.
    """
    robot = load_robot(name, files)
    arm = urdf_arm(robot, usual_tip(robot), (0.0, 0.0, 0.0))
    found = task(arm, ExactArm(arm))
    if found is None:
        return None
    ends, box = found
    length, taken = ompl_path(ExactArm(arm, box), arm.chain.usual_range(), ends)
    scene = scene_of(name, arm, ends, box, files)
    x, y, z = scene.workspace.min
    z = min(z, float(arm.base[2]) - 2 * arm.reach)  # OMPL knows of no floor
    scene = scene.replace(workspace={"min": (x, y, z)})
    first, last = ({"joints": dict(zip(arm.joints, pose, strict=True))} for pose in ends.tolist())
    scene = scene.replace(start=first, goal=last)
    Planner()(scene)  # what is known of an arm is kept
    planner, begin = Planner(), time.process_time()
    plan = planner(scene)
    ours = 1e3 * (time.process_time() - begin)
    path = None if plan.joint_search is None else plan.joint_search.path
    own = None if path is None or plan.error is not None else _length(np.asarray(path))
    ratio = None if own is None or length is None else own / length
    return {"ompl": length, "ompl ms": taken, "ours": own, "ours ms": ours, "ratio": ratio}


def main() -> None:
    """Print a row for each arm, and medians."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--match", default="", help="only paths that contain this expression")
    parser.add_argument("--results", type=Path, default=Path("ompl.jsonl"), help="file of rows")
    options = parser.parse_args()
    compiling.compile()
    rows: list[Row] = []
    with options.results.open("w", encoding="utf-8") as lines:
        for folder in options.folders:
            for name in chosen_files(folder, options.match):
                try:
                    row = measure(name, MeshSource(folder=folder))
                except SceneError:
                    continue  # benchmarks.arms tells why
                if row is not None:
                    rows.append({"arm": "/".join(name.split("/")[-2:])} | row)
                    lines.write(json.dumps(rows[-1]) + "\n")
                    lines.flush()
    print(table(rows))
    for column in ("ompl ms", "ours ms", "ratio"):
        values = [float(str(row[column])) for row in rows if row[column] is not None]
        if values:
            print(f"{column}: median {np.median(values):.3g} of {len(values)}")


if __name__ == "__main__":
    main()

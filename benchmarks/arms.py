"""Arms of public packages: how many load, are called self-colliding rightly, and get a plan.

    python -m benchmarks.arms FOLDER… --match 'panda|ur5' --results arms.jsonl

Each folder holds the files of packages, unpacked, as ``benchmarks.public_files`` says; coal decides
what collides by the collision shapes as they are given. Of each arm:

- ``wrong`` is the share of random poses that are called self-colliding but are not, by the shapes;
- the task is to move the tool between its places at two random poses that are clear, around a box
  in the middle; ``rrt`` says whether an independent search in the joints, which tries poses alone,
  finds a motion between these poses in 5 s of processor time;
- ``plan`` is what came of ours; ``hits`` counts poses, of 401 on the motion, that collide by the
  shapes; ``proof`` says whether ``abi verify`` confirms the certificate;
- ``first`` is the processor time of the first plan, [s], and ``drag`` the median of those in which
  the box is moved a little, with the effort of a planner that somebody waits for, [ms].

A file that is refused says whether Pinocchio reads it, as more than a link that stands still. What
came of each file is a line of the results, and what stands there is not done again.
"""

from __future__ import annotations

import argparse
import json
import re
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pinocchio

from abi import compiling
from abi.arm_planning.world.chain_distances import Poses, own_distances
from abi.arrays import FloatArray
from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.joint_space_motion import HASTY
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.robot.urdf.robot import Robot, joints_to
from abi.robot.urdf.robot_files import load_robot
from abi.robot.urdf.usual_tip import usual_tip
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from abi.scene.scene import Scene
from abi.verify.verify import verify
from benchmarks.exact_meshes import ExactArm
from benchmarks.report import Row, table

_POSES, _SAMPLES = 200, 401
_SECONDS = 5.0
_FRAMES, _SWING = 9, 0.02
"""Frames of a drag, and how far it goes to each side, over the reach."""
_STEP, _FINE = 0.3, 0.03
"""Ways of the search in the joints, and between the poses that it tries, [rad] or [m]."""


class _Tree:
    """Poses that are joined to a first one by steps that are clear."""

    def __init__(self, first: FloatArray) -> None:
        self.poses = [first]

    def nearest(self, pose: FloatArray) -> FloatArray:
        """The pose in it that is nearest."""
        return self.poses[int(np.linalg.norm(np.stack(self.poses) - pose, axis=1).argmin())]


def rrt_finds(exact: ExactArm, limits: FloatArray, ends: FloatArray, seconds: float) -> bool:
    """Search a motion between two poses (2, n) by two trees (RRT-Connect), trying poses alone."""
    random, start = np.random.default_rng(0), time.process_time()
    trees = _Tree(ends[0]), _Tree(ends[1])
    while time.process_time() - start < seconds:
        target = random.uniform(limits[:, 0], limits[:, 1])
        reached = _extended(exact, trees[0], target, _STEP)
        if reached is not None:
            other = _extended(exact, trees[1], reached, np.inf)
            if other is not None and np.allclose(other, reached):
                return True
        trees = trees[1], trees[0]
    return False


def _extended(exact: ExactArm, tree: _Tree, target: FloatArray, most: float) -> FloatArray | None:
    """Last clear pose on the way from a tree to a target, at most so far; None without any."""
    pose, reached = tree.nearest(target), None
    way = target - pose
    length = float(np.linalg.norm(way))
    count = int(np.ceil(min(length, most) / _FINE))
    for k in range(1, count + 1):
        step = pose + way * min(k * _FINE / length, 1.0)
        if exact.hits(step):
            break
        reached = step
    if reached is not None:
        tree.poses.append(reached)
    return reached


def task(arm: UrdfArm, exact: ExactArm) -> tuple[FloatArray, FloatArray] | None:
    """Two clear poses (2, n) whose tools are apart, and a box (2, 3) between, clear of the arm.

    Args:
        arm: the arm.
        exact: says which poses collide with it.
    """
    random, (low, high) = np.random.default_rng(1), arm.chain.usual_range().T
    clear: list[FloatArray] = []
    floor = float(arm.base[2]) + 0.05 * arm.reach
    for pose in random.uniform(low, high, (_POSES, len(low))):
        ends = Poses.of(arm, pose[None]).ends[0]
        above = arm.tool(pose[None])[0, 2] > floor and ends[:, :, 2].min() > -0.05 * arm.reach
        if above and not exact.hits_itself(pose):
            clear.append(pose)
    for first in clear:
        for last in clear:
            a, b = arm.tool(np.stack([first, last]))
            if not 0.3 * arm.reach < np.linalg.norm(b - a) < 0.8 * arm.reach:
                continue
            box = np.stack([(a + b) / 2, np.full(3, 0.1 * arm.reach)])
            blocked = ExactArm(arm, box)
            if blocked.box_stands_free() and not (blocked.hits(first) or blocked.hits(last)):
                return np.stack([first, last]), box
    return None


def scene_of(
    name: str, arm: UrdfArm, ends: FloatArray, box: FloatArray, files: MeshSource
) -> Scene:
    """The scene of a task: the tool's places at two poses (2, n), and a box (2, 3) between them.

    Args:
        name: of the URDF.
        arm: the arm.
        ends: the poses.
        box: its middle and its size, [m].
        files: source of the URDF.
    """
    tools, reach = arm.tool(ends), arm.reach
    low, high = tools.min(axis=0) - 0.25 * reach, tools.max(axis=0) + 0.25 * reach
    return Scene.from_dict(
        {
            "version": 1,
            "unit": "m",
            "workspace": {"min": low.tolist(), "max": high.tolist()},
            "start": tools[0].tolist(),
            "goal": tools[1].tolist(),
            "obstacles": [{"shape": "box", "size": box[1].tolist(), "position": box[0].tolist()}],
            "mesh": {"pitch": float((high - low).max()) / 12},
            "spline": {"clearance": 0.01 * reach},
            "motion": {"speed": 0.3, "acceleration": 0.6, "deceleration": 0.6, "law": "slowed"},
            "arm": {"model": "urdf", "urdf": name, "base": [0, 0, 0]},
        },
        files,
    )


def measure(robot: Robot, name: str, files: MeshSource) -> Row:
    """Row of an arm that loads."""
    tip = usual_tip(robot)
    joints_to(robot, tip)
    arm = urdf_arm(robot, tip, (0.0, 0.0, 0.0))
    exact = ExactArm(arm)
    low, high = arm.chain.usual_range().T
    poses = np.random.default_rng(2).uniform(low, high, (_POSES, len(low)))
    called = (own_distances(arm, Poses.of(arm, poses)) <= 0).any(axis=1)
    wrong = sum(not exact.hits_itself(pose) for pose in poses[called]) / _POSES
    row: Row = {"joints": len(low), "pieces": len(arm.capsules), "wrong": wrong}
    found = task(arm, exact)
    if found is None:
        return row | {"plan": "no task"}
    ends, box = found
    blocked = ExactArm(arm, box)
    row["rrt"] = rrt_finds(blocked, arm.chain.usual_range(), ends, _SECONDS)
    scene, planner = scene_of(name, arm, ends, box, files), Planner()
    begin = time.process_time()
    plan = planner(scene)
    row["first"] = time.process_time() - begin
    return row | _outcome(plan, blocked) | {"drag": _drag(scene, arm.reach)}


def _drag(scene: Scene, reach: float) -> float:
    """Median processor time of plans in which the obstacle is moved a little, [ms]."""
    planner = Planner(compile=False, effort=HASTY)
    planner(scene, True)
    (box,) = scene.to_dict()["obstacles"]
    times = []
    for step in range(_FRAMES):
        x, y, z = box["position"]
        moved = [x, y, z + _SWING * reach * float(np.sin(step + 1))]
        dragged = scene.replace(obstacles=[{**box, "position": moved}])
        begin = time.process_time()
        planner(dragged, chosen_only=True, hasty=True)
        times.append(1e3 * (time.process_time() - begin))
    return float(np.median(times))


def _outcome(plan: Plan, exact: ExactArm) -> Row:
    """What came of a plan."""
    if plan.error is not None or plan.motion is None or plan.arm_clearance is None:
        return {"plan": "none"}
    if not plan.arm_clearance.certified:
        return {"plan": "not proven"}
    assert len(plan.motion.positions) >= _SAMPLES
    verdict = verify(json.loads(json.dumps(plan.to_dict())), plan.scene.meshes)[-1]
    hits = sum(exact.hits(pose) for pose in plan.motion.positions)
    return {"plan": "proven", "hits": hits, "proof": verdict.proven}


def chosen_files(folder: Path, chosen: str) -> list[str]:
    """URDF files below a folder whose path in it contains a match of a regular expression."""
    names = (file.relative_to(folder).as_posix() for file in sorted(folder.rglob("*.urdf")))
    return [name for name in names if re.search(chosen, name)]


def rows_of(folder: Path, chosen: str, done: frozenset[str]) -> Iterator[Row]:
    """A row for each URDF below a folder whose path contains a match of a regular expression.

    Args:
        folder: of a package.
        chosen: the expression.
        done: files to leave out, each with the folder's name before it.
    """
    for name in chosen_files(folder, chosen):
        label = f"{folder.name}/{name}"
        if label in done:
            continue
        source = MeshSource(folder=folder)
        try:
            robot = load_robot(name, source)
            yield {"file": label} | measure(robot, name, source)
        except SceneError as error:
            yield {
                "file": label,
                "plan": "refused",
                "why": error.message,
                "pin": _pin_reads(folder / name),
            }


def _pin_reads(file: Path) -> bool:
    """Whether Pinocchio reads a file as a robot that moves."""
    try:
        return bool(pinocchio.buildModelFromUrdf(str(file)).nq)
    except ValueError:
        return False


def _shown(row: Row) -> Row:
    """A row of the table: the file's two last names, and times with few digits."""
    text = "/".join(str(row["file"]).split("/")[-2:]).removesuffix(".urdf")
    rounded = {name: value for name, value in row.items() if name not in ("file", "why", "pin")}
    return {"arm": text} | rounded


def main() -> None:
    """Print a row for each arm, and what they say in all."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--match", default="", help="only paths that contain this expression")
    parser.add_argument("--results", type=Path, default=Path("arms.jsonl"), help="file of rows")
    options = parser.parse_args()
    compiling.compile()
    rows: list[Row] = []
    if options.results.exists():
        lines = options.results.read_text(encoding="utf-8").splitlines()
        rows = [json.loads(line) for line in lines]
    done = frozenset(str(row["file"]) for row in rows)
    with options.results.open("a", encoding="utf-8") as lines:
        for folder in options.folders:
            for row in rows_of(folder, options.match, done):
                rows.append(row)
                lines.write(json.dumps(row) + "\n")
                lines.flush()
    print(table([_shown(row) for row in rows]))
    for row in rows:
        if "why" in row:
            print(f"{row['file']}: {row['why']} Pinocchio reads it: {row['pin']}.")
    tried = [row for row in rows if row.get("rrt")]
    proven = [row for row in rows if row.get("plan") == "proven"]
    planned = sum(row in proven for row in tried)
    print(
        f"{len(rows)} arms, {sum('joints' in row for row in rows)} load; where the independent "
        f"search finds a motion, {planned} of {len(tried)} are planned; "
        f"{sum(bool(row['hits']) for row in proven)} of {len(proven)} motions collide, "
        f"{sum(bool(row['proof']) for row in proven)} proofs are confirmed"
    )


if __name__ == "__main__":
    main()

"""Verdicts on paths of OMPL's RRTConnect, which checks edges at samples, as its users do.

    python -m benchmarks.certify_paths records.jsonl --random 0:100
    python -m benchmarks.certify_paths records.jsonl --set vamp_planner-0.6.4.tar.gz --each 3
    python -m benchmarks.certify_paths records.jsonl --table

A run appends a line a path. Every contact that is told is looked up by coal, with the links' exact
meshes, at the time that is told. Every motion that is proven is damaged: a waypoint is shifted, or
a plate of a hundredth of a millimetre is put where a link passes.
"""

from __future__ import annotations

import argparse
import json
import time
import zlib
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.world.collision_world import chain_world
from abi.arm_planning.world.solid_rows import RowTable
from abi.arrays import FloatArray
from abi.certification.certify_motion import certify_motion
from abi.certification.clearance_proof import nearest
from abi.certification.motion import Motion
from abi.certification.robot_scene import robot_scene
from abi.certification.verdict import MotionVerdict, Touch
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from abi.scene.scene import Scene
from benchmarks.certify import obstacle, plate
from benchmarks.motion_bench_oracles import ompl_path, solids_touch
from benchmarks.motion_bench_set import TIP, panda, problems

_ARMS = ("ur5e", "panda", "xarm7")
_SAMPLES = 10_000
_OBSTACLES = 8
_TOUCHING = 1e-6
"""Distance of exact meshes at which coal calls them touching, [m]: about its rounding."""


class Task(NamedTuple):
    """A scene with a robot, and joint positions (n,) at start and goal, [rad]."""

    name: str
    scene: Scene
    arm: UrdfArm
    start: FloatArray
    goal: FloatArray


def main() -> None:
    """Run a piece of the campaign, or print what all pieces have found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("records", type=Path)
    parser.add_argument("--random", default="", help="seeds of random scenes, FIRST:LAST")
    parser.add_argument("--set", type=Path, help="the source distribution with MotionBenchMaker")
    parser.add_argument("--each", type=int, default=3, help="problems of each environment")
    parser.add_argument("--damages", type=int, default=10, help="of each motion that is proven")
    parser.add_argument("--seconds", type=float, default=270, help="no path is begun after that")
    parser.add_argument("--table", action="store_true")
    chosen = parser.parse_args()
    if chosen.table:
        print(table([json.loads(line) for line in chosen.records.read_text().splitlines()]))
        return
    tasks = _of_set(chosen.set, chosen.each) if chosen.set else _random(chosen.random)
    begin, known = time.monotonic(), set()
    if chosen.records.exists():
        lines = chosen.records.read_text().splitlines()
        known = {json.loads(line)["name"] for line in lines}
    with chosen.records.open("a") as file:
        for task in tasks:
            if time.monotonic() - begin > chosen.seconds:
                break
            if task.name not in known:
                print(json.dumps(record(task, chosen.damages)), file=file, flush=True)


def record(task: Task, damages: int) -> dict[str, Any]:
    """What came of a task: the verdict on OMPL's path, and on its damaged forms."""
    metres = task.scene.arm.clearance
    lowest = min(task.scene.arm.base[2], task.scene.workspace.min[2])
    around = chain_world(task.arm, ObstacleSet(task.scene.obstacles), lowest, RowTable())
    path = ompl_path(JointSpace(task.arm, around, metres), task.start, task.goal)
    if path is None:
        return {"name": task.name, "state": "no path"}
    rows = np.arange(float(len(path)))
    motion = Motion(task.arm.joints, rows, path, timed=False)
    begin = time.thread_time()
    verdict = certify_motion(motion, task.scene)
    found: dict[str, Any] = {
        "name": task.name,
        "state": verdict.state,
        "waypoints": len(path),
        "ms": 1e3 * (time.thread_time() - begin),
    }
    if verdict.state == "touches":
        confirmed = [confirms(task, verdict, one) for one in verdict.touches]
        return found | {"contacts": len(confirmed), "confirmed": sum(confirmed)}
    if verdict.state == "clear":
        samples = np.linspace(0, len(path) - 1, _SAMPLES)
        found["refuted"] = bool(nearest(verdict.task, samples).distance < verdict.clearance)
        found |= damaged(task, verdict, motion, damages)
    return found


def confirms(task: Task, verdict: MotionVerdict, touch: Touch) -> bool:
    """Whether coal finds that contact, too, at the time that is told."""
    pose = verdict.task.motion.positions_at(np.array([touch.time]))[0]
    if touch.obstacle == "floor":
        return True  # a height, which needs no oracle
    return solids_touch(task.arm, task.scene.obstacles, pose, touch, _TOUCHING)


def damaged(task: Task, verdict: MotionVerdict, motion: Motion, count: int) -> dict[str, Any]:
    """Verdicts on a motion that was damaged so many times."""
    random = np.random.default_rng(zlib.crc32(task.name.encode()))
    found = {"damaged": 0, "touching": 0, "false": 0}
    for number in range(count):
        scene, moved = task.scene, motion
        if number % 2:
            thin = plate(verdict, int(random.integers(2**31)))
            scene = scene.replace(obstacles=[*scene.obstacles, thin])
        else:
            positions = motion.positions.copy()
            row, joint = random.integers(len(positions)), random.integers(positions.shape[1])
            positions[row, joint] += random.normal(0, 0.4)
            moved = Motion(motion.joints, motion.times, positions, timed=False)
        again = certify_motion(moved, scene)
        found["damaged"] += 1
        found["touching"] += again.state == "touches"
        if again.state == "clear":
            samples = np.linspace(0, len(motion.times) - 1, 1_000)
            touched = nearest(again.task, samples).distance < again.clearance
            found["false"] += bool(number % 2) or bool(touched)
    return found


def table(records: list[dict[str, Any]]) -> str:
    """What all pieces have found, as text."""
    lines = []
    for kind in ("random", "set"):
        some = [one for one in records if one["name"].startswith(kind)]
        paths = [one for one in some if one["state"] != "no path"]
        if not paths:
            continue
        lines.append(f"{kind}: {len(paths)} paths of {len(some)} problems")
        for state in ("clear", "touches", "undecided"):
            times = [one["ms"] for one in paths if one["state"] == state]
            share = len(times) / len(paths)
            middle = f", median {np.median(times):.0f} ms" if times else ""
            lines.append(f"  {state:9} {len(times):4} ({share:.1%}){middle}")
    for name, words in (
        ("contacts", "contacts told"),
        ("confirmed", "of these found by coal"),
        ("refuted", f"proofs refuted by {_SAMPLES:,} samples"),
        ("damaged", "damaged motions"),
        ("touching", "of these found to touch"),
        ("false", "of these called clear although they touch"),
    ):
        lines.append(f"{words}: {sum(one.get(name, 0) for one in records):,}")
    return "\n".join(lines)


def _random(seeds: str) -> Iterator[Task]:
    """Random scenes with random poses at start and goal, both of which are clear."""
    first, _, last = seeds.partition(":")
    for seed in range(int(first or 0), int(last or 0)):
        random = np.random.default_rng(seed)
        name = _ARMS[seed % len(_ARMS)]
        scene, arm = robot_scene(name), _arm(name)
        low, high = np.clip(arm.limits.T, -2.5, 2.5)
        solids = [obstacle(random) for _ in range(_OBSTACLES)]
        scene = scene.replace(obstacles=solids)
        lowest = min(scene.arm.base[2], scene.workspace.min[2])
        around = chain_world(arm, ObstacleSet(scene.obstacles), lowest, RowTable())
        space, ends = JointSpace(arm, around, 0.0), list[FloatArray]()
        for _ in range(2_000):
            pose = random.uniform(low, high)
            if space.clear(np.stack([pose, pose])):
                ends.append(pose)
                if len(ends) == 2:
                    yield Task(f"random {seed}", scene, arm, *ends)
                    break


@lru_cache(maxsize=4)
def _arm(name: str) -> UrdfArm:
    """A shipped arm at the origin."""
    settings = robot_scene(name).arm
    return urdf_arm(settings.robot, settings.tool, (0.0, 0.0, 0.0))


def _of_set(archive: Path, each: int) -> Iterator[Task]:
    """Problems of MotionBenchMaker."""
    arm = panda(archive)
    content = arm.chain.robot.archive
    for one in problems(archive, each):
        scene = robot_scene("panda").replace(
            files={"mbm.zip": content},
            arm={"model": "urdf", "urdf": "mbm.zip", "tip": TIP, "base_link": None},
            obstacles=[shape.model_dump() for shape in one.obstacles],
        )
        yield Task(f"set {one.environment} {one.number}", scene, arm, one.start, one.goal)


if __name__ == "__main__":
    main()

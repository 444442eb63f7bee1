"""Verdicts on paths of OMPL's RRTConnect, which checks poses of exact meshes, as its users do.

    python -m benchmarks.certify_paths records.jsonl --random 0:100
    python -m benchmarks.certify_paths records.jsonl --set vamp_planner-0.6.4.tar.gz --each 3
    python -m benchmarks.certify_paths records.jsonl --table

A run appends a line a path, and goes on where the last one ended. Coal, with the links' exact
meshes, checks poses for OMPL; looks up every contact that is told, at the time that is told; and
looks for contacts at 10,000 poses of every motion that is proven. These are then damaged: a
waypoint is shifted, or a plate of a hundredth of a millimetre is put where a link passes.
"""

from __future__ import annotations

import argparse
import itertools
import json
import time
import zlib
from collections.abc import Iterator
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from abi.arrays import FloatArray
from abi.certification.certify_motion import certify_motion
from abi.certification.clearance_proof import PARTS, nearest, problem_of
from abi.certification.motion import Motion
from abi.certification.robot_motion import robot_motion
from abi.certification.robot_scene import robot_scene
from abi.certification.verdict import MotionVerdict
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from abi.scene.scene import Scene
from benchmarks.certify import compile_kernels, obstacle, plate
from benchmarks.mesh_oracle import MeshOracle
from benchmarks.motion_bench_oracles import ompl_path
from benchmarks.motion_bench_set import TIP, panda, problems

_ARMS = ("ur5e", "panda", "xarm7")
_SAMPLES = 10_000
_OBSTACLES = 8
_STEP = 0.005
"""Way between two poses that OMPL tests, over the extent of the joints: MoveIt's default."""
_CORNERS = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
_THIN = 1e-5
"""Thickness of a plate, [m]."""
_FEW, _NEAR, _BEFORE = 100, 300, 500
"""Poses at which coal looks for plates, beside what was damaged, and before a first contact."""


class Task(NamedTuple):
    """A scene with a robot, and joint positions (n,) at start and goal, [rad]."""

    name: str
    scene: Scene
    arm: UrdfArm
    start: FloatArray
    goal: FloatArray

    def motion(self, path: FloatArray) -> Motion:
        """A path (k, n) as a motion without times."""
        return Motion(self.arm.joints, np.arange(float(len(path))), path, timed=False)


def main() -> None:
    """Run a piece of the campaign, or print what all pieces have found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("records", type=Path)
    parser.add_argument("--random", default="", help="seeds of random scenes, FIRST:LAST")
    parser.add_argument("--set", type=Path, help="the source distribution with MotionBenchMaker")
    parser.add_argument("--each", type=int, default=3, help="problems of each environment")
    parser.add_argument("--damages", type=int, default=20, help="of each motion that is proven")
    parser.add_argument("--seconds", type=float, default=270, help="no path is begun after that")
    parser.add_argument("--again", action="store_true", help="what was not decided")
    parser.add_argument("--table", action="store_true")
    chosen = parser.parse_args()
    if chosen.table:
        print(table([*_read(chosen.records).values()]))
        return
    compile_kernels()
    tasks = _of_set(chosen.set, chosen.each) if chosen.set else _random(chosen.random)
    begin, known = time.monotonic(), _read(chosen.records)
    with chosen.records.open("a") as file:
        for problem in tasks:
            if time.monotonic() - begin > chosen.seconds:
                break
            last = known.get(problem.name)
            if last is None or (chosen.again and "path" in last):
                print(json.dumps(record(problem, chosen.damages, last)), file=file, flush=True)


def record(problem: Task, damages: int, last: dict[str, Any] | None = None) -> dict[str, Any]:
    """What came of a problem: the verdict on OMPL's path, and on its damaged forms.

    Args:
        problem: the problem.
        damages: how many forms.
        last: the last record of the problem, whose path is taken.
    """
    oracle = _oracle(problem)
    step = _STEP * float(np.linalg.norm(np.ptp(problem.arm.limits, axis=1)))
    is_clear = partial(_is_clear, oracle)
    if last is None:
        path = ompl_path(is_clear, problem.arm.limits, problem.start, problem.goal, step)
    else:
        path = np.array(last["path"])
    if path is None:
        return {"name": problem.name, "state": "no path"}
    motion = problem.motion(path)
    begin = time.thread_time()
    verdict = certify_motion(motion, problem.scene)
    found: dict[str, Any] = {
        "name": problem.name,
        "state": verdict.state,
        "waypoints": len(path),
        "ms": 1e3 * (time.thread_time() - begin),
    }
    if verdict.state == "touches":
        found |= confirmed(oracle, verdict)
    elif verdict.state == "undecided":
        found |= {"sentence": verdict.sentence, "path": path.tolist()}
    else:
        samples = np.linspace(0, len(path) - 1, _SAMPLES)
        nearer = nearest(verdict.problem, samples)[0] < verdict.clearance
        touched = oracle.touches(verdict.problem.motion.positions_at(samples))
        found["refuted"] = bool(nearer or touched)
        found |= damaged(problem, verdict, path, damages)
    return found


def confirmed(oracle: MeshOracle, verdict: MotionVerdict) -> dict[str, int]:
    """How many contacts are told, and of how many coal finds time, depth, and none before."""
    motion = verdict.problem.motion
    touches = verdict.touches
    at = [motion.positions_at(np.array([one.first, one.time])) for one in touches]
    before = np.linspace(0, max(touches[0].first - len(motion.points) / PARTS, 0), _BEFORE)
    return {
        "contacts": len(touches),
        "confirmed": sum(map(oracle.confirms, [one[0] for one in at], touches)),
        "deep": sum(map(oracle.confirms_depth, [one[1] for one in at], touches)),
        "early": int(oracle.touches(motion.positions_at(before))),
    }


def damaged(problem: Task, verdict: MotionVerdict, path: FloatArray, count: int) -> dict[str, int]:
    """Verdicts on a motion that was damaged so many times."""
    random = np.random.default_rng(zlib.crc32(problem.name.encode()))
    names = ("damaged", "hit", "touching", "doubted", "unseen", "false")
    found = dict.fromkeys(names, 0)
    for number in range(count):
        scene, moved, kind = problem.scene, path.copy(), number % 3
        if kind == 0:
            at, joint = float(random.integers(len(path))), random.integers(path.shape[1])
            moved[int(at), joint] += random.normal(0, 0.4)
        else:
            put = plate if kind == 1 else grazed
            thin, at = put(verdict, int(random.integers(2**31)))
            scene = scene.replace(obstacles=[*scene.obstacles, thin])
        again = certify_motion(problem.motion(moved), scene)
        oracle, motion = MeshOracle(again.problem), again.problem.motion
        near = np.linspace(max(at - 1, 0), min(at + 1, len(path) - 1), _NEAR)
        hit = oracle.touches(motion.positions_at(np.insert(near, 0, at)))
        found["damaged"] += 1
        found["hit"] += hit
        found["touching"] += again.state == "touches"
        found["doubted"] += again.state == "undecided"
        found["false"] += hit and again.state == "clear"
        if hit and kind:
            few = np.linspace(0, len(path) - 1, _FEW)
            found["unseen"] += not oracle.touches(motion.positions_at(few))
    return found


def grazed(verdict: MotionVerdict, seed: int) -> tuple[dict[str, Any], float]:
    """A small plate that the last link grazes between two waypoints, and the parameter there."""
    random = np.random.default_rng(seed)
    motion, chain = verdict.problem.motion, verdict.problem.chain
    last = [link for link in chain.frames if chain.robot.links[link].shapes][-1]
    shape = chain.robot.links[last].shapes[0]
    pose = chain.places[last] @ shape.pose
    corners = shape.vertices if len(shape.vertices) else (_CORNERS - 0.5) * shape.size
    corners = corners @ pose[:3, :3].T + pose[:3, 3]
    at = random.integers(len(motion.points)) + np.linspace(0, 1, 201)
    frames = chain.poses(motion.positions_at(at))[:, chain.frames[last]]
    for _ in range(20):
        normal = random.normal(size=3)
        normal /= np.linalg.norm(normal)
        heights = normal @ frames[:, :, :3] @ corners.T + (frames[:, :, 3] @ normal)[:, None]
        highest, corner = np.unravel_index(int(heights.argmax()), heights.shape)
        if 0 < highest < len(at) - 1:
            break
    frame = frames[highest]
    place = frame[:, :3] @ corners[corner] + frame[:, 3]
    quaternion = np.array([1 + normal[2], -normal[1], normal[0], 0.0])
    wxyz = (quaternion / np.linalg.norm(quaternion)).tolist()
    size = [0.05, 0.05, _THIN]
    thin = {"shape": "box", "size": size, "position": place.tolist(), "wxyz": wxyz}
    return thin, float(at[highest])


def _oracle(problem: Task) -> MeshOracle:
    """The exact shapes of a problem."""
    straight = problem.motion(np.stack([problem.start, problem.goal]))
    return MeshOracle(problem_of(robot_motion(straight, problem.scene, None), problem.scene))


def _is_clear(oracle: MeshOracle, pose: FloatArray) -> bool:
    """Whether nothing touches at a pose (n,)."""
    return not oracle.touches(pose[None])


def _read(records: Path) -> dict[str, dict[str, Any]]:
    """The last record of each problem that there is, by its name."""
    lines = records.read_text().splitlines() if records.exists() else []
    return {one["name"]: one for one in map(json.loads, lines)}


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
        ("confirmed", "of these found by coal at the time told"),
        ("deep", "of these as deep as told"),
        ("early", "motions that coal finds to touch before"),
        ("refuted", f"proofs refuted by {_SAMPLES:,} samples"),
        ("damaged", "damaged motions"),
        ("hit", "of these touching by coal"),
        ("touching", "of these touching by the verdict"),
        ("doubted", "of these not decided"),
        ("unseen", f"of these with a plate that {_FEW} samples do not see"),
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
        arm = _arm(name)
        low, high = np.clip(arm.limits.T, -2.5, 2.5)
        solids = [obstacle(random) for _ in range(_OBSTACLES)]
        scene = robot_scene(name).replace(obstacles=solids)
        oracle = _oracle(Task("", scene, arm, low, high))
        poses = random.uniform(low, high, (2_000, len(low)))
        clear = filter(partial(_is_clear, oracle), poses)
        ends = list(itertools.islice(clear, 2))
        if len(ends) == 2:
            yield Task(f"random {seed}", scene, arm, *ends)


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

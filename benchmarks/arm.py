"""The whole arm: motions found and refuted in random scenes, and the frames of a drag.

    python -m benchmarks.arm 2000 --results arm.jsonl

The campaign is that of :mod:`benchmarks.arm_campaign`. What came of each scene is a line of the
file, and what stands there is not done again: a run may be stopped, or split by ``--first``. The
table is of all scenes in it. ``--drags`` adds the frames of an obstacle that is dragged where
the tool's own plan is not clear for the arm: with both elbows at 2,300 nodes, with the elbow in use
at 20,000; and the shadow that follows it.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np

from abi import compiling
from abi.arm_planning.exclusion.paper_arm_regions import shadow
from abi.arm_planning.paper_arm_model import paper_arm
from abi.arm_planning.world.arm_worlds import paper_arm_world
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from benchmarks.arm_campaign import Record, figures, record
from benchmarks.quality import is_ompl_installed
from benchmarks.report import Row, table
from tests.random_arms import arm_scene

_DRAGS = ((0.54, "auto", 2_300), (0.262, "up", 20_000))
_STEPS = 12
_SWING = 0.3  # of an obstacle to each side, [unit]


def measure(scenes: int) -> list[Row]:
    """Rows of the campaign and of the drags.

    Args:
        scenes: how many random scenes; a tenth of them is dragged in.
    """
    compiling.compile()
    is_ompl_installed()  # says so where it is not: its rows are left out
    rows = figures([record(seed) for seed in range(scenes)])
    return rows + drags(max(scenes // 10, 5))


def campaign(scenes: range, file: Path, seconds: float) -> list[Record]:
    """Records of all scenes in a file, with those of ``scenes`` that were not there.

    Args:
        scenes: their numbers.
        file: JSON, a line a scene; it need not be there yet.
        seconds: after which no other scene is begun.
    """
    records: list[Record] = []
    if file.exists():
        records = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]
    done = {one["seed"] for one in records}
    end = time.monotonic() + seconds
    with file.open("a", encoding="utf-8") as lines:
        for seed in scenes:
            if seed not in done and time.monotonic() < end:
                records.append(record(seed))
                lines.write(json.dumps(records[-1]) + "\n")
                lines.flush()
    return records


def drag(pitch: float, elbow: str, nodes: int, scenes: int) -> Row:
    """Times of frames in which one obstacle moves."""
    frames: list[float] = []
    avoided = dragged = seed = 0
    while dragged < scenes:
        scene = arm_scene(seed, pitch, boxes=True).replace(arm={"elbow": elbow})
        planner, seed = Planner(compile=False), seed + 1
        if planner(scene, True).tool_only is None:
            continue
        dragged += 1
        for step in range(_STEPS):
            moved = _moved(scene, _SWING * np.sin(2 * np.pi * step / _STEPS))
            begin = time.thread_time()
            plan = planner(moved, True)
            frames.append(1e3 * (time.thread_time() - begin))
            avoided += plan.tool_only is not None
    return {
        "method": f"drag, elbow {elbow}",
        "nodes": nodes,
        "frames": len(frames),
        "avoiding": avoided,
        "ms": float(np.median(frames)),
        "95 %": float(np.percentile(frames, 95)),
    }


def shadow_drag(pitch: float, nodes: int, scenes: int) -> Row:
    """Times in which the shadow of an obstacle that moves is made anew, after the re-plan."""
    times: list[float] = []
    for seed in range(scenes):
        scene = arm_scene(seed, pitch, boxes=True)
        arm, box = paper_arm(scene.arm), scene.workspace
        for step in range(_STEPS):
            moved = _moved(scene, _SWING * np.sin(2 * np.pi * step / _STEPS))
            begin = time.thread_time()
            collision_world = paper_arm_world(arm, ObstacleSet(moved.obstacles), box.min[2])
            shadow(arm, "up", scene.arm.q5, collision_world, (box.min, box.max))
            times.append(1e3 * (time.thread_time() - begin))
    return {
        "method": "shadow",
        "nodes": nodes,
        "frames": len(times),
        "ms": float(np.median(times)),
        "95 %": float(np.percentile(times, 95)),
    }


def drags(scenes: int) -> list[Row]:
    """Rows of the frames of drags in so many scenes, and of the shadow that follows."""
    pitch, _, nodes = _DRAGS[0]
    rows = [drag(*setting, scenes) for setting in _DRAGS]
    return [*rows, shadow_drag(pitch, nodes, scenes)]


def _moved(scene: Scene, by: float) -> Scene:
    """The scene with its first obstacle a little to the side."""
    obstacles = scene.to_dict()["obstacles"]
    x, y, z = obstacles[0]["position"]
    first = {**obstacles[0], "position": [x + by, y, z]}
    return scene.replace(obstacles=[first, *obstacles[1:]])


def main() -> None:
    """Run the campaign and print its tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("scenes", type=int, nargs="?", default=100)
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--results", type=Path, default=Path("arm.jsonl"), help="file of records")
    parser.add_argument("--seconds", type=float, default=np.inf, help="after which it stops")
    parser.add_argument("--drags", type=int, default=0, help="scenes that are dragged in")
    options = parser.parse_args()
    compiling.compile()
    is_ompl_installed()  # says so where it is not: its rows are left out
    scenes = range(options.first, options.first + options.scenes)
    found = figures(campaign(scenes, options.results, options.seconds))
    print(table(found[:1]), table(found[1:]), sep="\n\n")
    if options.drags:
        print(table(drags(options.drags)))


if __name__ == "__main__":
    main()

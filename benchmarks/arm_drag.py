"""Re-plans of a drag: UR5e among ten boxes, of which one is moved.

    python -m benchmarks.arm_drag

``past`` moves it below the way of the tool, which it leaves free; ``across`` moves it through that
way, so that the whole arm avoids it in some of the frames. Times are of the processor, [ms], with
the effort of a planner that somebody waits for; ``avoiding`` counts the frames in which the arm
leaves the way that the tool alone would take.
"""

from __future__ import annotations

import time

import numpy as np

from abi import compiling
from abi.arrays import FloatArray
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from benchmarks.report import Row, table

_FRAMES, _OTHERS = 61, 9
_START, _GOAL, _MIDDLE = (0.5, -0.35, 0.4), (0.5, 0.35, 0.4), (0.6, 0.0, 0.4)
_ROOM = 0.2
"""Distance of the other boxes from start and goal, [m]."""


def other_boxes() -> FloatArray:
    """Random places (9, 3) of boxes beside the base and the tool's way, [m]."""
    random, found = np.random.default_rng(3), list[FloatArray]()
    low, high = np.array([-0.7, -0.7, 0.1]), np.array([0.7, 0.7, 0.9])
    while len(found) < _OTHERS:
        place = random.uniform(low, high)
        from_ends = min(np.linalg.norm(place - end) for end in (_START, _GOAL))
        from_way = np.linalg.norm(place - _MIDDLE)
        if np.linalg.norm(place[:2]) > 0.3 and from_ends > _ROOM and from_way > 0.25:
            found.append(place.round(3))
    return np.array(found)


def scene_with(boxes: FloatArray) -> Scene:
    """The arm among boxes (k, 3)."""
    each = [{"shape": "box", "size": [0.1] * 3, "position": place} for place in boxes.tolist()]
    return Scene.from_dict(
        {
            "version": 1,
            "unit": "m",
            "workspace": {"min": [-0.75, -0.75, 0.05], "max": [0.75, 0.75, 0.95]},
            "start": list(_START),
            "goal": list(_GOAL),
            "obstacles": each,
            "mesh": {"pitch": 0.06},
            "spline": {"clearance": 0.01},
            "arm": {"model": "urdf", "urdf": "ur5e", "base": [0, 0, 0]},
        }
    )


def measure(name: str, way: FloatArray, others: FloatArray) -> Row:
    """Row of a drag of one box along places (k, 3)."""
    planner, times, avoiding, without = Planner(compile=False), list[float](), 0, 0
    planner(scene_with(np.concatenate([others, way[:1]])), True)
    for place in way:
        scene = scene_with(np.concatenate([others, place[None]]))
        begin = time.process_time()
        plan = planner(scene, chosen_only=True, hasty=True)
        times.append(1e3 * (time.process_time() - begin))
        avoiding += plan.tool_only is not None
        without += plan.error is not None
    median, most = np.percentile(times, [50, 95]).tolist()
    row: Row = {"drag": name, "median": median, "95 %": most, "longest": max(times)}
    return row | {"avoiding": avoiding, "no plan": without}


def main() -> None:
    """Print a row for each of two drags."""
    compiling.compile()
    others, t = other_boxes(), np.linspace(0.0, 1.0, _FRAMES)
    x = np.full(_FRAMES, 0.5)
    past = np.stack([x, -0.3 + 0.6 * t, np.full(_FRAMES, 0.15)], axis=1)
    steps = np.arange(_FRAMES)
    across = np.stack([x, 0.02 * np.sin(steps), 0.4 + 0.15 * np.cos(steps / 5)], axis=1)
    print(table([measure("past", past, others), measure("across", across, others)]))


if __name__ == "__main__":
    main()

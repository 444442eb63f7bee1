"""Records of plans, to compare two versions of the method bit for bit.

    python -m benchmarks.plan_records before.jsonl          # at the one commit
    python -m benchmarks.plan_records after.jsonl --compare before.jsonl

A line of a record is a scene: the shipped ones, and random ones for the tool alone, for the paper's
arm and for arms of URDFs. It has a digest of each part of the plan, of every array and number in it
but the times; of a second plan, after an obstacle has moved, by the planner that remembers the
first; and of the plan as JSON. Classes and fields may be renamed, but must keep their order.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from abi import compiling
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import Scene, load_scene, scene_names
from tests.random_arms import arm_scene
from tests.random_scenes import random_scene

_LEFT_OUT = ("scene", "ms", "interpreted", "total_ms")
"""What is no result of the method, or differs from run to run."""
_ARMS = ("ur5e", "panda", "xarm7")
_STEP = 0.04
"""Way by which an obstacle moves, as a part of the workspace's first side."""

Record = dict[str, Any]


def record(name: str, scene: Scene) -> Record:
    """Digests of the parts of two plans of a scene, the second after its first obstacle moved."""
    planner = Planner(compile=False)
    found: Record = {"scene": name, "first": _digests(planner(scene))}
    if scene.obstacles:
        obstacle = scene.obstacles[0]
        x, y, z = obstacle.position
        low, high = scene.workspace.min[0], scene.workspace.max[0]
        moved = obstacle.model_copy(update={"position": (x + _STEP * (high - low), y, z)})
        others = scene.obstacles[1:]
        again = planner(scene.model_copy(update={"obstacles": (moved, *others)}), chosen_only=True)
        found["again"] = _digests(again)
    return found


def scenes(count: int) -> Iterator[tuple[str, Scene]]:
    """The shipped scenes, and so many random ones, by their names."""
    for name in scene_names():
        yield name, load_scene(name)
    for seed in range(count):
        kind = seed % 10
        if kind < 5:
            yield f"tool {seed}", random_scene(seed)
        elif kind < 9:
            yield f"arm {seed}", arm_scene(seed, boxes=kind == 5, meshes=kind == 8)
        else:
            yield f"urdf {seed}", urdf_scene(seed)


def urdf_scene(seed: int) -> Scene:
    """A shipped arm among boxes and balls at random, in metres."""
    random = np.random.default_rng(seed)
    low, high = np.array([-0.5, 0.15, 0.1]), np.array([0.5, 0.75, 0.7])
    obstacles: list[dict[str, Any]] = []
    for _ in range(int(random.integers(1, 6))):
        place = random.uniform(low, high).tolist()
        if random.random() < 0.7:
            size = random.uniform(0.04, 0.3, 3).tolist()
            obstacles.append({"shape": "box", "size": size, "position": place})
        else:
            radius = float(random.uniform(0.03, 0.12))
            obstacles.append({"shape": "sphere", "radius": radius, "position": place})
    axis = [None, [0, 0, -1]][int(random.integers(2))]
    return Scene.from_dict(
        {
            "version": 1,
            "unit": "m",
            "workspace": {"min": low.tolist(), "max": high.tolist()},
            "start": [-0.4, *random.uniform([0.3, 0.15], [0.6, 0.5]).tolist()],
            "goal": [0.4, *random.uniform([0.3, 0.15], [0.6, 0.5]).tolist()],
            "obstacles": obstacles,
            "mesh": {"lattice": "bcc", "pitch": 0.08},
            "spline": {"degree": 4, "clearance": 0.02},
            "motion": {"speed": 0.5, "acceleration": 1, "deceleration": 1},
            "arm": {
                "model": "urdf",
                "urdf": _ARMS[int(random.integers(len(_ARMS)))],
                "base": [0, 0, 0],
                "axis": axis,
            },
        }
    )


def differences(before: Record, after: Record) -> list[str]:
    """Parts of a scene's plans that differ."""
    return [
        f"{after['scene']}: {which} {part}"
        for which in ("first", "again")
        for part, digest in before.get(which, {}).items()
        if after.get(which, {}).get(part) != digest
    ]


def _digests(plan: Plan) -> dict[str, str]:
    parts = {one.name: getattr(plan, one.name) for one in dataclasses.fields(plan)}
    found = {name: _digest(value) for name, value in parts.items() if name not in _LEFT_OUT}
    data = plan.to_dict()
    del data["scene"]
    text = json.dumps(_without_times(data), sort_keys=True)
    outcome = "" if plan.error is None else plan.error.kind
    return found | {"json": hashlib.sha256(text.encode()).hexdigest()[:16], "outcome": outcome}


def _digest(value: object) -> str:
    digest = hashlib.sha256()
    for content in _contents(value):
        digest.update(content)
    return digest.hexdigest()[:16]


def _contents(value: object) -> Iterator[bytes]:
    """Numbers, arrays and texts in a result, in the order of its fields."""
    if isinstance(value, np.ndarray):
        yield f"{value.shape}{value.dtype}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif isinstance(value, str | bytes | int | float | None | np.generic):
        yield repr(value).encode()
    elif isinstance(value, dict):
        yield from _contents(list(value.items()))
    elif isinstance(value, list | tuple):
        for one in value:
            yield from _contents(one)
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from _contents(getattr(value, field.name))
    elif hasattr(value, "model_dump_json"):
        yield value.model_dump_json().encode()
    elif isinstance(value, BaseException):
        yield str(value).encode()


def _without_times(data: Any) -> Any:
    if isinstance(data, dict):
        return {k: _without_times(v) for k, v in data.items() if not k.endswith("ms")}
    return [_without_times(one) for one in data] if isinstance(data, list) else data


def main() -> None:
    """Record the plans that the file has not yet, and compare them where asked."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("file", type=Path, help="JSON, a line a scene; what is there stays")
    parser.add_argument("--scenes", type=int, default=1_000, help="random ones")
    parser.add_argument("--compare", type=Path, help="a record of another version")
    options = parser.parse_args()
    compiling.compile()
    records = _read(options.file)
    with options.file.open("a", encoding="utf-8") as lines:
        for name, scene in scenes(options.scenes):
            if name not in records:
                records[name] = record(name, scene)
                lines.write(json.dumps(records[name]) + "\n")
                lines.flush()
    if options.compare:
        before = _read(options.compare)
        both = [name for name in records if name in before]
        changed = [line for name in both for line in differences(before[name], records[name])]
        print(*changed, f"{len(both)} scenes compared, {len(changed)} parts differ", sep="\n")
        raise SystemExit(bool(changed))


def _read(file: Path) -> dict[str, Record]:
    if not file.exists():
        return {}
    lines = file.read_text(encoding="utf-8").splitlines()
    return {one["scene"]: one for one in map(json.loads, lines)}


if __name__ == "__main__":
    main()

"""Check of the plans of a sequence of tasks: each leg begins where the last one ended.

What each leg's certificate proves is checked by itself; here it is checked that the legs are those
of the tasks. That code is not used which makes the scenes of legs.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.pose import METRES, rotation
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.scene.scene import Scene
from abi.verify.exact.robot_chain import exact_chain
from abi.verify.fault import Fault
from abi.verify.plan_fields import list_of, mapping, numbers_of

_SAME = 1e-9
"""Accepted difference between joints, [rad] or [unit], and of poses, over their size."""
_OF_LEG = ("start", "goal", "obstacles", "tasks", "arm")
_OF_LEG_ARM = ("start", "goal", "gripper", "axis", "attached", "allowed", "grasping")
"""Fields of a scene, and of its arm, that differ from leg to leg."""


def check_tasks(plan: dict[str, Any], scene: Scene, source: MeshSource) -> str:
    """Check that legs join, and return what holds as the end of a sentence.

    Args:
        plan: the plan of the tasks as plain data.
        scene: its scene.
        source: of the mesh files.

    Raises:
        Fault: they do not.
        SceneError: a field has the wrong form.
    """
    legs = [mapping("legs", leg) for leg in list_of("legs", plan.get("legs"))]
    if len(legs) != max(len(scene.tasks), 1):
        raise Fault(f"it has {len(legs)} legs, and {max(len(scene.tasks), 1)} are asked for")
    whole = scene.to_dict()
    obstacles, allowed = whole["obstacles"], whole["arm"]["allowed"]
    held, place, gripper = whole["arm"]["attached"], len(obstacles), whole["arm"]["gripper"]
    rows: list[list[float]] = []
    moving: list[str] = []
    for number, leg in enumerate(legs):
        here, label = (
            Scene.from_dict(mapping("legs", leg.get("scene")), source),
            f"leg {number + 1}",
        )
        data, task = here.to_dict(), whole["tasks"][number] if whole["tasks"] else {}
        before, gripper = gripper, {**gripper, **(task.get("gripper") or {})}
        if number > 0 and gripper != before:
            moving.append(str(number + 1))
        last = whole["tasks"][number - 1] if number > 0 else {}
        may_grasp = _grasps(task) or _grasps(last) if whole["tasks"] else whole["arm"]["grasping"]
        if data["arm"]["grasping"] and not may_grasp:
            raise Fault(
                f"{label} keeps less distance than where objects are neither taken nor left"
            )
        _check_same(label, data, whole, gripper)
        if data["arm"]["axis"] != (task.get("axis") if number > 0 else whole["arm"]["axis"]):
            raise Fault(f"{label} keeps another direction of the gripper than is asked for")
        asked = scene.tasks[number].goal if scene.tasks else None
        if number == 0:
            if (here.start, here.arm.start) != (scene.start, scene.arm.start):
                raise Fault(f"{label} begins elsewhere than is asked for")
            asked = asked or scene.arm.goal or scene.goal
        _check_goal(label, here, asked)
        positions = _positions(leg)
        if rows and np.abs(np.subtract(rows[-1], positions[0])).max() > _SAME:
            raise Fault(f"the joints jump where {label} begins")
        _check_things(label, data, obstacles, held, allowed)
        rows += positions[1:] if rows else positions
        tool = _tool(here, positions[-1])
        if task.get("attach") is not None:
            place = task["attach"]
            held = _posed(np.linalg.inv(tool).astype(np.float64), obstacles[place])
            obstacles = obstacles[:place] + obstacles[place + 1 :]
            allowed = [
                [link, other - (other > place) if type(other) is int else other]
                for link, other in whole["arm"]["allowed"]
                if other != place
            ]
        elif task.get("release"):
            obstacles = [*obstacles[:place], _posed(tool, held), *obstacles[place:]]
            held, allowed = None, whole["arm"]["allowed"]
    _check_trajectory(mapping("trajectory", plan.get("trajectory")), legs, rows)
    moved = sum(task.attach is not None for task in scene.tasks)
    carried = ", and what is held is where the gripper took it" if moved else ""
    unproven = f"; not proven is how the gripper moves before leg {', '.join(moving)}"
    joined = f"{len(legs)} legs join without a jump of the joints{carried}"
    return f"{joined}{unproven}" if moving else joined


def _check_trajectory(
    trajectory: dict[str, Any], legs: list[dict[str, Any]], rows: list[list[float]]
) -> None:
    """Raise a Fault if a trajectory is not that of the legs, whose joints go through ``rows``."""
    names = [mapping("arm", leg.get("arm")).get("joints") for leg in legs]
    if any(one != trajectory.get("joints") for one in names):
        raise Fault("its trajectory names other joints than the legs")
    times = numbers_of("trajectory.time", trajectory.get("time"))
    if len(times) != len(rows) or np.abs(np.subtract(times, _times(legs))).max() > _SAME:
        raise Fault("its trajectory's samples have not one time each, that of their legs")
    if [numbers_of("trajectory", row) for row in trajectory.get("positions", [])] != rows:
        raise Fault("its trajectory is not that of the legs")
    counts = [len(_positions(leg)) - (number > 0) for number, leg in enumerate(legs)]
    if trajectory.get("leg") != np.repeat(np.arange(len(legs)), counts).tolist():
        raise Fault("its trajectory's samples are said to be of other legs")
    begins = numbers_of("trajectory.begins", trajectory.get("begins"))
    joins = [times[end - 1] for end in (1, *np.cumsum(counts))]
    if len(begins) != len(joins) or np.abs(np.subtract(begins, joins)).max() > _SAME:
        raise Fault("its trajectory's legs are said to begin at other times")


def _times(legs: list[dict[str, Any]]) -> list[float]:
    """Times of the poses of all legs, one after the other, each evenly in its leg, [s]."""
    found = [0.0]
    for leg in legs:
        times = numbers_of("arm.time", mapping("arm", leg.get("arm")).get("time"))
        if not times:
            raise Fault("a leg's samples have no times")
        even = np.linspace(0.0, times[-1], len(_positions(leg)))[1:]
        begin = found[-1]
        found += [begin + time for time in even.tolist()]
    return found


def _grasps(task: dict[str, Any]) -> bool:
    """Check whether an object is taken or released at the end of a leg."""
    return task.get("attach") is not None or bool(task.get("release"))


def _check_same(
    label: str, leg: dict[str, Any], whole: dict[str, Any], gripper: dict[str, Any]
) -> None:
    """Raise if a leg's scene differs in other ways than legs may."""
    fields = {name: value for name, value in leg.items() if name not in _OF_LEG}
    arm = {name: value for name, value in leg["arm"].items() if name not in _OF_LEG_ARM}
    same = all(whole[name] == value for name, value in fields.items())
    if not same or any(whole["arm"][name] != value for name, value in arm.items()):
        raise Fault(f"{label} has other settings than the scene")
    if leg["arm"]["gripper"] != gripper:
        raise Fault(f"the gripper of {label} is held otherwise than is asked for")


def _check_goal(label: str, leg: Scene, asked: Any) -> None:
    """Raise if a leg has another goal than its task."""
    is_point = isinstance(asked, tuple)
    if (leg.goal if is_point else leg.arm.goal) != asked or (is_point and leg.arm.goal):
        raise Fault(f"{label} has another goal than is asked for")


def _check_things(
    label: str,
    leg: dict[str, Any],
    obstacles: list[dict[str, Any]],
    held: dict[str, Any] | None,
    allowed: list[Any],
) -> None:
    """Raise if obstacles, or what is held, are not where the last leg left them."""
    if leg["arm"]["allowed"] != allowed:
        raise Fault(f"{label} allows other contacts than the scene")
    if len(leg["obstacles"]) != len(obstacles):
        raise Fault(f"{label} has {len(leg['obstacles'])} obstacles instead of {len(obstacles)}")
    for one, other in zip(leg["obstacles"], obstacles, strict=True):
        if not _is_same(one, other):
            raise Fault(f"an obstacle of {label} is not where it was left")
    given = leg["arm"]["attached"]
    if (given is None) != (held is None) or (held is not None and not _is_same(given, held)):
        raise Fault(f"what is held on {label} is not what was attached")


def _is_same(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Check whether two shapes are the same, in the same place."""
    names = {*one, *other} - {"position", "wxyz"}
    if any(one.get(name) != other.get(name) for name in names):
        return False
    size = 1 + float(np.abs(other["position"]).max())
    turned = np.abs(rotation(tuple(one["wxyz"])) - rotation(tuple(other["wxyz"]))).max()
    moved = np.abs(np.subtract(one["position"], other["position"])).max()
    return bool(turned <= _SAME and moved <= _SAME * size)


def _posed(pose: FloatArray, shape: dict[str, Any]) -> dict[str, Any]:
    """A shape in another frame, in which the pose (4, 4) is that of the shape's frame."""
    a, b, c, d = _quaternion(pose[:3, :3])
    w, x, y, z = shape["wxyz"]
    wxyz = [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
    position = pose[:3, :3] @ np.array(shape["position"]) + pose[:3, 3]
    return {**shape, "position": position.tolist(), "wxyz": wxyz}


def _quaternion(turn: FloatArray) -> FloatArray:
    """Quaternion of a rotation: the eigenvector of a symmetric matrix (Bar-Itzhack, 2000)."""
    (a, b, c), (d, e, f), (g, h, i) = turn
    matrix = np.array(
        [
            [a + e + i, h - f, c - g, d - b],
            [h - f, a - e - i, b + d, c + g],
            [c - g, b + d, e - a - i, f + h],
            [d - b, c + g, f + h, i - a - e],
        ]
    )
    return np.asarray(np.linalg.eigh(matrix)[1][:, -1])


def _positions(leg: dict[str, Any]) -> list[list[float]]:
    """Joint positions between which the joints go straight on a leg."""
    certificate = mapping("arm", leg.get("arm")).get("certificate")
    rows = list_of("positions", mapping("arm.certificate", certificate).get("positions"))
    if len(rows) < 2:
        raise Fault("a leg has no motion")
    return [numbers_of("positions", row) for row in rows]


def _tool(scene: Scene, joints: list[float]) -> FloatArray:
    """World from tip at joint positions, (4, 4), [unit]."""
    arm = scene.arm
    units = round(1 / METRES[scene.unit])
    chain = exact_chain(scene.robot, arm.tool, arm.base, units, arm.base_wxyz, arm.gripper)
    frame = chain.place([Fraction(number) for number in joints])[-1]
    pose = np.eye(4)
    pose[:3, :3] = frame.turn.astype(float) / 2.0**200
    pose[:3, 3] = frame.origin.astype(float) / 2.0**200
    return pose

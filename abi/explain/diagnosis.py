"""Diagnosis of a scene without a plan: the reason, and a tested remedy."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from abi.arm_planning.arm_errors import DIRECTION_NOT_HELD, ArmNotClear, NoJointMotion
from abi.arrays import FloatArray, IntArray, read_only
from abi.curves.bspline import BSpline
from abi.curves.fit import Fit
from abi.errors import (
    BLOCKED,
    NO_PATH,
    NOT_HELD,
    format_length,
    format_point,
    in_unit,
)
from abi.explain.arm_diagnosis import arm_reason
from abi.explain.held_direction_diagnosis import held_direction_reason
from abi.explain.nearest_free_point import nearest_free_point, rounded
from abi.explain.reason import Reason
from abi.explain.what_if import WhatIf, components, rounded_down
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.plan import Plan
from abi.progress import CancelledError, watched_by
from abi.scene.scene import Scene
from abi.scene.without_obstacles import without_obstacles
from abi.search.graph import Graph

_SEEDS = 64  # free nodes from which the nearest free point is sought
_NEIGHBOURS = 32  # nodes that an isolated start might have been joined to
_SAMPLES = 400  # of a path, to find its narrowest point
_NAMED = 6  # obstacles in one sentence
_SHARES = (1.0, 0.5, 0.25, 0.0)  # of the largest clearance that frees both ends, to try
_LATE = ("bspline", "arm")  # stages of whose remedies a hint says that they work


def explain(
    scene: Scene, plan: Plan, cancelled: Callable[[], bool] = lambda: False
) -> Reason | None:
    """Find out why ``plan`` has an error, by planning scenes that differ a little.

    - start or goal blocked: how deep, the nearest free point, the clearance that would do;
    - no path: a finer pitch that works, else the largest clearance that does, else both; else the
      obstacles that wall in start or goal;
    - clearance not held: the largest clearance that can be held;
    - arm not clear: another elbow, base or pitch, or one obstacle less;
    - direction not held: a shorter part of the motion that keeps it, or a larger tolerance.

    It takes about as long as ten plans, with meshes of up to 60,000 nodes if finer pitches are
    tried. Nothing is raised.

    Args:
        scene: the scene of ``plan``.
        plan: a plan whose ``error`` is set.
        cancelled: called often; once it returns True the result is None.

    Returns:
        The reason; None if the plan has no error, or one of another kind.
    """
    try:
        with watched_by(cancelled):
            reason = _reason(scene, plan, WhatIf(scene))
    except CancelledError:
        return None
    if reason is None:
        return None
    message, hint = in_unit((reason.message, reason.hint), scene.unit)
    return replace(reason, message=message, hint=hint)


def _reason(scene: Scene, plan: Plan, what_if: WhatIf) -> Reason | None:
    kind = "" if plan.error is None else plan.error.kind
    if kind in BLOCKED:
        return _blocked(scene, plan, what_if)
    if kind == NO_PATH and plan.graph is not None:
        return _disconnected(scene, plan, plan.graph, what_if)
    if kind == NOT_HELD and plan.bspline is not None:
        return _not_held(scene, plan.bspline, what_if)
    if isinstance(plan.error, ArmNotClear):
        return arm_reason(scene, plan, plan.error, what_if)
    error, axis = plan.error, scene.arm.held_axis
    if isinstance(error, NoJointMotion) and error.kind == DIRECTION_NOT_HELD and axis is not None:
        return held_direction_reason(axis, error, what_if)
    return None


def _blocked(scene: Scene, plan: Plan, what_if: WhatIf) -> Reason:
    """Reason where start, goal or both lie in an obstacle or its clearance."""
    clearance, slack = scene.spline.clearance, scene.workspace.slack
    ends = {"start": np.array(scene.start), "goal": np.array(scene.goal)}
    distances, obstacles = what_if.obstacles.nearest(np.array(list(ends.values())))
    nodes = np.zeros((0, 3)) if plan.free is None else plan.free.mesh.points[~plan.free.excluded]
    faults: list[str] = []
    free: dict[str, FloatArray | None] = {}
    for (which, point), distance, k in zip(
        ends.items(), distances.tolist(), obstacles.tolist(), strict=True
    ):
        if distance >= clearance - 1e-9:
            continue
        faults.append(
            f"the {which} is {format_length(-distance)} inside obstacle {k + 1}"
            if distance < 0
            else f"the {which} is {format_length(distance)} from obstacle {k + 1}, "
            f"nearer than the clearance of {format_length(clearance)}"
        )
        seeds = nodes[np.linalg.norm(nodes - point, axis=1).argsort()[:_SEEDS]]
        near = nearest_free_point(
            what_if.obstacles, scene.workspace, point, clearance + slack, seeds
        )
        free[which] = None if near is None else rounded(near, scene.workspace, slack / 2)
    message = _sentence(", and ".join(faults))

    trials: dict[str, Plan] = {}  # of changed scenes, by the change in words
    change: dict[str, Any] = {
        which: point.tolist() for which, point in free.items() if point is not None
    }
    if len(change) == len(free) and (trial := what_if.plan_past("graph", **change)):
        targets = [f"the {which} to {format_point(point)}" for which, point in change.items()]
        trials[f"move {' and '.join(targets)}, the nearest free point found"] = trial
    if distances.min() >= 0:
        trials |= _lower_clearance(what_if, float(distances.min()))
    points = _read_only_points([point for point in free.values() if point is not None])
    if not trials:
        return Reason(message, "No free point was found near it: move an obstacle.", None, points)
    trials = _whole(trials) or dict([trials.popitem()])
    return _advised(message, _sentence(", or ".join(trials)), trials.values(), points, what_if)


def _whole(trials: dict[str, Plan]) -> dict[str, Plan]:
    """Those of trials in which nothing else is wrong."""
    return {text: trial for text, trial in trials.items() if trial.error is None}


def _lower_clearance(what_if: WhatIf, most: float) -> dict[str, Plan]:
    """The largest clearance tried, up to ``most``, with a plan, else that gets past the graph."""
    trials: dict[str, Plan] = {}
    for value in dict.fromkeys(rounded_down(share * most, 2) for share in _SHARES):
        if trial := what_if.plan_past("graph", spline={"clearance": value}):
            text = f"lower the clearance to {format_length(value)}"
            if trial.error is None:
                return {text: trial}
            trials = trials or {text: trial}
    return trials


def _disconnected(scene: Scene, plan: Plan, graph: Graph, what_if: WhatIf) -> Reason:
    """Reason where start and goal are in different components of the graph."""
    clearance, pitch = scene.spline.clearance, scene.mesh.pitch
    finer = what_if.finer_pitches()
    lower = what_if.largest_clearance(what_if.connected)
    lowered: dict[str, Plan] = {}
    if lower is not None and (trial := what_if.plan_past("search", spline={"clearance": lower})):
        lowered[f"a clearance of {format_length(lower)}"] = trial
    connected_at_zero: list[float] = []
    for fine in finer:
        if what_if.connected(clearance, fine) and (
            trial := what_if.plan_past("search", mesh={"pitch": fine})
        ):
            finest = {f"a node spacing of {format_length(fine)}": trial}
            trials = _whole(finest | lowered) or finest
            return _advised(
                f"The grid is too coarse for the gap: with nodes {format_length(pitch)} apart no "
                f"path keeps a clearance of {format_length(clearance)}.",
                f"With {', or with '.join(trials)}, there is a path.",
                trials.values(),
                _narrowest_point(trial),
                what_if,
            )
        # now, while its mesh is there: that takes most of the time
        if lower is None and what_if.connected(0.0, fine):
            connected_at_zero.append(fine)
    if lowered:
        [(text, trial)] = lowered.items()
        return _advised(
            f"The gap is too narrow for a clearance of {format_length(clearance)}"
            f"{', on finer grids too' if finer else ''}.",
            f"With {text} there is a path.",
            [trial],
            _narrowest_point(trial),
            what_if,
        )
    for fine in connected_at_zero:
        largest = what_if.largest_clearance(partial(what_if.connected, pitch=fine)) or 0.0
        if trial := what_if.plan_past(
            "search", mesh={"pitch": fine}, spline={"clearance": largest}
        ):
            return _advised(
                f"The gap is too narrow for a clearance of {format_length(clearance)}, "
                f"and nodes {format_length(pitch)} apart are too coarse for the gap.",
                f"With a clearance of {format_length(largest)} and a node spacing of "
                f"{format_length(fine)} there is a path.",
                [trial],
                _narrowest_point(trial),
                what_if,
            )
    return _walled_in(scene, plan, graph, what_if)


def _walled_in(scene: Scene, plan: Plan, graph: Graph, what_if: WhatIf) -> Reason:
    """Reason where no clearance and no pitch helps: the component cut off, and its walls."""
    component = components(graph)
    from_start = np.flatnonzero(component == component[graph.start]).astype(np.int32)
    from_goal = np.flatnonzero(component == component[graph.goal]).astype(np.int32)
    smaller, inside = min((from_start, "start"), (from_goal, "goal"), key=lambda side: len(side[0]))
    walls = _walls(scene, plan, graph, smaller)
    message = f"No path: the {inside} is walled in{f' by {_listed(walls)}' if walls else ''}."
    tested = "A smaller clearance or a finer grid does not help (tested)."
    hint = f"Move {'them' if len(walls) > 1 else 'an obstacle'} apart. {tested}"
    points = _read_only_points(graph.points[smaller])
    for k in walls[:_NAMED]:
        others = scene.obstacles[:k] + scene.obstacles[k + 1 :]
        if what_if.connected(scene.spline.clearance, obstacles=ObstacleSet(others)):
            hint = f"Removing obstacle {k + 1} opens a way (tested). {tested}"
            change = without_obstacles(scene, (k,))
            change["obstacles"] = [other.model_dump(mode="json") for other in others]
            return Reason(message, hint, change, points, obstacle=k)
    return Reason(message, hint, None, points)


def _walls(scene: Scene, plan: Plan, graph: Graph, inside: IntArray) -> list[int]:
    """Indices of the obstacles that cross the edges out of the part ``inside`` of the graph."""
    assert plan.mesh is not None
    mesh = plan.mesh
    is_inside = np.zeros(len(graph.points), dtype=np.bool_)
    is_inside[inside] = True
    leaving = mesh.edges[is_inside[mesh.edges[:, 0]] != is_inside[mesh.edges[:, 1]]]
    p, q = mesh.points[leaving[:, 0]], mesh.points[leaving[:, 1]]
    for node in inside[inside >= len(mesh.points)]:
        distance = np.linalg.norm(mesh.points - graph.points[node], axis=1)
        distance[is_inside[: len(distance)]] = np.inf
        nearest = distance.argsort()[:_NEIGHBOURS]
        p = np.concatenate([p, np.broadcast_to(graph.points[node], (len(nearest), 3))])
        q = np.concatenate([q, mesh.points[nearest]])
    margin = scene.spline.clearance + scene.workspace.slack
    return [
        k
        for k, obstacle in enumerate(scene.obstacles)
        if ObstacleSet((obstacle,)).blocked(p, q, margin).any()
    ]


def _not_held(scene: Scene, bspline: Fit[BSpline], what_if: WhatIf) -> Reason:
    """Reason where there is a path, but no curve keeps the clearance."""
    points = bspline.curve(np.array([bspline.clearance.at]))
    clearance = scene.spline.clearance
    message = (
        f"No curve along the path is proven to keep the clearance of {format_length(clearance)}: "
        f"the B-spline lacks {format_length(max(clearance - bspline.clearance.distance, 0.0))}."
    )
    lower = what_if.largest_clearance(
        lambda value: what_if.plan_past("bspline", spline={"clearance": value}) is not None
    )
    changes: dict[str, dict[str, Any]] = {}
    if lower is not None:
        changes[f"A clearance of {format_length(lower)}"] = {"spline": {"clearance": lower}}
    for fine in what_if.finer_pitches():
        changes[f"A node spacing of {format_length(fine)}"] = {"mesh": {"pitch": fine}}
    for text, change in changes.items():
        if trial := what_if.plan_past("bspline", **change):
            return _advised(message, f"{text} works.", [trial], read_only(points), what_if)
    return Reason(
        message, "No smaller clearance and no finer grid that was tested helps.", None, points
    )


def _narrowest_point(plan: Plan) -> FloatArray:
    """Point (1, 3) at which the plan's path comes nearest to an obstacle, [unit], world."""
    assert plan.path is not None
    vertices = plan.path.points
    lengths = np.append(0, np.cumsum(np.linalg.norm(np.diff(vertices, axis=0), axis=1)))
    samples = np.linspace(0, lengths[-1], _SAMPLES)
    points = np.stack([np.interp(samples, lengths, column) for column in vertices.T], axis=1)
    distance, _ = ObstacleSet(plan.scene.obstacles).nearest(points)
    return _read_only_points(points[distance.argmin()][None])


def _advised(
    message: str, hint: str, trials: Iterable[Plan], points: FloatArray, what_if: WhatIf
) -> Reason:
    """Reason with remedies that the hint names: all trials whole, or a single one that is not.

    Of that the next error's remedy, if it is known, is added to it.
    """
    first, *others = trials
    own, *changes = (_change(what_if.scene, one.scene) for one in (first, *others))
    named, error = hint.removesuffix("."), first.error
    if error is None:
        return Reason(message, f"{named} (tested).", own, points, others=tuple(changes))
    then = None
    if error.stage in _LATE:
        then = _reason(first.scene, first, WhatIf(first.scene))
    if then is not None and then.change is not None:
        change = _both(own, then.change)
        if what_if.plan_past("arm", **change):
            next_hint = f"{then.hint[0].lower()}{then.hint[1:]}"
            hint = f"{named}. With that, {next_hint}"
            return Reason(message, hint, change, points, moved=then.moved)
    but = error.message.removesuffix(".")
    hint = f"{named} (tested), but then: {but}."
    return Reason(message, hint, own, points, is_whole=False)


def _change(scene: Scene, trial: Scene) -> dict[str, Any]:
    """Arguments of ``scene.replace`` for what trials change: ends, pitch and clearance."""
    change: dict[str, Any] = {}
    if trial.start != scene.start:
        change["start"] = list(trial.start)
    if trial.goal != scene.goal:
        change["goal"] = list(trial.goal)
    if trial.mesh.pitch != scene.mesh.pitch:
        change["mesh"] = {"pitch": trial.mesh.pitch}
    if trial.spline.clearance != scene.spline.clearance:
        change["spline"] = {"clearance": trial.spline.clearance}
    return change


def _both(change: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """Arguments of ``scene.replace`` that make both changes, the second one last."""
    both = dict(change)
    for section, value in other.items():
        known = both.get(section)
        both[section] = (
            {**known, **value} if isinstance(known, dict) and isinstance(value, dict) else value
        )
    return both


def _listed(obstacles: list[int]) -> str:
    """Numbers of obstacles, from 1, in the page's form: "obstacles 1–3 and 5"."""
    if len(obstacles) > 2 and obstacles == list(range(obstacles[0], obstacles[-1] + 1)):
        return f"obstacles {obstacles[0] + 1}–{obstacles[-1] + 1}"
    numbers = [str(k + 1) for k in obstacles[:_NAMED]]
    if len(obstacles) > _NAMED:
        return f"obstacles {', '.join(numbers)} and {len(obstacles) - _NAMED} more"
    if len(numbers) < 2:
        return f"obstacle {''.join(numbers)}"
    return f"obstacles {', '.join(numbers[:-1])} and {numbers[-1]}"


def _read_only_points(points: FloatArray | list[FloatArray]) -> FloatArray:
    return read_only(np.array(points, dtype=float).reshape(-1, 3))


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."

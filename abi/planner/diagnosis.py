"""Diagnosis of a scene without a plan: the reason, and what would help, in tried numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from abi.arrays import FloatArray, IntArray, read_only
from abi.errors import ClearanceNotHeld, NoPath, PointBlocked, StageError, format_length, in_unit
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.nearest_free_point import nearest_free, rounded
from abi.planner.plan import Plan
from abi.planner.planner import SLACK
from abi.planner.what_if import CancelledError, WhatIf, components, rounded_down
from abi.scene.scene import Scene
from abi.search.graph import Graph

_SEEDS = 64  # free nodes from which the nearest free point is sought
_SEEN = 32  # nodes an isolated start might have been joined to
_PLACES = 400  # along a path, to find its narrowest
_NAMED = 6  # obstacles in one sentence


@dataclass(frozen=True, eq=False)
class Reason:
    """Reason why there is no plan.

    Attributes:
        message: one sentence: what stands in the way.
        hint: one sentence: what would work; every number in it has been tried.
        change: what ``scene.replace(**change)`` needs for a scene that gets past the stage that
            failed, and that has a plan if ``hint`` does not say otherwise; None when nothing that
            was tried helps.
        points: places to mark in the scene, shape (k, 3), [unit], world.
    """

    message: str
    hint: str
    change: dict[str, Any] | None
    points: FloatArray

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as under ``error`` in a plan's JSON."""
        return {"message": self.message, "hint": self.hint, "change": self.change}


def explain(
    scene: Scene, plan: Plan, cancelled: Callable[[], bool] = lambda: False
) -> Reason | None:
    """Find out why ``plan`` has an error, by planning scenes that differ a little.

    - start or goal blocked: how deep, the nearest free point, the clearance that would do;
    - no path: a finer pitch that works, else the largest clearance that does, else both; else the
      obstacles that wall in start or goal;
    - clearance not held: the largest clearance that is.

    Takes about as long as some ten plans, and as long as meshes of up to 60,000 nodes take where
    the pitch is in question. Raises nothing.

    Args:
        scene: the scene of ``plan``.
        plan: a plan whose ``error`` is set.
        cancelled: asked before each trial; once it says True the answer is None.

    Returns:
        The reason; None for a plan without an error or with one of another kind.
    """
    what_if = WhatIf(scene, cancelled)
    try:
        found = _reason(scene, plan, what_if)
    except CancelledError:
        return None
    if found is None:
        return None
    message, hint = in_unit((found.message, found.hint), scene.unit)
    return replace(found, message=message, hint=hint)


def _reason(scene: Scene, plan: Plan, what_if: WhatIf) -> Reason | None:
    if isinstance(plan.error, PointBlocked):
        return _blocked(scene, plan, what_if)
    if isinstance(plan.error, NoPath) and plan.graph is not None:
        return _disconnected(scene, plan, plan.graph, what_if)
    if isinstance(plan.error, ClearanceNotHeld):
        return _not_held(scene, plan, plan.error, what_if)
    return None


def _blocked(scene: Scene, plan: Plan, what_if: WhatIf) -> Reason:
    """Start, goal or both are in an obstacle or its clearance."""
    asked, slack = scene.spline.clearance, SLACK * max(scene.workspace.size)
    ends = {"start": np.array(scene.start), "goal": np.array(scene.goal)}
    distance, obstacle = what_if.obstacles.nearest(np.array(list(ends.values())))
    known = np.zeros((0, 3)) if plan.free is None else plan.free.mesh.points[~plan.free.excluded]
    places: list[str] = []
    free: dict[str, FloatArray | None] = {}
    for (which, point), depth, k in zip(
        ends.items(), distance.tolist(), obstacle.tolist(), strict=True
    ):
        if depth >= asked - 1e-9:
            continue
        name = f"obstacle {k + 1}"
        places.append(
            f"the {which} is {format_length(-depth)} inside {name}"
            if depth < 0
            else f"the {which} is {format_length(depth)} from {name}, nearer than the clearance of "
            f"{format_length(asked)}"
        )
        seeds = known[np.linalg.norm(known - point, axis=1).argsort()[:_SEEDS]]
        found = nearest_free(what_if.obstacles, scene.workspace, point, asked + slack, seeds)
        free[which] = None if found is None else rounded(found, scene.workspace, slack / 2)
    message = _sentence(", and ".join(places))

    move: dict[str, Any] = {
        which: point.tolist() for which, point in free.items() if point is not None
    }
    moved = what_if.plan_past("graph", **move) if len(move) == len(free) else None
    lower = rounded_down(float(distance.min()), 2) if distance.min() >= 0 else None
    lowered = None
    if lower is not None:
        lowered = what_if.plan_past("graph", spline={"clearance": lower})
    points = _rows([point for point in free.values() if point is not None])

    remedies = []
    if moved is not None:
        targets = [f"the {which} to {_place(np.array(point))}" for which, point in move.items()]
        words = f"move {' and '.join(targets)}, the nearest free point found"
        remedies.append((moved, move, words))
    if lowered is not None and lower is not None:
        change: dict[str, Any] = {"spline": {"clearance": lower}}
        remedies.append((lowered, change, f"lower the clearance to {format_length(lower)}"))
    if not remedies:
        return Reason(message, "No free point was found near it: move an obstacle.", None, points)
    whole = [one for one in remedies if one[0].error is None] or remedies[:1]
    words = ", or ".join(text for *_, text in whole)
    return Reason(message, _sentence(words + _tried(whole[0][0])), whole[0][1], points)


def _disconnected(scene: Scene, plan: Plan, nodes: Graph, what_if: WhatIf) -> Reason:
    """Start and goal are in different parts of the graph."""
    asked, pitch = scene.spline.clearance, scene.mesh.pitch
    finer = what_if.finer_pitches()
    lower = what_if.largest_clearance(what_if.connected)
    both: list[float] = []
    for fine in finer:
        change: dict[str, Any] = {"mesh": {"pitch": fine}}
        if what_if.connected(asked, fine) and (made := what_if.plan_past("search", **change)):
            or_lower = f", or at this pitch a clearance of {format_length(lower or 0.0)}"
            also = "" if lower is None else or_lower
            return Reason(
                "The mesh is too coarse for the gap: no way of edges at a pitch of "
                f"{format_length(pitch)} keeps a clearance of {format_length(asked)}.",
                f"A pitch of {format_length(fine)} works{also}{_tried(made)}.",
                change,
                _narrowest(made),
            )
        # asked while its mesh is there: making that is most of the work
        if lower is None and what_if.connected(0.0, fine):
            both.append(fine)
    if lower is not None:
        change = {"spline": {"clearance": lower}}
        if made := what_if.plan_past("search", **change):
            return Reason(
                f"The clearance is too large for the gap: nothing joins start and goal with a "
                f"clearance of {format_length(asked)}{_down_to(finer)}.",
                f"A clearance of {format_length(lower)} works, the largest that does at this pitch"
                f"{_tried(made)}.",
                change,
                _narrowest(made),
            )
    for fine in both:
        low = what_if.largest_clearance(partial(what_if.connected, pitch=fine)) or 0.0
        change = {"mesh": {"pitch": fine}, "spline": {"clearance": low}}
        if made := what_if.plan_past("search", **change):
            return Reason(
                f"The gap is too narrow for a clearance of {format_length(asked)}, "
                f"and the pitch of {format_length(pitch)} too coarse for the gap.",
                f"A clearance of {format_length(low)} at a pitch of {format_length(fine)} works"
                f"{_tried(made)}.",
                change,
                _narrowest(made),
            )
    return _walled_in(scene, plan, nodes, what_if, finer)


def _walled_in(
    scene: Scene, plan: Plan, nodes: Graph, what_if: WhatIf, finer: list[float]
) -> Reason:
    """Reason where no clearance and no pitch helps: the component cut off, and its walls."""
    component = components(nodes)
    from_start = np.flatnonzero(component == component[nodes.start]).astype(np.int32)
    from_goal = np.flatnonzero(component == component[nodes.goal]).astype(np.int32)
    smaller, inside = min((from_start, "start"), (from_goal, "goal"), key=lambda side: len(side[0]))
    walls = _walls(scene, plan, nodes, smaller)
    names = _listed(walls)
    # start and goal, where they are no nodes of the mesh, are not counted: nor are they elsewhere
    size = len(nodes.mesh.points)
    free = nodes.free_nodes - len(nodes.own)
    of_start, of_goal = ((side < size).sum() for side in (from_start, from_goal))
    message = (
        f"The {inside} is walled in{f' by {names}' if walls else ''}: the start reaches "
        f"{of_start:,} of {free:,} nodes, the goal {of_goal:,}."
    )
    tried = f"clearances down to 0{_down_to(finer)} do not help: they have been tried"
    opened = None
    for k in walls[:_NAMED]:
        others = ObstacleSet(scene.obstacles[:k] + scene.obstacles[k + 1 :])
        if what_if.connected(scene.spline.clearance, obstacles=others):
            opened = k
            break
    hint = (
        f"Move obstacle {opened + 1}, without which there is a way; {tried}."
        if opened is not None
        else f"Move {'them' if len(walls) > 1 else 'an obstacle'} apart; {tried}."
    )
    return Reason(message, hint, None, _rows(nodes.points[smaller]))


def _walls(scene: Scene, plan: Plan, nodes: Graph, inside: IntArray) -> list[int]:
    """Obstacles that cross the edges out of a part of the graph, from 0."""
    assert plan.mesh is not None
    mesh = plan.mesh
    within = np.zeros(len(nodes.points), dtype=np.bool_)
    within[inside] = True
    leaving = mesh.edges[within[mesh.edges[:, 0]] != within[mesh.edges[:, 1]]]
    p, q = mesh.points[leaving[:, 0]], mesh.points[leaving[:, 1]]
    for node in inside[inside >= len(mesh.points)]:
        away = np.linalg.norm(mesh.points - nodes.points[node], axis=1)
        away[within[: len(away)]] = np.inf
        seen = away.argsort()[:_SEEN]
        p = np.concatenate([p, np.broadcast_to(nodes.points[node], (len(seen), 3))])
        q = np.concatenate([q, mesh.points[seen]])
    margin = scene.spline.clearance + SLACK * max(scene.workspace.size)
    return [
        k
        for k, obstacle in enumerate(scene.obstacles)
        if ObstacleSet((obstacle,)).blocked(p, q, margin).any()
    ]


def _not_held(scene: Scene, plan: Plan, error: ClearanceNotHeld, what_if: WhatIf) -> Reason:
    """There is a path, but no curve keeps the clearance."""
    points = np.zeros((0, 3))
    if plan.bspline is not None:
        points = plan.bspline.curve(np.array([plan.bspline.clearance.at]))
    asked = scene.spline.clearance
    message = (
        "No curve along the path is proven to keep the clearance of "
        f"{format_length(asked)}: "
        f"the B-spline lacks {format_length(max(asked - error.reached, 0.0))}."
    )
    lower = what_if.largest_clearance(
        lambda value: what_if.plan_past("bspline", spline={"clearance": value}) is not None
    )
    changes: list[tuple[str, dict[str, Any]]] = []
    if lower is not None:
        changes.append(
            (f"A clearance of {format_length(lower)} works", {"spline": {"clearance": lower}})
        )
    for fine in what_if.finer_pitches():
        changes.append((f"A pitch of {format_length(fine)} works", {"mesh": {"pitch": fine}}))
    for words, change in changes:
        made = what_if.plan_past("bspline", **change)
        if made is not None:
            return Reason(message, f"{words}{_tried(made)}.", change, read_only(points))
    return Reason(
        message, "No lower clearance and no finer pitch that was tried helps.", None, points
    )


def _narrowest(plan: Plan) -> FloatArray:
    """The place (1, 3) where the plan's path comes nearest to an obstacle, [unit]."""
    assert plan.path is not None
    corners = plan.path.points
    lengths = np.append(0, np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1)))
    distances = np.linspace(0, lengths[-1], _PLACES)
    places = np.stack([np.interp(distances, lengths, column) for column in corners.T], axis=1)
    distance, _ = ObstacleSet(plan.scene.obstacles).nearest(places)
    return _rows(places[distance.argmin()][None])


def _tried(plan: Plan) -> str:
    """The end of a hint: that it was tried, and what comes next where that is not a plan."""
    error: StageError | None = plan.error
    if error is None:
        return ": it has been tried"
    return f": it has been tried and gets further, until: {error.message.removesuffix('.')}"


def _down_to(finer: list[float]) -> str:
    return f" at pitches down to {format_length(finer[-1])}" if finer else ""


def _listed(obstacles: list[int]) -> str:
    numbers = [str(k + 1) for k in obstacles[:_NAMED]]
    if len(obstacles) > _NAMED:
        return f"obstacles {', '.join(numbers)} and {len(obstacles) - _NAMED} more"
    if len(numbers) < 2:
        return f"obstacle {''.join(numbers)}"
    return f"obstacles {', '.join(numbers[:-1])} and {numbers[-1]}"


def _place(point: FloatArray) -> str:
    return "({:g}, {:g}, {:g})".format(*point)


def _rows(points: FloatArray | list[FloatArray]) -> FloatArray:
    return read_only(np.array(points, dtype=float).reshape(-1, 3))


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."

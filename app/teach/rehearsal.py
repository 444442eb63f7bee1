"""Rehearsal: a run through a lesson without a page, planning each of its settings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from abi.curves.bspline import BSpline
from abi.curves.fit import Fit
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import load_scene
from abi.search.replay import replay
from app.state.bent_curve import bend
from app.state.frame import Frame
from app.teach.lesson import SearchCue, Setting, scene_of
from app.theatre.searches import EDGES, trace
from app.theatre.theatre import Theatre, one_way_search

_WEIGHT = 1.5
"""Heuristic weight in a weighted search, unless a setting names another."""


Take = Callable[[Setting], Frame]
"""Function that applies a page's setting to what the last one left, and plans.

It gives the frame as the page would show it, without camera and playback, and raises a SceneError
where the scene cannot be read or a change is wrong, and a StageError where there is no place for
the negative edge that it asks for.
"""


def rehearsal(folder: Path, planner: Planner) -> Take:
    """Begin a rehearsal with the default scene of lessons; scene files are in ``folder``."""
    frame, cue = Frame(planner(load_scene("paper"))), SearchCue(on=False)

    def take(setting: Setting) -> Frame:
        nonlocal frame, cue
        scene = scene_of(setting, frame.plan.scene, folder)
        plan = frame.plan if scene == frame.plan.scene else planner(scene)
        if setting.search is not None:
            cue = cue.model_copy(update=setting.search.model_dump(exclude_none=True))
        last = frame
        frame = replace(
            frame,
            plan=plan,
            shown=frame.shown if setting.shown is None else frozenset(setting.shown),
            time=frame.time if setting.time is None else setting.time,
        )
        frame = replace(frame, theatre=_theatre(cue, plan), bent=_bent(frame, setting, last))
        return frame

    return take


def _bent(frame: Frame, setting: Setting, last: Frame) -> Fit[BSpline] | None:
    """The bent curve that a setting asks for, or the last one if it still fits the plan."""
    plan = frame.plan
    if plan.bspline is None or "bent" not in frame.shown:
        return None
    if not setting.bend:
        before = last.plan.bspline
        same = before is not None and before.curve is plan.bspline.curve
        return last.bent if same else None
    points = plan.bspline.curve.control_points
    return bend(plan, {k: points[k] + by for k, by in setting.bend.items()})


def _theatre(cue: SearchCue, plan: Plan) -> Theatre | None:
    """The search that is stepped through; None while none is."""
    if not cue.on or plan.graph is None:
        return None
    kind = EDGES[cue.edges or "none"]
    name = cue.algorithm or "a_star"
    name = one_way_search(name) if kind else name
    found = trace(plan, name, kind, _WEIGHT if cue.weight is None else cue.weight)
    return Theatre(name, replay(found, min(cue.step or 0, found.steps)))

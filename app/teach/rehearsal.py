"""Rehearsal: a run through a lesson without a page, planning each of its settings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from abi.curves.bspline import BSpline
from abi.curves.fit import Fit
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


class Rehearsal:
    """The frame that results from a lesson.

    Attributes:
        frame: as the page would show it, without camera and playback.
    """

    def __init__(self, folder: Path, planner: Planner) -> None:
        """Begin with the default scene of lessons; scene files are in ``folder``."""
        self._folder, self._planner = folder, planner
        self._cue = SearchCue(on=False)
        self.frame = Frame(planner(load_scene("paper")))

    def take(self, setting: Setting) -> Frame:
        """Apply a page's setting, and plan.

        Raises:
            SceneError: the scene cannot be read, or a change is wrong.
            StageError: there is no place for the negative edge that it asks for.
        """
        frame = self.frame
        scene = scene_of(setting, frame.plan.scene, self._folder)
        plan = frame.plan if scene == frame.plan.scene else self._planner(scene)
        if setting.search is not None:
            self._cue = self._cue.model_copy(update=setting.search.model_dump(exclude_none=True))
        self.frame = replace(
            frame,
            plan=plan,
            shown=frame.shown if setting.shown is None else frozenset(setting.shown),
            time=frame.time if setting.time is None else setting.time,
        )
        self.frame = replace(self.frame, theatre=self._theatre(), bent=self._bent(setting, frame))
        return self.frame

    def _bent(self, setting: Setting, last: Frame) -> Fit[BSpline] | None:
        """The bent curve that a setting asks for, or the last one if it still fits the plan."""
        plan = self.frame.plan
        if plan.bspline is None or "bent" not in self.frame.shown:
            return None
        if not setting.bend:
            before = last.plan.bspline
            same = before is not None and before.curve is plan.bspline.curve
            return last.bent if same else None
        points = plan.bspline.curve.control_points
        return bend(plan, {k: points[k] + by for k, by in setting.bend.items()})

    def _theatre(self) -> Theatre | None:
        cue, plan = self._cue, self.frame.plan
        if not cue.on or plan.graph is None:
            return None
        kind = EDGES[cue.edges or "none"]
        name = cue.algorithm or "a_star"
        name = one_way_search(name) if kind else name
        found = trace(plan, name, kind, _WEIGHT if cue.weight is None else cue.weight)
        return Theatre(name, replay(found, min(cue.step or 0, found.steps)))

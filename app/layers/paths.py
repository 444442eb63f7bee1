"""The three searched paths, side by side where they coincide, and the taut one."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from abi.planner.plan import Plan
from app import style
from app.frame import Frame, Layer, Switch
from app.layout import Layout
from app.lines import NO_SEGMENTS, FadingLines, dashes, segments

# Not along any edge of the lattices, so that coinciding paths lie beside each other everywhere.
_OFFSET = np.array([0.53, -0.80, 0.27])
_OFFSET_FACTOR = {"a_star": 0.0, "dijkstra": 1.0, "bellman_ford": -1.0}


class PathsLayer(Layer):
    """One fat line an algorithm; Dijkstra's is dashed, as in the paper's Fig. 3."""

    switches: ClassVar[tuple[Switch, ...]] = (
        *(Switch(name, label, colour) for name, (label, colour) in style.ALGORITHMS.items()),
        Switch("taut", "straightened path", style.TAUT),
    )

    def __init__(self, layout: Layout) -> None:
        self._all = FadingLines(layout.client.scene)
        self._lines = {
            name: self._all.add(f"/path/{name}", colour, 3.5)
            for name, (_, colour) in style.ALGORITHMS.items()
        }
        self._taut = self._all.add("/path/taut", style.TAUT, 3.5)
        self._drawn: object = None
        self._drawn_taut: object = self

    def draw(self, frame: Frame) -> None:
        """Draw the plan's paths; none where there are none."""
        self._taut.visible = "taut" in frame.shown
        for name, line in self._lines.items():
            line.visible = name in frame.shown
        self._all.fade(frame.outdated)
        if frame.plan.taut is not self._drawn_taut:
            self._drawn_taut = taut = frame.plan.taut
            self._taut.points = NO_SEGMENTS if taut is None else segments(taut.points)
        if frame.plan.searches is not self._drawn:
            self._drawn = frame.plan.searches
            self._draw_searches(frame.plan)

    def _draw_searches(self, plan: Plan) -> None:
        longest = max(plan.scene.workspace.size)
        results = {result.algorithm: result for result in plan.searches}
        for name, line in self._lines.items():
            line.thickness = 4.0 if plan.path and name == plan.path.algorithm else 1.8
            if name not in results:
                line.points = NO_SEGMENTS
                continue
            points = results[name].points + _OFFSET_FACTOR[name] * 0.006 * longest * _OFFSET
            line.points = dashes(points, 0.03 * longest) if name == "dijkstra" else segments(points)

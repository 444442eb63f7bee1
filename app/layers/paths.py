"""The three searched paths, side by side where they coincide, and the taut one."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from abi.planner.plan import Plan
from app import style
from app.frame import Frame, Switch
from app.layers.lines import dashes, segments
from app.layout import Layout

# Not along any edge of the lattices, so that coinciding paths lie beside each other everywhere.
_ASIDE = np.array([0.53, -0.80, 0.27])
_SHIFT = {"a_star": 0.0, "dijkstra": 1.0, "bellman_ford": -1.0}


class PathsLayer:
    """One fat line an algorithm; Dijkstra's is dashed, as in the paper's Fig. 3."""

    switches: ClassVar[tuple[Switch, ...]] = (
        *(Switch(name, label, colour) for name, (label, colour) in style.ALGORITHMS.items()),
        Switch("taut", "taut path", style.TAUT),
    )

    def __init__(self, layout: Layout) -> None:
        scene = layout.client.scene
        self._lines = {
            name: scene.add_line_segments(
                f"/path/{name}",
                np.zeros((1, 2, 3)),
                colour,
                thickness=3.5,
                thickness_units="screen",
            )
            for name, (_, colour) in style.ALGORITHMS.items()
        }
        self._taut = scene.add_line_segments(
            "/path/taut",
            np.zeros((1, 2, 3)),
            style.TAUT,
            thickness=3.5,
            thickness_units="screen",
        )
        self._drawn: object = None
        self._drawn_taut: object = self
        self._faded = False

    def draw(self, frame: Frame) -> None:
        """Draw the plan's paths; none where there are none."""
        self._taut.visible = "taut" in frame.shown
        for name, line in self._lines.items():
            line.visible = name in frame.shown
        if frame.faded != self._faded:
            self._fade(frame.faded)
        self._draw_paths(frame.plan)

    def _draw_paths(self, plan: Plan) -> None:
        if plan.taut is not self._drawn_taut:
            self._drawn_taut = plan.taut
            points = np.zeros((0, 3)) if plan.taut is None else plan.taut.points
            self._taut.points = segments(points)
        if plan.searches is self._drawn:
            return
        self._drawn = plan.searches
        longest = max(plan.scene.workspace.size)
        found = {result.algorithm: result for result in plan.searches}
        for name, line in self._lines.items():
            if name not in found:
                line.points = segments(np.zeros((0, 3)))
                continue
            points = found[name].points + _SHIFT[name] * 0.006 * longest * _ASIDE
            line.points = dashes(points, 0.03 * longest) if name == "dijkstra" else segments(points)

    def _fade(self, faded: bool) -> None:
        self._faded = faded
        self._taut.colors = np.array(style.FADED if faded else style.TAUT, np.uint8)
        for name, line in self._lines.items():
            line.colors = np.array(style.FADED if faded else style.ALGORITHMS[name][1], np.uint8)

"""The three searched paths, side by side where they coincide, and the taut one."""

from __future__ import annotations

import itertools
from typing import ClassVar

import numpy as np

from abi.arrays import FloatArray
from abi.planner.plan import Plan
from app.drawing.lines import NO_SEGMENTS, FadingLines, Segments, dashes, segments
from app.state.frame import Frame, Layer, Switch
from app.ui import style
from app.ui.layout import Layout

# Not along any edge of the lattices, so that coinciding paths lie beside each other everywhere.
_OFFSET = np.array([0.53, -0.80, 0.27])
_OFFSET_FACTORS = (0.0, 1.0, -1.0, 2.0, -2.0)


class PathsLayer(Layer):
    """One fat line an algorithm; Dijkstra's is dashed, as in the paper's Fig. 3.

    So is the taut one, in long dashes.
    """

    switches: ClassVar[tuple[Switch, ...]] = (
        *(Switch(name, label, colour) for name, (label, colour) in style.ALGORITHMS.items()),
        Switch(
            "taut", "shortcut path", style.TAUT, hint="Where stage 3 cuts the corners of the path."
        ),
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
        self._all.fade(not frame.current)
        if frame.plan.taut is not self._drawn_taut:
            self._drawn_taut = taut = frame.plan.taut
            longest = max(frame.plan.scene.workspace.size)
            points = np.zeros((0, 3)) if taut is None else taut.points
            self._taut.points = _dashed("taut", points, longest)
        if frame.plan.searches is not self._drawn:
            self._drawn = frame.plan.searches
            self._draw_searches(frame.plan)

    def _draw_searches(self, plan: Plan) -> None:
        longest = max(plan.scene.workspace.size)
        results = {result.algorithm: result for result in plan.searches}
        for (name, line), factor in zip(
            self._lines.items(), itertools.cycle(_OFFSET_FACTORS), strict=False
        ):
            line.thickness = 3.2 if plan.path and name == plan.path.algorithm else 1.8
            if name not in results:
                line.points = NO_SEGMENTS
                continue
            points = results[name].points + factor * 0.006 * longest * _OFFSET
            line.points = _dashed(name, points, longest)


def _dashed(name: str, points: FloatArray, longest: float) -> Segments:
    """Segments of a line, dashed where the one so named is; ``longest`` is the workspace's side."""
    if name not in style.DASHES:
        return segments(points)
    return dashes(points, style.DASHES[name][0] * longest) if len(points) else NO_SEGMENTS

"""Notes on a plan in the stages' folders."""

from __future__ import annotations

import html

from abi.certification.verdict import MotionVerdict
from abi.certification.verdict_words import remarks
from app.state.frame import Frame, Layer
from app.ui import style
from app.ui.layout import Layout
from app.ui.numbers import unbroken
from app.ui.plan_notes import notes

_FRAME = '<div style="height:{}px;overflow-y:auto">{}</div>'
_HEIGHTS = {"bspline": 21, "quadratic": 71, "arm": 120, "motion": 38}
"""Height of each note, whatever is in it, [px]: one that grew would push what the hand is on."""

_OF_LAYERS = frozenset({"bspline", "quadratic", "arm"})
"""Notes on what the layer of the same name draws."""


class StageNotesLayer(Layer):
    """A note each for B-spline, quadratic, motion and arm, in which what is longer scrolls."""

    def __init__(self, layout: Layout) -> None:
        self._notes = {}
        for stage in ("bspline", "quadratic", "arm"):
            with layout.folders[stage]:
                self._notes[stage] = layout.client.gui.add_html("")
        with layout.result:
            self._notes["motion"] = layout.client.gui.add_html("")
        self._drawn: tuple[object, ...] = ()

    def draw(self, frame: Frame) -> None:
        """Write the plan's numbers; in a lesson only those of stages that it shows."""
        plan = frame.plan
        state = plan, frame.asks, frame.lesson and frame.shown
        if state == self._drawn:
            return
        self._drawn = state
        texts = dict.fromkeys(notes(plan), "") if frame.asks else notes(plan)
        if frame.lesson:
            unused = _OF_LAYERS - frame.shown
            texts = {name: "" if name in unused else text for name, text in texts.items()}
        if frame.checked is not None:
            texts = {**texts, **_checked_notes(frame.checked)}
        for name, handle in self._notes.items():
            handle.content = _FRAME.format(_HEIGHTS[name], unbroken(texts[name]))


def _checked_notes(verdict: MotionVerdict) -> dict[str, str]:
    """Notes on a motion from elsewhere, whose timing and limits are its own."""
    duration = float(verdict.problem.motion.motion.times[-1])
    told = html.escape(" ".join(remarks(verdict)))
    return {
        "motion": style.paragraph(f"A motion from elsewhere: {duration:.2f} s in all."),
        "arm": style.paragraph(told),
    }

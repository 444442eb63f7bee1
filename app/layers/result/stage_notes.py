"""Notes on a plan in the stages' folders."""

from __future__ import annotations

import html

from abi.certification.verdict import MotionVerdict
from abi.certification.verdict_words import remarks
from app.state.frame import Frame
from app.ui import style
from app.ui.numbers import unbroken
from app.ui.plan_notes import notes

_FRAME = '<div style="height:{}px;overflow-y:auto">{}</div>'
_HEIGHTS = {"bspline": 21, "quadratic": 71, "arm": 120, "motion": 38}
"""Height of each note, whatever is in it, [px]: one that grew would push what the hand is on."""

_OF_LAYERS = frozenset({"bspline", "quadratic", "arm"})
"""Notes on what the layer of the same name draws."""


def shown_notes(frame: Frame) -> dict[str, str]:
    """A note each on B-spline, quadratic, motion and arm, as HTML in which what is longer scrolls.

    Of a lesson only those on stages that it shows.
    """
    texts = dict.fromkeys(notes(frame.plan), "") if frame.asks else notes(frame.plan)
    if frame.lesson:
        unused = _OF_LAYERS - frame.shown
        texts = {name: "" if name in unused else text for name, text in texts.items()}
    if frame.checked is not None:
        texts = {**texts, **_checked_notes(frame.checked)}
    return {name: _FRAME.format(height, unbroken(texts[name])) for name, height in _HEIGHTS.items()}


def _checked_notes(verdict: MotionVerdict) -> dict[str, str]:
    """Notes on a motion from elsewhere, whose timing and limits are its own."""
    duration = float(verdict.problem.motion.motion.times[-1])
    told = html.escape(" ".join(remarks(verdict)))
    return {
        "motion": style.paragraph(f"A motion from elsewhere: {duration:.2f} s in all."),
        "arm": style.paragraph(told),
    }

"""Buttons and counters of the search theatre over the scene, where the arm's player would be."""

from __future__ import annotations

from abi.search.compare import COMPARED
from app.panels.teach.search_theatre import TheatrePanel
from app.state.frame import Frame
from app.theatre.text import legend
from app.ui.numbers import format_count
from app.ui.overlay import button


def search_strip(panel: TheatrePanel, frame: Frame) -> str:
    """A row of HTML whose buttons press those of the panel; empty without a search.

    Of a lesson that is gone through the legend alone: it asks what the counters would tell.
    """
    theatre = frame.theatre
    if theatre is None:
        return ""
    meaning = "" if theatre.race else legend(theatre, frame.lesson)
    if frame.lesson:
        return meaning
    state = theatre.state
    playing = "Pause" if panel.playing else "Play"
    if theatre.race:
        steps = max(one.trace.steps for _, one in theatre.race)
        step = max(one.step for _, one in theatre.race)
        title = "Race"
    else:
        steps, step, title = state.trace.steps, state.step, COMPARED[theatre.name].label
    text = f"{title}: {format_count(step)} of {format_count(steps)}"
    answer = f'<div class="abi-card">{theatre.said}</div>' if theatre.said else ""
    return (
        f'{answer}{meaning}<div class="abi-card abi-buttons">'
        f"{button(panel.back, '◀', hint='One step back (B)')}<b>{text}</b>"
        f"{button(panel.forward, '▶', hint='One step forward (N)')}"
        f"{button(panel.play, playing, hint='Play the search (P)')}"
        f"{button(panel.close, 'Close search', hint='Shows paths, curves and arm again')}</div>"
    )

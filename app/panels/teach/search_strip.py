"""Buttons and counters of the search theatre over the scene, where the arm's player would be."""

from __future__ import annotations

from functools import partial

import viser

from abi.search.compare import COMPARED
from app.panels.teach.search_theatre import TheatrePanel
from app.panels.widgets import hidden_button
from app.state.frame import Frame
from app.theatre.text import legend
from app.ui.numbers import format_count
from app.ui.overlay import button


class SearchStrip:
    """A row of HTML whose buttons press hidden ones."""

    def __init__(self, gui: viser.GuiApi, theatre: TheatrePanel) -> None:
        self._theatre = theatre
        self._back = hidden_button(gui, "Search: back", partial(theatre.go, -1))
        self._forward = hidden_button(gui, "Search: forward", partial(theatre.go, 1))
        self._end = hidden_button(gui, "Search: end", theatre.end)

    def html(self, frame: Frame) -> str:
        """The row; empty where no search is stepped through.

        Of a lesson that is gone through the legend alone: it asks what the counters would tell.
        """
        theatre = frame.theatre
        if theatre is None:
            return ""
        meaning = "" if theatre.race else legend(theatre, frame.lesson)
        if frame.lesson:
            return meaning
        state = theatre.state
        playing = "Pause" if self._theatre.playing else "Play"
        if theatre.race:
            steps = max(one.trace.steps for _, one in theatre.race)
            step = max(one.step for _, one in theatre.race)
            title = "Race"
        else:
            steps, step, title = state.trace.steps, state.step, COMPARED[theatre.name].label
        text = f"{title}: {format_count(step)} of {format_count(steps)}"
        said = theatre.answer.text
        answer = f'<div class="abi-card">{said}</div>' if said else ""
        return (
            f'{answer}{meaning}<div class="abi-card abi-buttons">'
            f"{button(self._back, '◀', hint='One step back (B)')}<b>{text}</b>"
            f"{button(self._forward, '▶', hint='One step forward (N)')}"
            f"{button(self._theatre.play, playing, hint='Play the search (P)')}"
            f"{button(self._end, 'Close search', hint='Shows paths, curves and arm again')}</div>"
        )

"""Lecture mode: the scene alone, in large letters, with stages and views to step through."""

from __future__ import annotations

from functools import partial

from app.panels.teach.search_strip import search_strip
from app.panels.teach.search_theatre import TheatrePanel
from app.panels.widgets import Wake, hidden_button, pressed
from app.stages.catalogue import SHOWN_STAGES, TITLES
from app.state.frame import Frame
from app.ui import page
from app.ui.layout import Layout
from app.ui.overlay import button

_STEPS = (None, *SHOWN_STAGES)
"""All stages together are a step before the first and after the last."""
VIEWS = {
    "Whole": (0.82, -0.42, 0.38),
    "Front": (0.0, 1.0, 0.12),
    "Side": (1.0, 0.0, 0.12),
    "Top": (0.0, -0.02, 1.0),
}
"""Directions to the camera; the shipped arms stand behind the workspace, seen from the front."""


class Lecture:
    """Switch of the mode, and the strip over the scene.

    Attributes:
        toggle: button of the toolbar that begins and ends it; hidden itself.
        on: whether it is on.
    """

    def __init__(self, layout: Layout, theatre: TheatrePanel, wake: Wake) -> None:
        self._layout = layout
        self._wake = wake
        self._theatre = theatre
        gui = layout.client.gui
        self.toggle = hidden_button(gui, "Lecture", self._press)
        self._back = hidden_button(gui, "Stage before", wake)
        self._forward = hidden_button(gui, "Next stage", wake)
        self._views = {name: hidden_button(gui, f"View: {name}", wake) for name in VIEWS}
        self.on = self._switch = self._large = False
        self._stage: str | None = None
        self._steps = 0
        command = gui.add_command("Lecture mode", hotkey="L")
        command.on_trigger(self._press)
        # keys of a presenter's remote, which scroll the panels where none is given
        forward = gui.add_command("Lecture: next stage", hotkey="pagedown", disabled=True)
        back = gui.add_command("Lecture: stage before", hotkey="pageup", disabled=True)
        forward.on_trigger(partial(self._step, 1))
        back.on_trigger(partial(self._step, -1))
        self._commands = forward, back

    def shown(self, switches: frozenset[str]) -> frozenset[str]:
        """Names of what the chosen stage shows; those that are switched on where none is."""
        if self._switch:
            self._switch, self.on, self._stage = False, not self.on, None
        steps = pressed(self._forward) - pressed(self._back) + self._steps
        self._steps = 0
        if self.on and steps:
            step = _STEPS.index(self._stage) + steps
            self._stage = _STEPS[step % len(_STEPS)]
        return switches if self._stage is None else SHOWN_STAGES[self._stage].layers

    @property
    def stage(self) -> str:
        """Name of the stage that is shown alone; empty for all of them."""
        return self._stage or ""

    @property
    def shows_search(self) -> bool:
        """Whether the chosen stage is the search's, or none is chosen."""
        return self._stage in (None, "search")

    def requested_view(self) -> tuple[float, float, float] | None:
        """Direction to the camera that was asked for since the last call."""
        for name, widget in self._views.items():
            if pressed(widget):
                return VIEWS[name]
        return None

    def draw(self, frame: Frame) -> None:
        """Show the strip and large letters, or neither; a search's buttons while it is shown."""
        if self.on != self._large:
            self._large = self.on
            for command in self._commands:
                command.disabled = not self.on
            page.call(self._layout.client, "lecture", self.on)
        content = self._strip() if self.on else ""
        if self.shows_search:
            content = search_strip(self._theatre, frame) + content
        self._layout.overlay.show("lecture", content)

    def _strip(self) -> str:
        title = "All stages" if self._stage is None else TITLES[self._stage]
        views = "".join(button(widget, name) for name, widget in self._views.items())
        return (
            '<div class="abi-card abi-buttons">'
            f"{button(self._back, '<', hint='Stage before (Page Up)')}<b>{title}</b>"
            f"{button(self._forward, '>', hint='Next stage (Page Down)')}<span></span>{views}"
            f"{button(self.toggle, 'End lecture', hint='L')}</div>"
        )

    def _press(self, event: object) -> None:
        self._switch = True
        self._wake(event)

    def _step(self, count: int, event: object) -> None:
        self._steps += count
        self._wake(event)

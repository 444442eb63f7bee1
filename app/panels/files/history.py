"""Undo and redo of everything that changes the scene."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import viser
from pydantic import BaseModel

from abi.scene.scene import Scene
from app.panels.widgets import Wake, hidden_button

_LONGEST = 200
_SOON = 2.0
"""Seconds within which another change of the same field belongs to the last: of one slow drag."""


@dataclass(frozen=True)
class HistoryStep:
    """A scene to go back or forward to.

    Attributes:
        scene: as it was shown.
        name: of the scene that it was made from, as the page lists it.
        loaded: that scene.
    """

    scene: Scene
    name: str
    loaded: Scene


class History:
    """Scenes in the order in which they were left alone for a moment, and the one shown.

    Attributes:
        undo: button to go one back; ``redo``, one forward. Both hidden: the toolbar presses them.
    """

    def __init__(self, gui: viser.GuiApi, first: HistoryStep, wake: Wake) -> None:
        self._noted = [first]
        self._current = 0
        self._changed = "", -math.inf  # field that was changed last, and when, [s]
        self._follows = False  # whether the scene shown is another tab's
        back, forward = partial(self._step, -1), partial(self._step, 1)
        self.undo = hidden_button(gui, "Undo", back)
        self.redo = hidden_button(gui, "Redo", forward)
        self._steps = 0
        self._wake = wake
        gui.add_command("Undo", hotkey="Z", modifier="cmd/ctrl").on_trigger(back)
        gui.add_command("Redo", hotkey="Z", modifier="cmd/ctrl+shift").on_trigger(forward)
        gui.add_command("Redo (Y)", hotkey="Y", modifier="cmd/ctrl").on_trigger(forward)

    @property
    def noted(self) -> Scene:
        """The scene noted last, or gone back or forward to."""
        return self._noted[self._current].scene

    @property
    def can_undo(self) -> bool:
        """Whether there is a scene before the one shown."""
        return self._current > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is a scene after the one shown."""
        return self._current < len(self._noted) - 1

    def note(self, shown: HistoryStep, time: float = math.inf) -> None:
        """Note the scene that is shown; what was undone before it is forgotten.

        Args:
            shown: the scene, and what it was made from.
            time: when it was left alone, [s]; soon after another change of the same field it takes
                that one's place.
        """
        if shown.scene == self.noted:
            self._noted[self._current] = shown  # it may be loaded under another name
            return
        field, (last, at) = _changed_field(self.noted, shown.scene), self._changed
        goes_on = field == last != "" and time - at < _SOON and not self.can_redo
        # a reset, which leads back to the step before, is one of its own
        goes_on = goes_on and self.can_undo and shown.scene != self._noted[self._current - 1].scene
        kept = self._current + (0 if goes_on else 1)
        self._noted = [*self._noted[:kept], shown][-_LONGEST:]
        self._current = len(self._noted) - 1
        self._changed = field, time
        self._follows = False

    def follow(self, own: HistoryStep, shown: HistoryStep) -> None:
        """Note what another tab shows: one step back from it is what was shown before that tab's.

        Args:
            own: what was shown until now, which may not have been noted yet.
            shown: the other tab's.
        """
        self.note(own)
        if self._follows:
            self._noted[self._current :] = [shown]
        elif shown.scene != self.noted:
            self.note(shown)
            self._follows = True

    def replace(self, shown: HistoryStep) -> None:
        """Note a scene that comes by itself in place of the one noted last."""
        self._noted[self._current :] = [shown]

    def begin(self, first: HistoryStep) -> None:
        """Begin anew with ``first``."""
        self._noted, self._current, self._follows = [first], 0, False

    def requested(self, shown: HistoryStep) -> HistoryStep | None:
        """The scene asked for since the last call; None for none, or where there is none.

        Args:
            shown: the one shown, which may not have been noted yet.
        """
        steps, self._steps = self._steps, 0
        if steps == 0:
            return None
        self.note(shown)
        self._follows = False
        self._changed = "", -math.inf
        self._current = min(max(self._current + steps, 0), len(self._noted) - 1)
        return self._noted[self._current]

    def _step(self, count: int, event: object) -> None:
        self._steps += count
        self._wake(event)


def _changed_field(before: Scene, after: Scene) -> str:
    """Name of the one field of a section in which two scenes differ; empty if there are more."""
    sections = [
        name for name in Scene.model_fields if getattr(before, name) != getattr(after, name)
    ]
    if len(sections) != 1:
        return ""
    old, new = getattr(before, sections[0]), getattr(after, sections[0])
    if not isinstance(old, BaseModel) or type(old) is not type(new):
        return ""
    fields = [name for name in type(old).model_fields if getattr(old, name) != getattr(new, name)]
    return f"{sections[0]}.{fields[0]}" if len(fields) == 1 else ""

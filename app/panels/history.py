"""Undo and redo of everything that changes the scene."""

from __future__ import annotations

from typing import Any

import viser

from abi.scene.scene import Scene
from app.panels.widgets import Wake

_LONGEST = 200


class History:
    """Scenes in the order in which they were left alone for a moment, and the one shown.

    Attributes:
        undo: button to go one back; ``redo``, one forward. Both hidden: the toolbar presses them.
    """

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        self._scenes = [scene]
        self._current = 0
        self._follows = False  # whether the scene shown is another tab's
        # Any, since viser declares a button's value read-only
        self.undo: Any = gui.add_button("Undo", visible=False)
        self.redo: Any = gui.add_button("Redo", visible=False)
        self._steps = 0
        self._wake = wake
        self.undo.on_click(self._step_back)
        self.redo.on_click(self._step_forward)
        undo = gui.add_command("Undo", hotkey="Z", modifier="cmd/ctrl")
        redo = gui.add_command("Redo", hotkey="Z", modifier="cmd/ctrl+shift")
        also_redo = gui.add_command("Redo (Y)", hotkey="Y", modifier="cmd/ctrl")
        undo.on_trigger(self._step_back)
        redo.on_trigger(self._step_forward)
        also_redo.on_trigger(self._step_forward)

    @property
    def noted(self) -> Scene:
        """The scene noted last, or gone back or forward to."""
        return self._scenes[self._current]

    @property
    def can_undo(self) -> bool:
        """Whether there is a scene before the one shown."""
        return self._current > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is a scene after the one shown."""
        return self._current < len(self._scenes) - 1

    def note(self, scene: Scene) -> None:
        """Note the scene that is shown; what was undone before it is forgotten."""
        if scene == self._scenes[self._current]:
            return
        self._scenes = [*self._scenes[: self._current + 1], scene][-_LONGEST:]
        self._current = len(self._scenes) - 1
        self._follows = False

    def follow(self, own: Scene, scene: Scene) -> None:
        """Note what another tab shows: one step back from it is what was shown before that tab's.

        Args:
            own: the scene shown until now, which may not have been noted yet.
            scene: the other tab's.
        """
        self.note(own)
        if self._follows:
            self._scenes[self._current :] = [scene]
        elif scene != self.noted:
            self.note(scene)
            self._follows = True

    def begin(self, scene: Scene) -> None:
        """Begin anew with ``scene``."""
        self._scenes, self._current, self._follows = [scene], 0, False

    def requested(self, scene: Scene) -> Scene | None:
        """The scene asked for since the last call; None for none, or where there is none.

        Args:
            scene: the one shown, which may not have been noted yet.
        """
        steps, self._steps = self._steps, 0
        if steps == 0:
            return None
        self.note(scene)
        self._follows = False
        self._current = min(max(self._current + steps, 0), len(self._scenes) - 1)
        return self._scenes[self._current]

    def _step_back(self, event: object) -> None:
        self._steps -= 1
        self._wake(event)

    def _step_forward(self, event: object) -> None:
        self._steps += 1
        self._wake(event)

"""Buttons of a lesson's page that download the exercise to which it leads."""

from __future__ import annotations

import viser

from app.panels.widgets import Wake, pressed
from app.teach.exercise_files import NOTEBOOK, SCRIPT, exercise_files


class ExerciseStart:
    """A button for a Python file, and one for a notebook; hidden where there is no exercise."""

    def __init__(self, client: viser.ClientHandle, wake: Wake) -> None:
        self._client = client
        self._names: tuple[str, ...] = ()
        self.file = client.gui.add_button(
            "Exercise as a Python file",
            visible=False,
            color="gray",
            hint="Downloads a file to begin with: what is asked, and the function to change.",
        )
        self.notebook = client.gui.add_button(
            "Exercise as a notebook",
            visible=False,
            color="gray",
            hint="Downloads a Jupyter notebook to begin with, which checks what you write.",
        )
        for button in (self.file, self.notebook):
            button.on_click(wake)

    def show(self, names: tuple[str, ...]) -> None:
        """Offer the exercises of these names; none hides the buttons."""
        self._names = names
        self.file.visible = self.notebook.visible = bool(names)

    def send_asked(self) -> None:
        """Download what was asked for since the last call."""
        buttons = {SCRIPT: self.file, NOTEBOOK: self.notebook}
        asked = [name for name, button in buttons.items() if pressed(button)]
        for name in asked if self._names else ():
            content = exercise_files(self._names)[name].encode()
            self._client.send_file_download(name, content, save_immediately=True)

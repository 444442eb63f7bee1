"""Buttons of a lesson's page that download the exercise to which it leads."""

from __future__ import annotations

import json

import viser

from abi.teach.catalogue import exercise
from abi.teach.exercise_file import beginning
from abi.teach.exercise_notebook import notebook
from app.panels.widgets import Wake, pressed

_NAME = "mine"
"""Name of the files, as the lessons and the documentation call them."""


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
        asked = pressed(self.file), pressed(self.notebook)
        if not self._names:
            return
        if asked[0]:
            self._send(f"{_NAME}.py", beginning(tuple(map(exercise, self._names))))
        if asked[1]:
            made = json.dumps(notebook(self._names), indent=1, ensure_ascii=False)
            self._send(f"{_NAME}.ipynb", f"{made}\n")

    def _send(self, name: str, text: str) -> None:
        self._client.send_file_download(name, text.encode(), save_immediately=True)

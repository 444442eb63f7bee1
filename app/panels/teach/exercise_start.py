"""Buttons of a lesson's page that download the exercise to which it leads."""

from __future__ import annotations

from collections.abc import Mapping

import viser

from app.panels.widgets import Wake, pressed
from app.teach.exercise_files import NOTEBOOK, SCRIPT, exercise_files


def add_exercise_buttons(gui: viser.GuiApi, wake: Wake) -> dict[str, viser.GuiButtonHandle]:
    """Add a button for a Python file and one for a notebook, both hidden, by the files' names."""
    file = gui.add_button(
        "Exercise as a Python file",
        visible=False,
        color="gray",
        hint="Downloads a file to begin with: what is asked, and the function to change.",
    )
    notebook = gui.add_button(
        "Exercise as a notebook",
        visible=False,
        color="gray",
        hint="Downloads a Jupyter notebook to begin with, which checks what you write.",
    )
    for button in (file, notebook):
        button.on_click(wake)
    return {SCRIPT: file, NOTEBOOK: notebook}


def send_asked(
    client: viser.ClientHandle,
    buttons: Mapping[str, viser.GuiButtonHandle],
    names: tuple[str, ...],
) -> None:
    """Download the files of these exercises whose buttons were pressed since the last call."""
    asked = [name for name, button in buttons.items() if pressed(button)]
    for name in asked if names else ():
        content = exercise_files(names)[name].encode()
        client.send_file_download(name, content, save_immediately=True)

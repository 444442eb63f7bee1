"""Links to what a tab shows, alone or with a challenge, and pictures of it."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import viser
from numpy.typing import NDArray

from app.camera.camera import aspect
from app.panels.files.files import file_stem
from app.panels.widgets import Wake, hidden_button, pressed
from app.state.frame import Frame
from app.state.tab_state import LONGEST_LINK, TabState
from app.teach.challenge import GOALS, Challenge, challenge_of
from app.ui import notices, page
from app.ui.overlay import Overlay, button

_WIDTH = 2560
"""Of a picture, [px]."""
_PATIENCE = 20.0
"""Seconds that a page has to draw it."""


class SharePanel:
    """Buttons, and the challenge of the link that opened the tab.

    Attributes:
        challenge: None for none.
        paused: whether another scene than the challenge's is shown.
    """

    def __init__(self, client: viser.ClientHandle, overlay: Overlay, wake: Wake) -> None:
        gui, self._client, self._overlay = client.gui, client, overlay
        self.link = gui.add_button(
            "Copy link", hint="The link opens this scene, camera, layers, time and lesson."
        )
        self.goal = gui.add_dropdown(
            "challenge", tuple(GOALS), hint="What whoever opens the link has to achieve."
        )
        self.challenge_link = gui.add_button(
            "Copy challenge link",
            color="gray",
            hint="The same link, with the challenge chosen above.",
        )
        self.picture = gui.add_button(
            "Save picture", color="gray", hint=f"A PNG {_WIDTH} pixels wide."
        )
        self._end = hidden_button(gui, "End challenge", wake)
        for one in (self.link, self.challenge_link, self.picture):
            one.on_click(wake)
        self.challenge: Challenge | None = None
        self.paused = False

    @property
    def keeps_task(self) -> bool:
        """True while a challenge is shown in which start, goal and obstacles have to stay."""
        return self.challenge is not None and not self.paused and self.challenge.task != ""

    @property
    def kept(self) -> str:
        """The challenge as a text to keep; empty for none."""
        return "" if self.challenge is None else self.challenge.model_dump_json()

    def share(self, state: Callable[[], TabState], frame: Frame, quiz: str = "") -> None:
        """Do what was asked for since the last call, with the tab's ``state()``.

        Args:
            state: of the tab.
            frame: what is drawn.
            quiz: of a link that was asked for; empty for none.
        """
        if quiz:
            self._copy(replace(state(), practice=quiz, challenge="", lessons=""))
        if pressed(self.link):
            self._copy(replace(state(), practice=""))
        if pressed(self.challenge_link):
            challenge = challenge_of(self.goal.value, frame)
            words = ""
            if challenge is None:
                words = "There is no plan to start from, or nothing left to gain."
            elif challenge.is_met(frame):
                words = "This scene meets it already."
            if challenge is None or words:
                notices.notify_refusal(self._client, "No challenge", words)
            else:
                self._copy(replace(state(), practice="", challenge=challenge.model_dump_json()))
        if pressed(self.picture):
            self._take_picture(file_stem(state().name))

    def end_if_requested(self) -> None:
        """End the challenge if its button was pressed since the last call."""
        if pressed(self._end):
            self.challenge = None

    def draw(self, frame: Frame) -> None:
        """Show the challenge, and whether it is met."""
        text = ""
        if self.challenge is not None and not self.paused:
            resting = not (frame.interactive or frame.plan.partial)
            met = resting and self.challenge.is_met(frame)
            end = button(self._end, "End", hint="Ends the challenge; the scene stays.")
            text = f'<div class="abi-card">{self.challenge.html(met, frame)} {end}</div>'
        self._overlay.show("challenge", text)

    def _copy(self, state: TabState) -> None:
        text = state.alone().encode()
        if len(text) > LONGEST_LINK:
            notices.notify_refusal(
                self._client, "Too much for a link", "Save the scene as a file instead."
            )
            return
        page.call(self._client, "copyLink", text)
        told, seconds = "Paste it where you like: it opens what you see now.", 5.0
        if state.challenge:
            told = "Paste it where you like: who opens it sees the challenge over this scene."
        if state.practice:
            told = "Paste it where you like: who opens it is asked these questions, without end."
        if state.scene.meshes.files:
            names = ", ".join(state.scene.meshes.files)
            seconds = 12.0
            told = (
                f"Paste it where you like. It finds {names} on this server only: for elsewhere, "
                "save the scene as a file."
            )
        # a browser that refuses the clipboard shows the link in a box instead
        self._client.add_notification("The link is ready", told, auto_close_seconds=seconds)

    def _take_picture(self, name: str) -> None:
        height = round(_WIDTH / max(aspect(self._client.camera), 0.2))
        try:
            picture = self._client.get_render(
                height, _WIDTH, transport_format="png", timeout=_PATIENCE
            )
        except Exception as error:  # viser raises a plain Exception where the page is gone
            notices.notify_refusal(
                self._client, "No picture", f"The page did not draw it ({error})."
            )
        else:
            self._client.send_file_download(f"{name}.png", png(picture), save_immediately=True)


def png(picture: NDArray[np.uint8]) -> bytes:
    """A picture (h, w, 3 or 4) as a PNG file (ISO/IEC 15948): one filtered block of scan lines."""
    height, width, channels = picture.shape
    lines = np.zeros((height, 1 + width * channels), np.uint8)
    lines[:, 1:] = picture.reshape(height, -1)
    colour = {3: 2, 4: 6}[channels]
    header = struct.pack(">IIBBBBB", width, height, 8, colour, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", zlib.compress(lines.tobytes(), 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in parts
    )

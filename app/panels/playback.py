"""Playback of the motion: play, pause, scrub and speed."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

import viser

from abi.arm_planning.joint_search.held_span import HeldSpan
from abi.arm_planning.motion.arm_clearance import ArmClearance
from abi.certification.verdict import TimeStretch
from app.panels.widgets import Wake, hidden_button
from app.ui.overlay import Overlay, button, slider
from app.ui.time_bar import bar_style, leg_at

SPEEDS = {"¼ ×": 0.25, "½ ×": 0.5, "real time": 1.0, "2 ×": 2.0}
_PAUSE_AT_END = 0.8
_JUST = 1e-3
"""Time after a contact at which it is over, [s]."""
_now = time.monotonic
_LATENCY = 3.0
"""Seconds that a frame may take to a page on a weak machine."""


class PlaybackPanel:
    """Clock of the motion, with the widgets that set it; those over the scene show it."""

    def __init__(self, gui: viser.GuiApi, overlay: Overlay, wake: Wake) -> None:
        self._overlay = overlay
        self.slider = gui.add_slider("time [s]", 0.0, 1.0, 0.01, 0.0, visible=False)
        self.button = hidden_button(gui, "Play or pause", self._toggle)
        self.speed = gui.add_dropdown("playback speed", tuple(SPEEDS), initial_value="real time")
        toggle = button(self.button, "Pause", kind="abi-play", hint="Or press Space.")
        overlay.show(
            "player",
            f'<div class="abi-card abi-player">{toggle}{slider(self.slider, "time [s]")}'
            "<output></output></div>",
        )
        self.playing = True
        self._wake = wake
        self._marked: ArmClearance | None = None
        self._begins: tuple[float, ...] = (0.0, 1.0)  # of the legs on the bar, and its end
        self._leg = 0
        self._drawn: tuple[object, ...] = ()
        self._written = 0.0
        self._time, self._rate = 0.0, 1.0
        self._again = True
        self._presses = self._counted = 0
        self._scrubbed = False
        self._advanced = self._sent = time.monotonic()
        self.slider.on_update(self._scrub)
        self.speed.on_update(wake)
        gui.add_command("Play or pause the arm", hotkey="space").on_trigger(self._toggle)

    def restore(self, time: float, playing: bool) -> None:
        """Go on from ``time`` [s], or stand still there."""
        self.playing = playing
        self._time, self._advanced = time, _now()

    def follow(self, time: float, playing: bool) -> None:
        """Stand at another tab's ``time`` [s], or play as it does: each by its own clock."""
        if not (playing and self.playing):
            self.restore(time, playing)

    @property
    def rate(self) -> float:
        """Seconds of the motion for one of the clock."""
        return SPEEDS.get(self.speed.value, 1.0)

    def sought(self) -> float | None:
        """The time on the bar, [s], if the slider has been set to another leg than is shown."""
        value = self.slider.value
        if not (self._scrubbed or value != self._written) or not math.isfinite(value):
            return None
        if leg_at(self._begins, value) == self._leg:
            return None
        self._written, self._scrubbed, self.playing = value, False, False
        return value

    def advance(
        self, duration: float, again: bool = True, legs: tuple[float, ...] = (), leg: int = 0
    ) -> float:
        """Advance to now; the time to show, [s].

        The page plays by its own clock: it is told the time only once it stands.

        Args:
            duration: of the motion, [s].
            again: whether it begins anew a moment after its end. Otherwise it stays there, where
                another leg follows.
            legs: when each leg of a sequence begins, and when the last one ends, [s]; none for a
                motion alone.
            leg: number of the one that is shown, from 0.
        """
        now = time.monotonic()
        played, self._advanced = (now - self._advanced) * self._rate, now
        self._rate = self.rate
        if self.playing:
            period = duration + _PAUSE_AT_END * self._rate
            self._time += played
            self._time = math.fmod(self._time, period) if again else min(self._time, duration)
        self._again = again
        if (presses := self._presses) != self._counted:
            self.playing ^= bool((presses - self._counted) % 2)
            self._counted = presses
        self._begins, self._leg = legs or (0.0, duration), leg
        before, end = self._begins[leg], max(round(self._begins[-1], 2), 0.01)
        if self.slider.max != end:
            self.slider.max = end
        was_scrubbed, self._scrubbed = self._scrubbed, False
        if not math.isfinite(self.slider.value):
            self.slider.value, was_scrubbed = self._written, False
        scrubbed = self.slider.value
        if was_scrubbed or scrubbed != self._written:
            if now - self._sent < _LATENCY:
                # a frame on its way may have overwritten the number in the page: it is sent again,
                # changed by the last bit, since an equal one is not sent
                scrubbed = math.nextafter(scrubbed, 0.0)
                self.slider.value = scrubbed
            self._time, self._written, self.playing = scrubbed - before, scrubbed, False
        shown = min(max(self._time, 0.0), duration)
        at = before + shown
        if not self.playing and (abs(at - self._written) >= 0.05 or self._written > end):
            self._written = round(at, 2)
            self.slider.value = self._written
            self._sent = now
        told = at if self.playing else self._written
        self._overlay.set_clock(told, end, self.playing, before)
        return shown

    def until_contact(self, duration: float) -> float | None:
        """Time until a link of the arm that plays begins or ends to touch something, [s].

        0 or less where one has since the motion advanced last; None where none ever does.
        """
        contacts = () if self._marked is None else self._marked.contacts
        if not contacts:
            return None
        # a new round may begin with other links than the last one has ended with
        moments = {0.0, *(one.first for one in contacts), *(one.last + _JUST for one in contacts)}
        if not self._again:
            moments = {moment for moment in moments if self._time < moment <= duration}
            return self._until(min(moments)) if moments else None
        period = duration + _PAUSE_AT_END * self._rate
        ahead = min((moment - self._time) % period or period for moment in moments)
        return ahead / self._rate - (time.monotonic() - self._advanced)

    def until_end(self, duration: float) -> float | None:
        """Time until the motion that plays has come to its end, [s]; None if none plays."""
        return self._until(duration) if self.playing else None

    def _until(self, moment: float) -> float:
        """Time until a moment of this round, [s] of the clock."""
        return (moment - self._time) / self._rate - (time.monotonic() - self._advanced)

    def mark(
        self,
        clearance: ArmClearance | None,
        duration: float,
        seen: bool = True,
        checked: Sequence[TimeStretch] = (),
        held: Sequence[HeldSpan] = (),
    ) -> None:
        """Colour the times at which the arm touches something; no player without a motion.

        Nor is there one, nor a speed to choose, while the arm is not to be ``seen``. Of a motion
        that was ``checked`` each stretch has a colour. A line says where the tool's direction is
        ``held``.
        """
        moves, begins = duration > 0 and seen, self._begins
        self.speed.visible = seen
        if clearance is self._marked and (moves, begins, self._leg) == self._drawn:
            return
        self._marked, self._drawn = clearance, (moves, begins, self._leg)
        contacts = () if clearance is None else clearance.contacts
        stretches = checked or [TimeStretch(one.first, one.last, "touches") for one in contacts]
        at = begins[self._leg]
        stretches = [one._replace(first=one.first + at, last=one.last + at) for one in stretches]
        later = [one.later(at) for one in held]
        end = begins[-1] if moves else 0.0
        self._overlay.show("marks", bar_style(stretches, end, later, begins[1:-1]))

    def _toggle(self, event: object) -> None:
        self._presses += 1
        self._wake(event)

    def _scrub(self, event: viser.GuiEvent[viser.GuiSliderHandle[float]]) -> None:
        self._scrubbed |= event.client is not None
        self._wake(event)

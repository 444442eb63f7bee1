"""Tour of the page in five steps."""

from __future__ import annotations

from app.panels.widgets import Wake, hidden_button, pressed
from app.state.frame import Frame
from app.ui import page
from app.ui.layout import Layout
from app.ui.overlay import button


def _placed(wide: str, phone: str = "") -> str:
    """HTML of words that are others on a phone, where the panels are one sheet."""
    return f'<span class="abi-wide">{wide}</span><span class="abi-phone">{phone}</span>'


STEPS = (
    "<b>Drag the orange obstacle</b>, or the balls at start and goal. Everything follows: "
    "grid, searches, curves and arm.",
    f"<b>{_placed('On the left', 'Behind the heading at the bottom')}</b> are the six stages in "
    "order; each heading gives the stage's result. Try another spacing of the nodes.",
    f"<b>{_placed('On the right', 'Below the stages')}</b> is what came out: the searches side by "
    "side, and how much longer each stage's path is than the best possible. <i>Search</i> goes "
    "through each search step by step.",
    f"<b>Below</b> is the player. Press {_placed('Space', 'Play')}, or move the slider, and watch "
    "the arm follow the curve; <i>Plots</i> shows its joints over time.",
    "<b>In <i>Scene</i></b> you add obstacles or your own STL file, save, and copy a link. "
    "<i>Learn</i> has lessons. <i>Undo</i> takes back every change of the scene"
    f"{_placed('; the key H shows all keys')}.",
)


_NAMED: tuple[tuple[str, ...], ...] = (
    ("scene",),
    ("left",),
    ("right",),
    ("player",),
    ("Scene", "Learn"),
)
"""What each step speaks of, as ``pointOut`` of ``assets/page`` has it."""


class Tour:
    """A card with the step, and buttons to go on, back, or to end it; its subject is framed.

    Attributes:
        begin: button of the toolbar that begins it; hidden itself.
    """

    def __init__(self, layout: Layout, wake: Wake) -> None:
        self._overlay, self._client = layout.overlay, layout.client
        gui = layout.client.gui
        self.begin = hidden_button(gui, "Tour", wake)
        self._next = hidden_button(gui, "Next", wake)
        self._back = hidden_button(gui, "Back", wake)
        self._end = hidden_button(gui, "End", wake)
        self._step: int | None = None
        self._framed: int | None = None
        self._in_lesson = False

    def draw(self, frame: Frame) -> None:
        """Show the step that the buttons lead to; a lesson that begins ends it."""
        if frame.lesson and not self._in_lesson:
            self._step = None
        self._in_lesson = frame.lesson
        if pressed(self.begin):
            self._step = 0
        if pressed(self._next) and self._step is not None:
            self._step = self._step + 1 if self._step + 1 < len(STEPS) else None
        if pressed(self._back) and self._step:
            self._step -= 1
        if pressed(self._end):
            self._step = None
        if self._step != self._framed:
            self._framed = self._step
            named = None if self._step is None else _NAMED[self._step]
            page.call(self._client, "pointOut", named)
        self._overlay.show("tour", "" if self._step is None else self._card(self._step))

    def _card(self, step: int) -> str:
        last = step == len(STEPS) - 1
        buttons = button(self._back, "Back", enabled=step > 0)
        buttons += button(self._next, "Done" if last else "Next")
        if not last:
            buttons += button(self._end, "End")
        return (
            f'<div class="abi-card abi-tour">{step + 1} of {len(STEPS)}. {STEPS[step]}'
            f'<div class="abi-buttons" style="margin-top:5px">{buttons}</div></div>'
        )

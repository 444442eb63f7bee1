"""Tour of the page in five steps."""

from __future__ import annotations

import viser

from app.panels.widgets import Wake, hidden_button, pressed
from app.state.frame import Draw, Frame
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


def tour(layout: Layout, begin: viser.GuiButtonHandle, wake: Wake) -> Draw:
    """A card with the step, and buttons to go on, back, or to end it; its subject is framed.

    The button ``begin`` begins it; a lesson that begins ends it.
    """
    client, overlay = layout.client, layout.overlay
    forward, back, end = (hidden_button(client.gui, one, wake) for one in ("Next", "Back", "End"))
    step: int | None = None
    framed: int | None = None
    in_lesson = False

    def draw(frame: Frame) -> None:
        nonlocal step, framed, in_lesson
        if frame.lesson and not in_lesson:
            step = None
        in_lesson = frame.lesson
        if pressed(begin):
            step = 0
        if pressed(forward) and step is not None:
            step = step + 1 if step + 1 < len(STEPS) else None
        if pressed(back) and step:
            step -= 1
        if pressed(end):
            step = None
        if step != framed:
            framed = step
            page.call(client, "pointOut", None if step is None else _NAMED[step])
        overlay.show("tour", "" if step is None else _card(step, back, forward, end))

    return draw


def _card(
    step: int,
    back: viser.GuiButtonHandle,
    forward: viser.GuiButtonHandle,
    end: viser.GuiButtonHandle,
) -> str:
    last = step == len(STEPS) - 1
    buttons = button(back, "Back", enabled=step > 0)
    buttons += button(forward, "Done" if last else "Next")
    if not last:
        buttons += button(end, "End")
    return (
        f'<div class="abi-card abi-tour">{step + 1} of {len(STEPS)}. {STEPS[step]}'
        f'<div class="abi-buttons" style="margin-top:5px">{buttons}</div></div>'
    )

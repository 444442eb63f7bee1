"""The student's file in the page: what was found, and the counterexample in the scene."""

from __future__ import annotations

import html
from collections.abc import Callable

import viser

from abi.scene.scene import Scene
from abi.teach.catalogue import exercise
from abi.teach.exercise import Counterexample
from abi.teach.verdict import ExerciseVerdict
from app.panels.teach.search_theatre import TheatrePanel
from app.panels.widgets import Wake, pressed
from app.state.frame import Frame
from app.teach.exercise_watch import ExerciseWatch, Findings
from app.teach.lesson import SearchCue, Setting
from app.ui import style

_FIRST = -2.0
"""Place in the tab: before the class and the lessons."""
_SHOWN = ("workspace", "obstacles")


class ExercisePanel:
    """Widgets of one tab."""

    def __init__(
        self,
        client: viser.ClientHandle,
        watch: ExerciseWatch,
        theatre: TheatrePanel,
        wake: Wake,
        nudge: Callable[[], None],
    ) -> None:
        gui, self._watch, self._theatre, self._tab = client.gui, watch, theatre, client.client_id
        self._shown: Counterexample | None = None
        self._drawn: tuple[object, ...] = ()
        with gui.add_folder("Your exercise", order=_FIRST):
            self._text = gui.add_html("")
            self.open = gui.add_button(
                "Show the counterexample", visible=False, hint="The case that is wrong, as a scene."
            )
            self.back = gui.add_button("Back to my scene", visible=False, color="gray")
        for button in (self.open, self.back):
            button.on_click(wake)
        watch.join(self._tab, nudge)

    def close(self) -> None:
        """Hear of the file no longer."""
        self._watch.leave(self._tab)

    def cue(self) -> tuple[Setting, Scene] | None:
        """The counterexample as a view, if it was asked for since the last call."""
        case = _case(self._watch.found)
        if not pressed(self.open) or case is None:
            return None
        self._shown = case
        self._theatre.compare(case.scene, case.steps, case.right_steps)
        search = SearchCue(on=bool(case.steps), step=case.parting + 1 if case.steps else None)
        return Setting(scene="counterexample", shown=_SHOWN, search=search), case.scene

    def left(self) -> bool:
        """Check whether the counterexample was left since the last call."""
        left = pressed(self.back) and self._shown is not None
        if self._shown is not None and left:
            self._theatre.compare(self._shown.scene, (), ())
            self._shown = None
        return left

    def draw(self, frame: Frame) -> None:
        """Show what was found; no frame counts."""
        found = self._watch.found
        state = found, self._shown is None
        if state == self._drawn:
            return
        self._drawn = state
        case = _case(found)
        self._text.content = style.paragraph(_told(self._watch.name, found))
        self.open.visible = case is not None
        self.back.visible = self._shown is not None


def _case(found: Findings) -> Counterexample | None:
    """The first counterexample; None where there is none."""
    verdicts = () if isinstance(found, str) else found.values()
    cases = (one.counterexample for one in verdicts if one is not None)
    return next((case for case in cases if case is not None), None)


def _told(file: str, found: Findings) -> str:
    """What was found, as HTML: the file is the student's, and so is every word of an error."""
    name = html.escape(file)
    if isinstance(found, str):
        return f"<b>{name}</b> {html.escape(found)}"
    lines = [
        f"checking <b>{checked}</b> …" if verdict is None else _line(verdict)
        for checked, verdict in found.items()
    ]
    return "<br>".join([f"{name}, checked whenever it is saved:", *lines])


def _line(verdict: ExerciseVerdict) -> str:
    colour = style.readable(style.GOOD if verdict.passed else style.BAD)
    sign = "✓" if verdict.passed else "✗"
    title = html.escape(exercise(verdict.exercise).title)
    sentence = html.escape(verdict.sentence)
    case = verdict.counterexample
    if case is not None and case.expected:
        yours, right = html.escape(case.got), html.escape(case.expected)
        sentence += f"<br>Yours: <b>{yours}</b>. Right: <b>{right}</b>."
    return f'<b style="color:{colour}">{sign} {title}.</b> {sentence}'

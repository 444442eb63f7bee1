"""What is said over the scene: numbers, what to do and what was just done, or what is wrong.

It lies over the scene, so that no control moves under the user's hand when it changes.
"""

from __future__ import annotations

import html
from typing import Any

import viser

from abi.arm_planning.arm_errors import ArmNotClear
from abi.errors import BLOCKED, NO_PATH, NOT_HELD, AbiError, StageError
from abi.explain.reason import Reason
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.panels.arm_banner import arm_banner, arm_changes, arm_fault
from app.panels.base_offer import base_buttons, base_card, base_sentence
from app.panels.files.check_motion import CheckMotionPanel
from app.panels.files.share import SharePanel
from app.panels.headline import shown_numbers
from app.panels.legs import LegsCard
from app.panels.offered_changes import Offers, offered_changes
from app.panels.plan_sentence import OBSTACLES, longer_on_finer, plan_sentence
from app.panels.stages.find_base import FindBasePanel
from app.panels.teach.lesson_mark import lesson_mark
from app.panels.teach.lessons import LessonPanel
from app.panels.widgets import Wake, hidden_button, pressed
from app.shared.puzzles import is_puzzle
from app.stages.catalogue import SHOWN_STAGES
from app.state.frame import Frame
from app.theatre.text import question
from app.theatre.theatre import Theatre
from app.ui.arm_size import MADE_FOR_ARMS, fitting_lengths, scene_size_note
from app.ui.labels import kept, sentence
from app.ui.layout import Layout
from app.ui.overlay import button

_ARM = "arm"

_MOST_CHANGES = 3
"""Most changes of the scene that are offered at once."""
_NOT_CHANGED = "Not changed. "
"""Begin of a message on a change that was refused, which the first sentence belongs to."""

_TOOL_ALONE = (
    "As in the paper, only the path of the tool tip is planned: links may touch obstacles."
)


class Messages:
    """Headline numbers, one sentence, and the buttons of the change that helps."""

    def __init__(
        self,
        layout: Layout,
        bases: FindBasePanel,
        lessons: LessonPanel,
        share: SharePanel,
        check: CheckMotionPanel,
        undo: viser.GuiButtonHandle,
        wake: Wake,
    ) -> None:
        self._lessons, self._share, self._check = lessons, share, check
        self._bases, self._undo = bases, undo
        self._overlay = layout.overlay
        gui = layout.client.gui
        self._open_lesson = hidden_button(gui, "Open the lesson", layout.open_learn)
        self._accepts = tuple(hidden_button(gui, "Accept", wake) for _ in range(_MOST_CHANGES))
        self.point_out = hidden_button(gui, "Show it", wake)
        self._offers: Offers = {}
        self._other_scene = hidden_button(gui, f"Open {MADE_FOR_ARMS}", wake)
        self.legs = LegsCard(gui, wake)
        self._reason: Reason | None = None
        self._tool_alone: Scene | None = None
        self._drawn: tuple[object, ...] = ()

    def draw(self, frame: Frame) -> None:
        """Write numbers and sentence for a frame."""
        self._overlay.show("numbers", shown_numbers(frame))
        shown = frame.plan, frame.current, frame.refused, frame.reason, frame.interactive
        preview = frame.demonstrates, _was_whole(frame.before)
        still = self._share.keeps_task
        told = (
            self._mark,
            frame.asks,
            _ARM in frame.shown,
            frame.theatre is not None,
            still,
            OBSTACLES in frame.shown,
            frame.stage,
        )
        state = *shown, *preview, *told, self._bases.running, frame.bases, *self.legs.state()
        if state == self._drawn:
            return
        self._drawn = state
        contact, before, self._offers = "", self._offers, {}
        self._reason = None if frame.refused is not None else frame.reason
        if frame.refused is not None:
            content = _error(
                _NOT_CHANGED + sentence(frame.refused), kept(frame.refused, frame.plan.scene)
            )
        elif frame.checked is not None and frame.outdated:
            content = _planning("Checking the motion")
        elif frame.checked is not None:
            content = self._check.card(frame.checked)
        elif frame.outdated and frame.plan.mesh is None:
            content = _planning("Planning this scene")
        elif frame.theatre is not None and not frame.lesson and not frame.stage:
            content = f'<div class="abi-card">{_stepping(frame.theatre)}</div>'
        elif frame.plan.error is not None:
            content = self._failure(frame, frame.plan.error)
        elif frame.stage:
            content = f'<div class="abi-card">{SHOWN_STAGES[frame.stage].sentence}</div>'
            contact = self._banner(frame.plan) if _ARM in frame.shown else ""
        else:
            progress = f"{plan_sentence(frame, still)} {self._remark(frame)}".strip()
            content = f'<div class="abi-card">{progress}</div>' if progress else ""
            if not frame.lesson or (_ARM in frame.shown and not frame.asks):
                contact = self._banner(frame.plan)
        if not (frame.outdated or frame.stage or frame.theatre is not None):
            content += base_card(self._bases, frame)
        self._overlay.show("message", self._mark + self.legs.html() + content)
        self._overlay.show("contact", contact)
        if self._offers != before:
            for accept in self._accepts:
                pressed(accept)  # another change was meant

    @property
    def _mark(self) -> str:
        """The line on the lesson that is gone through."""
        return lesson_mark(self._lessons, self._open_lesson)

    def tell(self, doing: str) -> None:
        """Tell what the plan does that is being made, until the next frame."""
        self.wait(f"Planning: {doing}")

    def wait(self, what: str) -> None:
        """Tell what is done, until the next frame."""
        self._drawn = ()
        self._overlay.show("message", self._mark + _planning(what))

    def accepted_change(self) -> dict[str, Any] | None:
        """The change of the scene whose button was pressed since the last call."""
        accepted = [pressed(accept) for accept in self._accepts]
        offered = zip(self._offers.values(), accepted, strict=False)
        return next((change for change, was in offered if was), None)

    def asks_for_other_scene(self) -> bool:
        """Check whether the scene made for large arms was asked for since the last call."""
        return pressed(self._other_scene)

    def pointed_out(self) -> int | None:
        """The obstacle that was asked for since the last call."""
        asked = pressed(self.point_out)
        return self._reason.obstacle if asked and self._reason is not None else None

    def _remark(self, frame: Frame) -> str:
        """What may surprise: a longer path on a finer grid, or that the tool alone is planned.

        The latter is said of the first such scene, until it changes.
        """
        scene = frame.plan.scene
        if frame.lesson or frame.theatre is not None or is_puzzle(scene):
            return ""
        if frame.before is not None and (longer := longer_on_finer(frame.before, frame.plan)):
            return longer
        if scene.arm.avoid:
            return ""
        self._tool_alone = self._tool_alone or scene
        return _TOOL_ALONE if scene is self._tool_alone else ""

    def _banner(self, plan: Plan) -> str:
        """Fault of the arm's motion, and the buttons of what may help."""
        if arm_fault(plan) is None:
            return ""
        if scene_size_note(plan.scene) is not None:
            return arm_banner(plan, self._size_buttons(plan.scene))
        return arm_banner(plan, self._offered(arm_changes(plan)))

    def _size_buttons(self, scene: Scene) -> str:
        """Button that fits the paper's arm to a scene, or opens one made for other arms."""
        if scene.arm.model == "abi":
            return self._offered({"Fit the arm to the scene": {"arm": fitting_lengths(scene)}})
        return button(self._other_scene, f"Open {MADE_FOR_ARMS}")

    def _offered(self, offers: Offers) -> str:
        """Buttons of changes of the scene, of which the last offered count."""
        self._offers = offers
        pairs = zip(self._accepts, offers, strict=False)
        return "".join(button(accept, label) for accept, label in pairs)

    def _failure(self, frame: Frame, error: AbiError) -> str:
        """Reason why there is no plan, and the buttons of what would help."""
        reason = frame.reason
        explained = error if reason is None else reason
        dots = ""
        if isinstance(error, StageError) and error.kind == NO_PATH:
            dots = "Blue dots: nodes that the start reaches."
        of_arm = isinstance(error, StageError) and error.stage == "arm"
        if of_arm and (size := scene_size_note(frame.plan.scene)) is not None:
            title, numbers = size  # no other base, and no setting, makes it fit
            return _with_buttons(_error(f"{title}.", numbers), self._size_buttons(frame.plan.scene))
        alone = ""
        if reason is not None and isinstance(error, ArmNotClear):
            alone = "The plan shown is for the tool tip alone."
        hints = (explained.hint, dots, _marked(frame), base_sentence(self._bases, frame), alone)
        tell = _puzzle if is_puzzle(frame.plan.scene) else _error
        content = tell(explained.message, " ".join(filter(None, hints)))
        buttons = self._offered(offered_changes(reason))
        if reason is not None and reason.obstacle is not None:
            buttons += button(self.point_out, f"Show obstacle {reason.obstacle + 1}")
        buttons += base_buttons(self._bases, frame)
        if not buttons and reason is not None and _was_whole(frame.before):
            buttons = button(self._undo, "Undo")
        return _with_buttons(content, buttons)


def _planning(what: str) -> str:
    """What is done for a plan that is being made, over a bar."""
    bar = '<progress style="display:block;width:100%"></progress>'
    return f'<div class="abi-card" role="status">{html.escape(what)} …{bar}</div>'


def _stepping(theatre: Theatre) -> str:
    """What to do while a search is stepped through, also one that finds no path."""
    if theatre.asking and not theatre.state.done:
        return question(theatre)
    return (
        "<b>A search, step by step.</b> Point at a node, or tap it, for its g, h and f. "
        "Paths, curves and arm are hidden until you close it."
    )


def _marked(frame: Frame) -> str:
    """What the magenta points of a reason are, which the scene marks; empty where it has none."""
    reason, error = frame.reason, frame.plan.error
    if reason is None or not len(reason.points):
        return ""
    if error is not None and error.kind in BLOCKED:
        return "Magenta: the nearest free point."
    if error is not None and error.kind == NO_PATH:
        return "Magenta: the narrowest place." if len(reason.points) == 1 else ""
    # of an arm in the way the sentence says where
    is_of_curve = error is not None and error.kind == NOT_HELD
    return "Magenta: where the curve comes too near." if is_of_curve else ""


def _was_whole(before: Plan | None) -> bool:
    """Check whether there was a plan without an error before, to which one may go back."""
    return before is not None and before.error is None


def _with_buttons(content: str, buttons: str) -> str:
    if not buttons:
        return content
    return f'{content}<div class="abi-buttons" style="margin-top:6px">{buttons}</div>'


def _puzzle(message: str, hint: str) -> str:
    """Message and hint of a scene that is shipped with a fault, as HTML."""
    first, more = _first_sentence(message)
    return (
        '<div class="abi-card" role="status"><b>This scene asks for a change.</b> '
        f"{html.escape(first)} {html.escape(hint)}{more}</div>"
    )


def _error(message: str, hint: str) -> str:
    """Message and hint as HTML; escaped, since both can quote what a user typed.

    Of a message of several sentences the first is seen at once, and the others on demand.
    """
    first, more = _first_sentence(message)
    return (
        '<div class="abi-card abi-error" role="alert">'
        f"<b>✗ {html.escape(first)}</b> {html.escape(hint)}{more}</div>"
    )


def _first_sentence(message: str) -> tuple[str, str]:
    """The first sentence of a message, and the others folded, as HTML; empty for none."""
    kept = _NOT_CHANGED if message.startswith(_NOT_CHANGED) else ""
    first, stop, others = message.removeprefix(kept).partition(". ")
    if not stop:
        return message, ""
    return f"{kept}{first}.", f"<details><summary>More</summary>{html.escape(others)}</details>"

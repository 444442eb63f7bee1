"""The sentence over the scene: what to do and what was just done, or what is wrong and what helps.

It lies over the scene, so that no control moves under the user's hand when it changes.
"""

from __future__ import annotations

import html
import math
from typing import Any

import viser

from abi.arm_planning.arm_errors import ArmNotClear
from abi.errors import AbiError, ClearanceNotHeld, NoPath, PointBlocked, StageError
from abi.explain.reason import Reason
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.panels.arm_banner import ArmBanner
from app.panels.base_offer import base_buttons, base_card, base_sentence
from app.panels.files.check_motion import CheckMotionPanel
from app.panels.files.share import SharePanel
from app.panels.legs import LegsCard
from app.panels.stages.find_base import FindBasePanel
from app.panels.teach.lesson_mark import lesson_mark
from app.panels.teach.lessons import LessonPanel
from app.panels.widgets import Wake, hidden_button, pressed
from app.shared.puzzles import is_puzzle
from app.stages.catalogue import SHOWN_STAGES
from app.state.frame import Frame
from app.theatre.text import question
from app.theatre.theatre import Theatre
from app.ui import style
from app.ui.arm_size import scene_size_note
from app.ui.labels import LABELS, kept, sentence
from app.ui.layout import Layout
from app.ui.numbers import format_length, format_setting, format_time
from app.ui.overlay import button

_OBSTACLES = "obstacles"
"""Switch of the layers that shows them."""
_ARM = "arm"

_MOST_CHANGES = 3
"""Most changes of the scene that are offered at once."""
_NOT_CHANGED = "Not changed. "
"""Begin of a message on a change that was refused, which the first sentence belongs to."""

_TOOL_ALONE = (
    "As in the paper, only the path of the tool tip is planned: links may touch obstacles."
)

_JOINTS_ALONE = (
    "The arm finds its way by its joints here: the mesh has none for the tool tip. Purple: where "
    "the tool goes in the joint poses that were tried."
)


class Messages:
    """One sentence, and the buttons of the change that helps."""

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
        self.banner = ArmBanner(gui, wake)
        self.legs = LegsCard(gui, wake)
        self._reason: Reason | None = None
        self._tool_alone: Scene | None = None
        self._drawn: tuple[object, ...] = ()

    def draw(self, frame: Frame) -> None:
        """Write the sentence for a frame."""
        shown = frame.plan, frame.current, frame.refused, frame.reason, frame.interactive
        preview = frame.demonstrates, _was_whole(frame.before)
        still = self._share.keeps_task
        told = (
            self._mark,
            frame.asks,
            _ARM in frame.shown,
            frame.theatre is not None,
            still,
            _OBSTACLES in frame.shown,
            frame.stage,
        )
        state = *shown, *preview, *told, self._bases.running, frame.bases, *self.legs.state()
        if state == self._drawn:
            return
        self._drawn = state
        contact = ""
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
            contact = self.banner.html(frame.plan) if _ARM in frame.shown else ""
        else:
            progress = f"{_progress(frame, still)} {self._remark(frame)}".strip()
            content = f'<div class="abi-card">{progress}</div>' if progress else ""
            if not frame.lesson or (_ARM in frame.shown and not frame.asks):
                contact = self.banner.html(frame.plan)
        if not (frame.outdated or frame.stage or frame.theatre is not None):
            content += base_card(self._bases, frame)
        self._overlay.show("message", self._mark + self.legs.html() + content)
        self._overlay.show("contact", contact)

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
        if (change := self.banner.accepted_change()) is not None:
            return change
        changes = _changes(self._reason)
        accepted = [pressed(accept) for accept in self._accepts]
        return next((one for one, was in zip(changes, accepted, strict=False) if was), None)

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
        if frame.before is not None and (longer := _longer_on_finer(frame.before, frame.plan)):
            return longer
        if scene.arm.avoid:
            return ""
        self._tool_alone = self._tool_alone or scene
        return _TOOL_ALONE if scene is self._tool_alone else ""

    def _failure(self, frame: Frame, error: AbiError) -> str:
        """Reason why there is no plan, and the buttons of what would help."""
        reason = frame.reason
        explained = error if reason is None else reason
        dots = "Blue dots: nodes that the start reaches." if isinstance(error, NoPath) else ""
        of_arm = isinstance(error, StageError) and error.stage == "arm"
        if of_arm and (size := scene_size_note(frame.plan.scene)) is not None:
            title, numbers = size  # no other base, and no setting, makes it fit
            return _with_buttons(
                _error(f"{title}.", numbers), self.banner.other_size(frame.plan.scene)
            )
        alone = ""
        if reason is not None and isinstance(error, ArmNotClear):
            alone = "The plan shown is for the tool tip alone."
        hints = (explained.hint, dots, _marked(frame), base_sentence(self._bases, frame), alone)
        tell = _puzzle if is_puzzle(frame.plan.scene) else _error
        content = tell(explained.message, " ".join(filter(None, hints)))
        buttons = "".join(
            button(accept, _change_label(change, reason))
            for accept, change in zip(self._accepts, _changes(reason), strict=False)
        )
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


def _progress(frame: Frame, still: bool = False) -> str:
    """Task, and what the last plan did, in numbers; ``still`` where nothing is to be dragged."""
    plan = frame.plan
    if plan.path is None and plan.joint_search is not None and not frame.lesson:
        return _JOINTS_ALONE
    if plan.free is None or plan.path is None or not frame.tells_curve:
        return ""
    name = style.ALGORITHMS[plan.path.algorithm][0]
    preview = "≈ one search while you drag · " if frame.plan.partial else ""
    if frame.plan.coarse:
        preview = "≈ coarser while you drag · "
    length = ""
    if plan.followed_arc is not None and plan.followed is not None:
        length = f"{format_length(plan.followed_arc.length)} {plan.scene.unit}"
        length = f", a {_whole(style.CURVES[plan.followed][0])} of {_whole(length)}"
    if plan.joint_search is not None:
        length = "; the joints follow a curve of their own"
    took = f" in {_whole(format_time(max(time, 1)))}" if (time := _replan_ms(plan)) else ""
    did = f"{preview}Planned{took}: {name} on {plan.free.nodes:,} nodes{length}."
    if frame.lesson:  # it says itself what there is to do
        return did
    if still:  # what there is to do stands below, and it is not to drag
        return did
    invitation = _invitation(plan, _OBSTACLES in frame.shown)
    if frame.demonstrates:
        invitation = f"Demo: touch anything to take over. {invitation}"
    return f"<b>{invitation}</b> {did}"


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
    if isinstance(error, PointBlocked):
        return "Magenta: the nearest free point."
    if isinstance(error, NoPath):
        return "Magenta: the narrowest place." if len(reason.points) == 1 else ""
    # of an arm in the way the sentence says where
    return "Magenta: where the curve comes too near." if isinstance(error, ClearanceNotHeld) else ""


def _longer_on_finer(before: Plan, plan: Plan) -> str:
    """Why a plan's path is longer than the one before, though its grid is finer; else empty."""
    old, new, unit = before.path, plan.path, plan.scene.unit
    if old is None or new is None or plan.scene.mesh.pitch >= before.scene.mesh.pitch:
        return ""
    same = before.scene.model_copy(update={"mesh": plan.scene.mesh}) == plan.scene
    if not same or format_length(new.length) == format_length(old.length):
        return ""
    if new.length < old.length:
        return ""
    lengths = _whole(f"{format_length(old.length)} → {format_length(new.length)} {unit}")
    return f"The path on this finer grid is longer, {lengths}: its nodes lie elsewhere."


def _replan_ms(plan: Plan) -> float:
    """Time of all stages, [ms], also of those that an earlier pass over the same mesh has done.

    0 where it is not known: of code that was not compiled the time says nothing.
    """
    left_out = set(style.ALGORITHMS) - {result.algorithm for result in plan.searches}
    if plan.taut is None:
        left_out.add("taut")
    needed = plan.ms.get("mesh", 0.0), plan.ms.get("graph", 0.0), plan.total_ms
    return sum(ms for name, ms in plan.ms.items() if name not in left_out) if all(needed) else 0.0


def _whole(text: str) -> str:
    """HTML of a text in which no line ends."""
    return f'<span style="white-space:nowrap">{html.escape(text)}</span>'


def _invitation(plan: Plan, seen: bool) -> str:
    """What to drag; no obstacle while none is ``seen``."""
    obstacles = plan.scene.obstacles
    if not obstacles or not seen:
        return "Drag start or goal."
    if len(obstacles) > 1:
        return "Drag an orange obstacle."
    return f"Drag the orange {'obstacle' if obstacles[0].shape == 'mesh' else obstacles[0].shape}."


def _was_whole(before: Plan | None) -> bool:
    """Check whether there was a plan without an error before, to which one may go back."""
    return before is not None and before.error is None


def _changes(reason: Reason | None) -> tuple[dict[str, Any], ...]:
    """Changes of the scene that give a plan; none that only leads to the next error."""
    if reason is None or reason.change is None or not reason.is_whole:
        return ()
    return reason.change, *reason.others


def _change_label(change: dict[str, Any], reason: Reason | None) -> str:
    """Text of the button that makes one of a diagnosis' changes of the scene."""
    if reason is not None and reason.obstacle is not None:
        return f"Remove obstacle {reason.obstacle + 1}"
    parts = []
    for section, value in change.items():
        if section == "obstacles" and reason is not None and reason.moved is not None:
            parts.append(f"move obstacle {reason.moved + 1} there")
        elif section in ("start", "goal"):
            parts.append(f"move the {section}")
        elif isinstance(value, dict):
            for name, number in value.items():
                label = LABELS.get(f"{section}.{name}", name)
                kept = isinstance(number, dict)
                parts.append(_kept(number) if kept else f"set {label} to {_setting(number)}")
        else:
            parts.append(f"change {section}")
    text = " and ".join(parts)
    return text[:1].upper() + text[1:]


def _kept(axis: dict[str, Any]) -> str:
    """Advice on how to hold the tool's direction for a part of the motion only."""
    begin, end = 100 * axis["from"], 100 * axis["to"]
    within = math.degrees(axis["tolerance"])
    return f"keep the direction within {within:.3g}° from {begin:.3g} to {end:.3g} % of the time"


def _setting(value: object) -> str:
    """A setting as it is written on the page; coordinates in parentheses."""
    if isinstance(value, list | tuple):
        return f"({', '.join(map(_setting, value))})"
    return format_setting(value) if isinstance(value, float) else str(value)


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

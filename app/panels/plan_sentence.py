"""The sentence on a plan that is shown: what to drag, what was planned, and what may surprise."""

from __future__ import annotations

import html

from abi.planner.plan import Plan
from app.state.frame import Frame
from app.ui import style
from app.ui.numbers import format_length, format_time

OBSTACLES = "obstacles"
"""Switch of the layers that shows them."""
_JOINTS_ALONE = (
    "The arm finds its way by its joints here: the mesh has none for the tool tip. Purple: where "
    "the tool goes in the joint poses that were tried."
)


def plan_sentence(frame: Frame, still: bool = False) -> str:
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
    invitation = _invitation(plan, OBSTACLES in frame.shown)
    if frame.demonstrates:
        invitation = f"Demo: touch anything to take over. {invitation}"
    return f"<b>{invitation}</b> {did}"


def _invitation(plan: Plan, seen: bool) -> str:
    """What to drag; no obstacle while none is ``seen``."""
    obstacles = plan.scene.obstacles
    if not obstacles or not seen:
        return "Drag start or goal."
    if len(obstacles) > 1:
        return "Drag an orange obstacle."
    return f"Drag the orange {'obstacle' if obstacles[0].shape == 'mesh' else obstacles[0].shape}."


def _replan_ms(plan: Plan) -> float:
    """Time of all stages, [ms], also of those that an earlier pass over the same mesh has done.

    0 where it is not known: of code that was not compiled the time says nothing.
    """
    left_out = set(style.ALGORITHMS) - {result.algorithm for result in plan.searches}
    if plan.taut is None:
        left_out.add("taut")
    needed = plan.ms.get("mesh", 0.0), plan.ms.get("graph", 0.0), plan.total_ms
    return sum(ms for name, ms in plan.ms.items() if name not in left_out) if all(needed) else 0.0


def longer_on_finer(before: Plan, plan: Plan) -> str:
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


def _whole(text: str) -> str:
    """HTML of a text in which no line ends."""
    return f'<span style="white-space:nowrap">{html.escape(text)}</span>'

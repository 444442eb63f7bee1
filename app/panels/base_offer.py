"""Offer, if no motion of the arm was found, to search for another place for its base.

It stands over the scene, with what was found; the search itself, its region and its results in full
are in stage 6.
"""

from __future__ import annotations

from abi.arm_planning.arm_errors import OUT_OF_REACH, ArmNotClear
from app.panels.stages.find_base import FindBasePanel
from app.state.frame import Frame
from app.ui.numbers import format_length, format_setting
from app.ui.overlay import button


def base_sentence(bases: FindBasePanel, frame: Frame) -> str:
    """Text on a search for a base: offered, running or done; empty where none is offered."""
    if not _may_help(frame):
        return ""
    if bases.running:
        return "Trying other places for the arm's base …"
    if frame.bases is None:
        return "“Find a base” tries many other places for the arm's base."
    if frame.bases.best is None:
        return "No place for the arm's base in stage 6's region helps."
    return "A place for the arm's base was found: see the map in the scene."


def base_buttons(bases: FindBasePanel, frame: Frame) -> str:
    """Buttons as HTML: to begin, to stop, and to take what was found.

    They stay the same while the search runs, as a hand aims at them.
    """
    if not _may_help(frame):
        return ""
    has_best = frame.bases is not None and frame.bases.best is not None
    take = button(bases.put, "Put the arm there") if has_best else ""
    return take + button(bases.find, "Stop" if bases.running else "Find a base")


def base_card(bases: FindBasePanel, frame: Frame) -> str:
    """Card on a search for a base of an arm that has a motion, as HTML; empty without one.

    It tells how far the search is and what it found, until the arm stands there.
    """
    found = frame.bases
    if found is None or frame.plan.error is not None:
        return ""
    done, of = found.planned
    best = found.best
    if best is None or best.length is None:
        if not bases.running:
            none = f"None of the places that were tried has a certified plan{bases.whose}."
            return _card(none, "")
        return _card(f"Trying places for the arm's base: {done} of {of}.", _stop(bases))
    if not bases.running and best.base == frame.plan.scene.arm.base:
        return ""
    length = f"{format_length(best.length)} {found.scene.unit}"
    place = ", ".join(format_setting(round(number, 4)) for number in best.base)
    so_far = f" so far, of {done} of {of} places" if bases.running else ""
    told = f"<b>Shortest curve{bases.whose}{so_far}: {length}</b>, with the base at ({place})."
    take = button(bases.put, "Put the arm there")
    return _card(told, take + (_stop(bases) if bases.running else ""))


def _stop(bases: FindBasePanel) -> str:
    return button(bases.find, "Stop")


def _card(told: str, buttons: str) -> str:
    row = f'<div class="abi-buttons" style="margin-top:4px">{buttons}</div>' if buttons else ""
    return f'<div class="abi-card" role="status">{told}{row}</div>'


def _may_help(frame: Frame) -> bool:
    """Check whether another base may help; not known before an arm in the way is explained."""
    error, reason = frame.plan.error, frame.reason
    if isinstance(error, ArmNotClear):
        if reason is None:
            return False
        return reason.change is None or "arm" in reason.change or reason.moved is not None
    if frame.interactive or error is None or error.kind != OUT_OF_REACH:
        return False
    return frame.plan.motion is None or frame.plan.motion.slide_at_fault is None

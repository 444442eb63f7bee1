"""Offer, if no motion of the arm was found, to search for another place for its base.

It stands over the scene; the search itself, its region and its results are in stage 6.
"""

from __future__ import annotations

from abi.arm_planning.arm_errors import ArmNotClear, NotFollowed, OutOfReach
from app.panels.stages.find_base import FindBasePanel
from app.state.frame import Frame
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


def _may_help(frame: Frame) -> bool:
    """Check whether another base may help; not known before an arm in the way is explained."""
    error, reason = frame.plan.error, frame.reason
    if isinstance(error, ArmNotClear):
        if reason is None:
            return False
        return reason.change is None or "arm" in reason.change or reason.moved is not None
    if frame.interactive:
        return False
    return isinstance(error, NotFollowed) or (isinstance(error, OutOfReach) and error.slide is None)

"""The sentence over the scene on what the arm's motion lacks, and the changes that may help.

Stage 6, where the same is told at length, is closed at first.
"""

from __future__ import annotations

import html
import math

from abi.arm_planning.motion_law import LAWS
from abi.explain.arm_faults import limit_sentence, worst_limit
from abi.planner.arm_words import clearance_sentence, contact_sentence
from abi.planner.plan import Plan
from app.panels.offered_changes import Offers
from app.shared.puzzles import is_puzzle
from app.ui import style
from app.ui.arm_size import scene_size_note
from app.ui.numbers import distance_to_show, format_lower_bound, format_setting

_RATES = ("speed", "acceleration")
"""Quantities of a joint that a slower motion keeps within their limits."""


def arm_banner(plan: Plan, buttons: str = "") -> str:
    """The worst fault of a plan that is complete, as HTML with the buttons of what may help.

    Empty for a motion that is proven clear and within its limits.
    """
    if (fault := arm_fault(plan)) is None:
        return ""
    if (size := scene_size_note(plan.scene)) is not None:
        title, numbers = size  # nothing else makes it fit
        return _card((f"{title}.", "✗"), html.escape(numbers), buttons)
    if is_puzzle(plan.scene):
        calm = "This scene is planned for the tool tip alone.", ""
        return _card(calm, html.escape(fault[0]), buttons)
    return _card(fault, _remark(plan), buttons)


def arm_changes(plan: Plan) -> Offers:
    """Changes of the scene that may mend a plan's worst fault."""
    if arm_fault(plan) is None:
        return {}
    clearance, scene = plan.arm_clearance, plan.scene
    offers: Offers = {}
    if not _follows_clear(plan):
        if plan.bspline is not None and plan.bspline.holds:
            offers["Follow the B-spline"] = {"motion": {"curve": "auto"}}
    elif clearance is not None and not clearance.certified and not scene.arm.avoid:
        offers["Avoid with the whole arm"] = {"arm": {"avoid": True}}
    elif _is_too_fast(plan) and not LAWS[scene.motion.law].keeps_limits:
        offers["Slow down for the joints"] = {"motion": {"law": "slowed"}}
    if (kept := _kept_clearance(plan)) > 0:
        label = f"Set link clearance to {format_setting(kept)} {scene.unit}"
        offers[label] = {"arm": {"clearance": kept}}
    return offers


def _follows_clear(plan: Plan) -> bool:
    return plan.followed_curve is None or plan.followed_curve.holds


def _is_too_fast(plan: Plan) -> bool:
    """Check whether a slower motion helps: no joint passes its position's limit, one passes a rate.

    The law that slows motions reads the limits of rates alone; torques become less with these.
    """
    passed = {one.quantity for one in plan.limits_passed}
    return "position" not in passed and not passed.isdisjoint(_RATES)


def arm_fault(plan: Plan) -> tuple[str, str] | None:
    """Sentence on the worst fault, and the sign behind it; None for none."""
    motion, clearance, unit = plan.motion, plan.arm_clearance, plan.scene.unit
    if plan.error is not None or motion is None or clearance is None:
        return None
    if clearance.contacts:
        return f"{contact_sentence(clearance.contacts[0], unit)}.", "✗"
    if not _follows_clear(plan):
        return _curve_sentence(plan), "✗"
    if (worst := worst_limit(plan)) is not None:
        return limit_sentence(worst, motion, unit), "✗"
    if clearance.is_too_near:
        return clearance_sentence(plan), "✗"
    return None if clearance.certified else (clearance_sentence(plan), "?")


def _curve_sentence(plan: Plan) -> str:
    """Sentence on the curve that the arm follows, which does not keep the distance asked for."""
    fit, unit = plan.followed_curve, plan.scene.unit
    assert fit is not None
    assert plan.followed is not None
    number, near = fit.clearance.obstacle + 1, fit.clearance.nearest
    distance = format_lower_bound(distance_to_show(fit.clearance)).removeprefix("−")
    where = f"keeps only {distance} of the {format_setting(fit.required)} {unit} wanted from"
    if near <= 0:
        where = f"cuts {distance} {unit} into"
    return (
        f"The {style.CURVES[plan.followed][0]}, which the arm follows, {where} obstacle {number}."
    )


def _remark(plan: Plan) -> str:
    """What is to be known beside the fault."""
    touches = plan.arm_clearance is not None and plan.arm_clearance.contacts
    if touches and _follows_clear(plan):
        return "Only the tool tip's path avoids obstacles."
    if not touches and _follows_clear(plan) and _is_driven_too_far(plan):
        return "Its drive in stage 6 is too strong for so long a motion."
    passed = len(plan.limits_passed)
    if not touches and _follows_clear(plan) and passed > 1:
        return f"{passed} limits are passed in all; Plots shows the joints."
    return ""


def _is_driven_too_far(plan: Plan) -> bool:
    """Check whether a joint of the paper's arm passes its limit that a constant force moves."""
    worst, arm = worst_limit(plan), plan.scene.arm
    if worst is None or worst.quantity != "position" or arm.model != "abi":
        return False
    forces = dict(zip(("q4", "q5", "q6"), arm.forces, strict=True))
    return forces.get(worst.joint, 0.0) != 0


def _kept_clearance(plan: Plan) -> float:
    """Distance that the links are proven to keep, rounded down, where more is asked; 0 for none."""
    clearance = plan.arm_clearance
    if clearance is None or clearance.contacts or clearance.certificate is None:
        return 0.0
    kept = min(clearance.certificate.margin, float(clearance.distances.min(initial=math.inf)))
    if not 0 < kept < clearance.required:
        return 0.0
    step = 10.0 ** (math.floor(math.log10(kept)) - 1)
    return round(math.floor(kept / step) * step, 12)


def _card(fault: tuple[str, str], remark: str, buttons: str = "") -> str:
    sentence, sign = fault
    look = "abi-card abi-error" if sign == "✗" else "abi-card"
    text = f"<b>{html.escape(f'{sentence} {sign}'.strip())}</b> {remark}".strip()
    if buttons:
        text += f'<div class="abi-buttons" style="margin-top:4px">{buttons}</div>'
    return f'<div class="{look}" role="status">{text}</div>'

"""Notes on a plan as HTML: control points, coefficients, motion and arm in numbers."""

from __future__ import annotations

import html
import math

from abi.arm_planning.joint_search.held_span import HeldSpan
from abi.arm_planning.joint_search.search_joints import JointSearch
from abi.arm_planning.motion_law import LAWS
from abi.curves.cubic_profile import CubicProfile
from abi.explain.arm_faults import CONTACTS, limit_sentence, limits_warning
from abi.planner.arm_words import (
    allowed_sentences,
    clearance_sentence,
    contact_sentence,
    lacks_motion,
)
from abi.planner.plan import Plan
from abi.planner.stage_results import AnyFit
from app.shared.computed_once import once_a_plan
from app.ui import style
from app.ui.numbers import (
    distance_to_show,
    format_length,
    format_lower_bound,
    format_setting,
    format_time,
)

_PIECES_SHOWN = 2
_TILT = (
    "A measure of how gently the motion speeds up, turns and brakes: acceleration tilts the "
    "surface of the liquid in a cup that is held upright."
)
_SPILLS = 60
"""Tilt of a liquid's surface at which any cup spills, [°]."""


@once_a_plan
def notes(plan: Plan) -> dict[str, str]:
    """All notes by name, and that of the motion, as HTML."""
    return {
        "bspline": _clearance(plan, plan.bspline) + _control_points(plan),
        "quadratic": _clearance(plan, plan.quadratic) + _coefficients(plan),
        "motion": _motion(plan),
        "arm": _arm(plan),
    }


def _clearance(plan: Plan, fit: AnyFit | None) -> str:
    """Sentence on a curve that keeps less than the required clearance; empty otherwise."""
    if fit is None or fit.holds or math.isinf(fit.clearance.distance):
        return ""
    unit, number = plan.scene.unit, fit.clearance.obstacle + 1
    distance = format_lower_bound(distance_to_show(fit.clearance))
    if fit.clearance.nearest > 0:
        text = f"too close: {distance} {unit}, wanted {format_setting(fit.required)} {unit}"
    else:
        text = f"cuts {distance.removeprefix('−')} {unit} into obstacle {number}"
    return style.paragraph(f"<b>{text} ✗</b>")


def _control_points(plan: Plan) -> str:
    """Numbers of control points added, and moved, for clearance; empty for none."""
    spline = None if plan.bspline is None else plan.bspline.curve
    if spline is None or not (spline.inserted or spline.moved):
        return ""
    counts = (spline.inserted, "added to stay near the path"), (spline.moved, "moved to stay clear")
    first, *others = [(count, done) for count, done in counts if count]
    text = f"{first[0]} control point{'s' if first[0] > 1 else ''} {first[1]}"
    text += "".join(f", {count} {done}" for count, done in others)
    return style.paragraph(f"{text}.")


def _coefficients(plan: Plan) -> str:
    """Polynomials of the quadratic, as printed in the paper."""
    if plan.quadratic is None:
        return ""
    # above them, since of a long note the end is out of sight
    note = ""
    if plan.quadratic.note:
        text = html.escape(plan.quadratic.note)
        sign = "" if plan.quadratic.holds else "✗ "
        note = f'<div style="margin:0 10px;line-height:1.2;font-size:12.5px">{sign}{text}</div>'
    lines = []
    pieces = plan.quadratic.curve.pieces
    for first, last, (c0, c1, c2) in pieces[:_PIECES_SHOWN]:
        if len(pieces) > 1:
            lines.append(f"t from {first:.3f} to {last:.3f}:")
        lines += [f"{axis}(t) = {_polynomial(c0[i], c1[i], c2[i])}" for i, axis in enumerate("xyz")]
    if len(pieces) > _PIECES_SHOWN:
        lines.append(f"… {len(pieces)} pieces in all")
    if len(pieces) == 1 and plan.quadratic.holds and not note:  # else there is no room
        lines.insert(
            0, f"t runs from {pieces[0][0]:.3g} to {pieces[0][1]:.3g}, and is not the time:"
        )
    css = "margin:0 12px 3px;font:12px/1.12 ui-monospace,monospace"
    first, last = plan.quadratic.curve.interval
    hint = (
        f"Where the quadratic is [{plan.scene.unit}], for t from {first:.3g} at the start to "
        f"{last:.3g} at the goal. It is no time: stage 5 says how fast the arm goes along."
    )
    return f'{note}<div title="{html.escape(hint)}" style="{css}">{"<br>".join(lines)}</div>'


def _polynomial(*coefficients: float) -> str:
    """Format c0 + c1 t + c2 t² with three decimals, without vanishing terms."""
    text = ""
    for number, power in zip(coefficients, ("", "t", "t²"), strict=True):
        if abs(number) >= 5e-4:
            sign = ("−" if number < 0 else "") if not text else (" − " if number < 0 else " + ")
            text += f"{sign}{abs(number):.3f}{power}"
    return text or "0"


def _motion(plan: Plan) -> str:
    if plan.profile is None:
        return ""
    profile, unit = plan.profile, f"{plan.scene.unit}/s"
    if plan.followed is None and plan.joint_search is None:  # it was planned elsewhere
        return style.paragraph(f"{profile.duration:.2f} s in all.{_tilt(plan)}")
    if isinstance(profile, CubicProfile):
        label = LAWS[plan.scene.motion.law].label
        text = f"{label[0].upper()}{label[1:]}, up to {format_length(profile.peak_speed)} {unit}: "
        return style.paragraph(f"{text}{profile.duration:.2f} s in all.{_tilt(plan)}")
    text = f"Speed up {profile.t1:.2f} s, cruise {profile.t2:.2f} s, brake {profile.t3:.2f} s."
    if profile.triangular:
        text += (
            f" The path is too short to reach {format_setting(plan.scene.motion.speed)} {unit}; "
            f"top speed {format_length(profile.peak_speed)} {unit}."
        )
    return style.paragraph(text + _tilt(plan))


def _tilt(plan: Plan) -> str:
    if plan.liquid_tilt is None:
        return ""
    tilt = math.degrees(plan.liquid_tilt)
    told = f"A cup carried along: its liquid tilts by up to {tilt:.{0 if tilt >= 10 else 1}f}°"
    told += ": it would be spilt." if tilt > _SPILLS else "."
    return f' <span title="{_TILT}">{told}</span>'


def _of_joints(search: JointSearch, time: float) -> str:
    """Sentence on where a joint-space motion was found, which follows no curve of the tool.

    At a ``time`` of 0, which is not known, it says none.
    """
    nodes = sum(len(tree.positions) for tree in search.trees)
    proven = search.proofs - search.refused
    took = f", in {format_time(time)}" if time else ""
    return (
        "The joints follow a curve of their own, found in their space: "
        f"{nodes} poses in two trees, {search.proofs} edges tried and {proven} proven{took}."
    )


_NOTHING = 1e-3
"""Angle below which a direction is exact, [°]."""


def _of_direction(span: HeldSpan) -> str:
    """Sentence on how well the tool keeps its direction."""
    measured, bound, allowed = map(math.degrees, (span.angle, span.bound, span.tolerance))
    off = f"at most {measured:.2g}° off" if measured > _NOTHING else "not off"
    return (
        f"From {span.first:.2f} s to {span.last:.2f} s, where the time bar has a line, the gripper "
        f"keeps its direction: it is {off} at samples, and proven to be at "
        f"most {bound:.2g}° off between them, of {allowed:.2g}° allowed."
    )


def _arm(plan: Plan) -> str:
    if lacks_motion(plan):
        return _no_motion(plan)
    if plan.motion is None:
        return ""
    motion, unit, curve = plan.motion, plan.scene.unit, plan.followed_curve
    lines = []
    if plan.joint_search is not None:
        lines.append(_of_joints(plan.joint_search, plan.ms["joint_search"]))
    lines += [_of_direction(span) for span in plan.held_spans]
    if curve is not None and not curve.holds and plan.followed is not None:
        label = style.CURVES[plan.followed][0]
        lines.append(f"<b>✗ The {label}, which the arm follows, is too near an obstacle.</b>")
    if plan.arm_clearance is not None:
        contacts = plan.arm_clearance.contacts
        touched = (html.escape(contact_sentence(one, unit)) for one in contacts[:CONTACTS])
        lines += [f"<b>✗ {sentence}.</b>" for sentence in touched]
        if len(contacts) > CONTACTS:
            lines.append(f"… {len(contacts)} contacts in all")
        if sentence := clearance_sentence(plan):
            too_near = plan.arm_clearance.is_too_near
            sentence = html.escape(sentence)
            lines.append(f"<b>✗ {sentence}</b>" if too_near else sentence)
    lines += map(html.escape, plan.not_compared)
    lines += [
        f"✗ {html.escape(limit_sentence(one, motion, unit))}" for one in motion.limit_violations
    ]
    if past := limits_warning(plan):
        lines.append(f"✗ {past}")
    allowed = "<br>".join(html.escape(sentence) for sentence in allowed_sentences(plan))
    hint = "These contacts are no collisions: each with its reason. All others count."
    summary = f'<summary title="{hint}">What may touch</summary>'
    folded = f"<details>{summary}{allowed}</details>" if allowed else ""
    text = "<br>".join(lines) + folded
    return style.paragraph(text) if text else ""


def _no_motion(plan: Plan) -> str:
    """Why there is no motion of the arm, as told over the scene, and what is drawn instead."""
    assert plan.error is not None
    text = f"<b>✗ {html.escape(plan.error.message)}</b>"
    contacts = () if plan.arm_clearance is None else plan.arm_clearance.contacts
    if plan.motion is not None and plan.motion.reachable:
        text += "<br>What is drawn moves along the curve of the tool tip alone."
    if contacts:
        touched = (html.escape(contact_sentence(one, plan.scene.unit)) for one in contacts)
        summary = f"<summary>What touches there: {len(contacts)}</summary>"
        text += f"<details>{summary}{'<br>'.join(f'{one}.' for one in touched)}</details>"
    return style.paragraph(text)

"""Sentences about the arm: whether it is clear, and what it touches."""

from __future__ import annotations

import math

from abi.arm_planning.motion.arm_clearance import Contact
from abi.length_text import format_length, format_lower_bound, format_setting
from abi.planner.plan import Plan
from abi.robot.bodies.allowed_contacts import Reason
from abi.robot.urdf.robot import joints_between

_LINKS = {"base_link": "base", "base_link_inertia": "base", "link_base": "base", "rod": "slide"}

UNPAIRED_SENTENCE = (
    "Forearm and upper arm of the paper's arm are not compared, as they are drawn into each other "
    "where it bends far, and at the floor only the tool tip counts of the fingers."
)
"""What no plan of the paper's arm proves."""

_REASONS: dict[Reason, str] = {
    "adjacent": "Neighbouring links, with at most one joint between them",
    "always": "They overlap in whatever pose the arm is",
    "never": "By their shapes they are apart in whatever pose the arm is",
    "srdf": "The SRDF lets them touch",
    "mount": "What the arm stands on",
    "asked": "The scene lets them touch",
    "grasp": "One holds the other, or is fixed to what does",
}
"""Beginning of a sentence on pairs that are not kept apart, for each reason."""


_STILL = "No planned joint moves them beside each other"
"""The same for links that several joints part, which are held."""


def arm_result(plan: Plan) -> str:
    """Result of stage 6, short enough for its heading; empty where it was not reached."""
    motion, clearance = plan.motion, plan.arm_clearance
    if motion is not None and not motion.reachable:
        return "out of reach ✗"
    if lacks_motion(plan):  # what is drawn is not what was asked for, whatever it touches
        return "no motion ✗"
    if motion is None or clearance is None:
        return ""
    if clearance.contacts:
        worst = clearance.contacts[0]
        if worst.apart:
            return f"{link_label(worst.link)}: pieces collide ✗"
        return f"{link_label(worst.link)} {'collides' if worst.certain else 'may collide'} ✗"
    if plan.followed_curve is not None and not plan.followed_curve.holds:
        return "curve not clear ✗"
    if plan.limits_passed:
        return "joint limit passed ✗"
    if clearance.is_too_near:
        return "links too near ✗"
    return "proven clear ✓" if clearance.certified else "not proven clear ?"


def lacks_motion(plan: Plan) -> bool:
    """Check whether there is no motion of the arm as asked for, but perhaps one of the tool's."""
    return plan.error is not None and plan.error.stage == "arm"


def link_label(link: str) -> str:
    """Name of a link as a person would say it."""
    return _LINKS.get(link) or link.removesuffix("_link").replace("_", " ")


def contact_sentence(contact: Contact, unit: str) -> str:
    """Sentence on what touches what, or may, or is too near by its pieces, when and how deep."""
    other = contact.obstacle
    name = f"obstacle {other + 1}" if isinstance(other, int) else f"the {link_label(other)}"
    link, depth = link_label(contact.link), f"{format_length(contact.depth)} {unit}"
    when = f"at {contact.time:.2f} s"
    if contact.apart:
        pieces = f"the convex pieces that contain it go up to {depth} into that"
        return f"The {link} does not touch {name} {when}, but {pieces}"
    if not contact.certain:
        return f"The {link} may go up to {depth} into {name} {when}"
    if contact.depth == 0:
        return f"The {link} touches {name} {when}"
    return f"The {link} goes {depth} into {name} {when}"


def allowed_sentences(plan: Plan) -> tuple[str, ...]:
    """What of the arm may touch what, one sentence for each reason."""
    if plan.paper_arm is not None and plan.arm_clearance is not None:
        return (UNPAIRED_SENTENCE,)
    found: dict[str, list[str]] = {}
    for link, other, reason in () if plan.arm_clearance is None else plan.arm_clearance.allowed:
        name = f"obstacle {other + 1}" if isinstance(other, int) else link_label(other)
        words = _REASONS[reason]
        if reason == "adjacent" and len(joints_between(plan.scene.robot, link, str(other))) > 1:
            words = _STILL
        found.setdefault(words, []).append(f"{link_label(link)} and {name}")
    return tuple(f"{words}: {', '.join(pairs)}." for words, pairs in found.items())


def clearance_sentence(plan: Plan) -> str:
    """Sentence on the links' distance to the nearest obstacle, and what of it is proven.

    Where that is less than the scene asks for, it begins with what it lacks.
    """
    clearance, unit = plan.arm_clearance, plan.scene.unit
    if clearance is None or clearance.contacts:
        return ""
    if math.isinf(clearance.distance):
        if clearance.certificate is not None:
            but = ", but for what its notes tell" if plan.not_compared else ""
            return f"Proven: the arm keeps clear of the floor and of itself{but}."
        return "It is not proven that the arm keeps clear of the floor and of itself."
    distance = f"{format_lower_bound(clearance.distance)} {unit}"
    wanted = f"{format_setting(clearance.required)} {unit}"
    nearest = (
        f"the {link_label(clearance.link)} comes closest, to obstacle {clearance.obstacle + 1} "
        f"at {clearance.time:.2f} s"
    )
    if clearance.is_too_near:
        return f"Links too near: {distance} of the {wanted} wanted; {nearest}."
    if clearance.certified:
        grasping = [one.scene.arm for one in plan.legs or (plan,) if one.scene.arm.grasping]
        apart = ", gripper and object apart from them where they meet" if grasping else ""
        if any(arm.attached is not None for arm in grasping):
            apart += ", the object then 1 mm smaller on each side"
        return f"Proven: every link stays {distance} from the obstacles{apart}; {nearest}."
    if clearance.certificate is not None:
        return f"Only {distance} of the {wanted} wanted are proven; {nearest}."
    return f"Not proven. At the sampled times every link keeps {distance}; {nearest}."

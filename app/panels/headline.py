"""The plan's headline numbers, over the scene."""

from __future__ import annotations

from abi.planner.plan import Plan
from app.shared.computed_once import once_a_plan
from app.stages.catalogue import SHOWN_STAGES
from app.stages.curve_numbers import blocks, curve_numbers
from app.state.frame import Frame


def shown_numbers(frame: Frame) -> str:
    """Three numbers of the curve that the arm follows, or those of a lecture's stage, as HTML.

    Empty while a search is stepped through, which counts itself.
    """
    plan, content = frame.plan, ""
    if frame.theatre is None and frame.tells_curve:
        content = stage_headline(plan, frame.stage) if frame.stage else headline(plan)
    if not frame.current:  # what is proven of the plan is not of what was asked for
        content = f'<div class="abi-old">{content.replace(" ✓", "")}</div>'
    return content


@once_a_plan
def headline(plan: Plan) -> str:
    """The three numbers as HTML: of the curve, or of the arm where this follows none."""
    if plan.followed is None:
        alone = plan.joint_search is not None or plan.path is None  # nothing but a motion
        return stage_headline(plan, "arm") if alone else ""
    return blocks(curve_numbers(plan, plan.followed))


@once_a_plan
def stage_headline(plan: Plan, stage: str) -> str:
    """The numbers of a stage as HTML; empty where the plan did not get so far."""
    return blocks(SHOWN_STAGES[stage].numbers(plan))

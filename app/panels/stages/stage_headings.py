"""Headings of the stages' folders, with the results of a plan or where an error belongs."""

from __future__ import annotations

from abi.errors import AbiError, SceneError
from abi.planner.plan import Plan
from app.shared.computed_once import once_a_plan
from app.stages.catalogue import SHOWN_STAGES, STAGE_OF_ERROR, TITLES
from app.state.frame import Frame

_STAGE_OF_FIELD = {field: name for name, stage in SHOWN_STAGES.items() for field in stage.fields}
_OF_THE_TOOL = ("search", "bspline", "quadratic")
"""Stages that make the curve of the tool."""


def headings(frame: Frame) -> dict[str, str]:
    """Heading of each stage, by the stage's name."""
    plan = frame.plan
    results = dict(_results(plan))
    if frame.lesson:
        # a stage with a layer of its name is of no use to a lesson that does not show that
        unused = {name for name, one in SHOWN_STAGES.items() if name in one.layers - frame.shown}
        results |= dict.fromkeys(results if frame.asks else unused, "")
    if not frame.current:
        # what is true of the plan is not of what was asked for
        results = {name: result.removesuffix(" ✓") for name, result in results.items()}
    if frame.outdated and results["arm"]:
        results["arm"] = "planning …"  # a verdict, and no number that the next is near to
    if (stage := _stage(frame.refused)) is not None:
        results[stage] = "not changed ✗"
    return {
        stage: f"{TITLES[stage]} — {result}" if result else TITLES[stage]
        for stage, result in results.items()
    }


def _stage(error: AbiError | None) -> str | None:
    """Stage whose inputs are wrong; None where they are not those of a stage."""
    if not isinstance(error, SceneError):
        return None
    return _STAGE_OF_FIELD.get(error.field.split(".")[0].split("[")[0])


@once_a_plan
def _results(plan: Plan) -> dict[str, str]:
    """Each stage's result, short enough for a heading on one line."""
    results = {name: stage.result(plan) for name, stage in SHOWN_STAGES.items()}
    if plan.joint_search is not None:
        for name in _OF_THE_TOOL:  # where there is a curve, the joints do not follow it
            results[name] = "not followed" if results[name] else "not used"
    if plan.error is not None:
        ended = STAGE_OF_ERROR[plan.error.stage]
        results[ended] = SHOWN_STAGES[ended].failure or results[ended]
        later = list(results)[list(results).index(ended) + 1 :]
        results |= {name: results[name] or "not reached" for name in later}
    return results

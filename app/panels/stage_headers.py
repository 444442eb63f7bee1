"""The stages' headings with their results, and an error at the stage it belongs to."""

from __future__ import annotations

import html
import math
from typing import Any

import viser

from abi.errors import AbiError, NoPath, SceneError, StageError
from abi.planner.diagnosis import Reason
from abi.planner.plan import Plan
from app import style
from app.arm_words import arm_result, contact_sentence
from app.frame import Frame
from app.labels import LABELS, with_labels
from app.numbers import format_length, format_setting
from app.panels.widgets import Wake

STAGES = ("mesh", "graph", "search", "bspline", "quadratic", "arm")
_TITLES = {
    "mesh": "1 · Mesh",
    "graph": "2 · Graph",
    "search": "3 · Search",
    "bspline": "4 · B-spline",
    "quadratic": "5 · Quadratic",
    "arm": "6 · Arm",
}
_MAX_LENGTH = 30
"""Letters of a heading that fit beside its arrow in a wide font."""
_STAGE_OF_FIELD = {
    "mesh": "mesh",
    "search": "search",
    "spline": "bspline",
    "quadratic": "quadratic",
    "motion": "quadratic",
    "timing": "quadratic",
    "arm": "arm",
    "start": "graph",
    "goal": "graph",
    "obstacles": "mesh",
}


class StageHeaders:
    """The six folders, to be filled by the panels, and a note and a button above each."""

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self._notes: dict[str, viser.GuiHtmlHandle] = {}
        # Any, since viser declares a button's value read-only
        self._buttons: dict[str, Any] = {}
        self._change: dict[str, Any] | None = None
        self._drawn: tuple[object, ...] = ()
        self.folders: dict[str, viser.GuiFolderHandle] = {}
        for stage in STAGES:
            self._notes[stage] = gui.add_html("", visible=False)
            self._buttons[stage] = gui.add_button("", visible=False)
            self._buttons[stage].on_click(wake)
            self.folders[stage] = gui.add_folder(
                _TITLES[stage], expand_by_default=stage not in ("graph", "arm")
            )

    def draw(self, frame: Frame) -> None:
        """Write the plan's results into the headings, and its error above the stage's."""
        plan = frame.plan
        state = plan, frame.coarse, frame.refused, frame.reason
        if state == self._drawn:
            return
        self._drawn = state
        results = _results(plan)
        if frame.coarse and plan.free is not None:
            results["mesh"] = f"≈ {plan.free.nodes:,} nodes"
        for stage, result in results.items():
            label = f"{_TITLES[stage]} — {result}" if result else _TITLES[stage]
            if self.folders[stage].label != label:
                self.folders[stage].label = label
        if frame.refused is not None:
            self._show_error(frame.refused, None)
        else:
            self._show_error(plan.error, frame.reason)
            if plan.error is None:
                self._show_contact(plan)

    def _show_contact(self, plan: Plan) -> None:
        """Show above stage 6 what the arm touches worst; the others stand in the stage."""
        contacts = () if plan.arm_clearance is None else plan.arm_clearance.contacts
        note = self._notes["arm"]
        note.visible = len(contacts) > 0
        if contacts:
            sentence = f"{contact_sentence(contacts[0], plan.scene.unit)}."
            note.content = _error_html(sentence, "Only the tool's path is planned clear.")

    def _show_error(self, error: AbiError | None, reason: Reason | None) -> None:
        """Show an error above its stage, and nothing above the others.

        Args:
            error: None for none.
            reason: its diagnosis, with the change that helps if there is one.
        """
        stage_of_error = _stage(error)
        self._change = None if reason is None else reason.change
        for stage, note in self._notes.items():
            here = stage == stage_of_error
            self._buttons[stage].visible = here and self._change is not None
            if here and self._change is not None:
                self._buttons[stage].label = _change_label(self._change)
            if here and error is not None:
                explained = error if reason is None else reason
                dots = " The blue dots are what the start reaches."
                hint = explained.hint + (dots if isinstance(error, NoPath) else "")
                note.content = _error_html(with_labels(explained.message, error), hint)
            note.visible = here

    def accepted_change(self) -> dict[str, Any] | None:
        """The change of the scene whose button was pressed since the last call."""
        pressed = False
        for button in self._buttons.values():
            pressed |= button.value
            button.value = False
        return self._change if pressed else None


def _stage(error: AbiError | None) -> str | None:
    if error is None:
        return None
    if isinstance(error, StageError):
        return _STAGE_OF_FIELD.get(error.stage, error.stage)
    field = error.field if isinstance(error, SceneError) else ""
    return _STAGE_OF_FIELD.get(field.split(".")[0].split("[")[0], "mesh")


def _change_label(change: dict[str, Any]) -> str:
    """Text of the button that makes this change of the scene."""
    parts = []
    for section, value in change.items():
        if section in ("start", "goal"):
            parts.append(f"move the {section}")
        elif isinstance(value, dict):
            for name, number in value.items():
                label = LABELS.get(f"{section}.{name}", name)
                shown = format_setting(number) if isinstance(number, float) else str(number)
                parts.append(f"set {label} to {shown}")
        else:
            parts.append(f"change {section}")
    text = " and ".join(parts)
    return text[:1].upper() + text[1:]


def _error_html(message: str, hint: str) -> str:
    """Message and hint as HTML; escaped, since both can quote what a user typed."""
    return (
        '<div style="margin:6px 10px 0;padding:6px 9px;border-left:4px solid #e03131;'
        'background:rgba(224,49,49,.12);border-radius:3px;font-size:12.5px;line-height:1.35">'
        f"<b>✗ {html.escape(message)}</b> {html.escape(hint)}</div>"
    )


def _results(plan: Plan) -> dict[str, str]:
    """Each stage's result, short enough for a heading on one line."""
    results = dict.fromkeys(STAGES, "")
    if plan.mesh is not None and plan.free is not None:
        results["mesh"] = f"{plan.free.nodes:,} free nodes"
    if plan.graph is not None:
        results["graph"] = f"{plan.graph.edge_count:,} edges"
    if plan.path is not None:
        results["search"] = _search_result(plan)
    elif plan.error is not None and plan.error.stage == "search":
        results["search"] = "no path"
    for stage, fit, arc in (
        ("bspline", plan.bspline, plan.bspline_arc),
        ("quadratic", plan.quadratic, plan.quadratic_arc),
    ):
        if fit is None or arc is None:
            continue
        if fit.holds or math.isinf(fit.clearance.distance):
            results[stage] = f"{format_length(arc.length)} {plan.scene.unit} ✓"
        else:
            results[stage] = "too close ✗" if fit.clearance.nearest > 0 else "collides ✗"
    results["arm"] = arm_result(plan)
    return results


def _search_result(plan: Plan) -> str:
    """Length of the path, and of the straightened one or the algorithm where there is room."""
    assert plan.path is not None
    length, unit = format_length(plan.path.length), plan.scene.unit
    if plan.taut is not None:
        return f"{length} → {format_length(plan.taut.length)} {unit}"
    name = style.ALGORITHMS[plan.path.algorithm][0]
    named = f"{name} {length} {unit}"
    return named if len(_TITLES["search"] + named) < _MAX_LENGTH - 3 else f"{length} {unit}"

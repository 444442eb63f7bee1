"""Speeds, accelerations and torques of the joints, and how much of their limits they use."""

from __future__ import annotations

import html
import itertools
import math
from collections.abc import Mapping

import numpy as np
import viser

from abi.arm_planning.joint_rates import JointRates
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arm_planning.motion_law import ROUNDING
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from app.layers.result.time_plot import Lines, new_plot, plotted_samples, show_lines
from app.shared.computed_once import once_a_plan
from app.state.frame import Draw, Frame
from app.ui import style
from app.ui.layout import Layout
from app.ui.table import table

_TINY = 5e-4
_NO_MASSES = "No torques: the paper gives no masses of links. Those in stage 6 are of the drives."
_UNLIMITED = "A joint without a second number has no limit."
_NO_INERTIAS = "No torques: the URDF gives no masses of links."
_USES: Lines = (
    ("position", style.AXES[2]),
    ("speed", style.AXES[1]),
    ("acceleration", style.MARK),
    ("torque", style.JOINTS[2]),
    ("limit", style.VIOLATION),
)


def joint_rates_layer(layout: Layout) -> Draw:
    """Plots and a table of peaks, drawn once the hand rests and the plots have been opened."""
    drawn: Plan | None = None
    made: tuple[object, ...] = ()
    plots: dict[str, viser.GuiUplotHandle] = {}
    with layout.plots:
        peaks = layout.client.gui.add_html("", visible=False)

    def draw(frame: Frame) -> None:
        nonlocal drawn, made, plots
        plan = frame.plan
        if not frame.plots or frame.interactive or plan is drawn:
            return
        drawn, before = plan, made
        rates, motion = plan.joint_rates, plan.motion
        peaks.visible = rates is not None
        made = ()
        if rates is not None and motion is not None:
            made = motion.joints, plan.scene.unit, rates.torques is not None
        if made != before:
            # at once: a page may miss that they are hidden first
            for plot in plots.values():
                plot.remove()
            plots = {} if not made else _new_plots(layout, plan)
        if rates is not None and motion is not None:
            peaks.content = _peaks(plan)
            _show_rates(plots, plan, motion, rates)

    return draw


def _new_plots(layout: Layout, plan: Plan) -> dict[str, viser.GuiUplotHandle]:
    """New plots for the joints of a plan's motion."""
    motion, unit = plan.motion, plan.scene.unit
    assert motion is not None
    assert plan.joint_rates is not None
    labels = [
        f"{name} (slide, {unit})" if slide else name
        for name, slide in zip(motion.joints, motion.slides, strict=True)
    ]
    names = tuple(zip(labels, itertools.cycle(style.JOINTS), strict=False))
    knows_torques = plan.joint_rates.torques is not None
    uses = tuple(line for line in _USES if knows_torques or line[0] != "torque")
    also = (f", {unit}/s", f", {unit}/s²", ", N") if any(motion.slides) else ("", "", "")
    titles = {
        "limits": "share of its limit, of the joint nearest to it [%]",
        "speeds": f"joint speeds [rad/s{also[0]}]",
        "accelerations": f"joint accelerations [rad/s²{also[1]}]",
        "torques": f"joint torques [N·m{also[2]}]",
    }
    with layout.plots:
        return {
            key: new_plot(layout.client.gui, title, uses if key == "limits" else names, 250)
            for key, title in titles.items()
        }


def _show_rates(
    plots: Mapping[str, viser.GuiUplotHandle], plan: Plan, motion: ArmMotion, rates: JointRates
) -> None:
    samples = plotted_samples(motion)
    time = motion.time[samples]
    for name, values in (
        ("speeds", rates.speeds),
        ("accelerations", rates.accelerations),
        ("torques", rates.torques),
    ):
        if values is None:
            plots[name].visible = False
        else:
            show_lines(plots[name], time, *values[samples].T)
    used = [100 * share[samples] for share in _shares(plan)]
    show_lines(plots["limits"], time, *used, np.full(len(time), 100.0))


@once_a_plan
def _shares(plan: Plan) -> list[FloatArray]:
    """Largest part of a joint's limit in use at each sample (m,): position to torque, if known."""
    rates = plan.joint_rates
    assert plan.arm is not None
    assert plan.motion is not None
    assert rates is not None
    low, high = plan.arm.limits.T
    place = np.abs(plan.motion.positions - (low + high) / 2)
    pairs = [
        (place, np.maximum((high - low) / 2, 1e-9)),
        (np.abs(rates.speeds), rates.speed_limits),
        (np.abs(rates.accelerations), rates.acceleration_limits),
    ]
    if rates.torques is not None:
        pairs.append((np.abs(rates.torques), rates.torque_limits))
    return [(values / limits).max(axis=1) for values, limits in pairs]


@once_a_plan
def _peaks(plan: Plan) -> str:
    """Table of each joint's peaks beside its limits."""
    rates = plan.joint_rates
    assert plan.motion is not None
    assert rates is not None
    unit = plan.scene.unit
    peaks = (
        (rates.speeds, rates.speed_limits, f"{unit}/s"),
        (rates.accelerations, rates.acceleration_limits, f"{unit}/s²"),
        (rates.torques, rates.torque_limits, "N"),
    )
    rows = []
    for n, (name, slides) in enumerate(zip(plan.motion.joints, plan.motion.slides, strict=True)):
        cells = [
            _cell(
                float(np.abs(values[:, n]).max()), float(limits[n]), f" {other}" if slides else ""
            )
            for values, limits, other in peaks
            if values is not None
        ]
        rows.append((html.escape(name.removesuffix("_joint")), *cells))
    head = ("joint: peak / limit", "[rad/s]", "[rad/s²]", "[N·m]")[: len(rows[0])]
    notes = [] if np.isfinite(rates.speed_limits).all() else [_UNLIMITED]
    if rates.torques is None:
        notes.append(_NO_MASSES if plan.scene.arm.model == "abi" else _NO_INERTIAS)
    return table(head, rows, " ".join(notes))


def _cell(peak: float, limit: float, unit: str) -> str:
    """A peak of its limit, red where it is past that; ``unit`` of a joint that slides."""
    peak = peak if peak > _TINY else 0.0
    text = f"{peak:.3g}{unit}" if math.isinf(limit) else f"{peak:.3g} / {limit:.3g}{unit}"
    if peak > limit * ROUNDING:
        return f'<span style="color:{style.readable(style.BAD)}">{text} ✗</span>'
    return text

"""Speeds, accelerations and torques of the joints, and how much of their limits they use."""

from __future__ import annotations

import html
import itertools
import math

import numpy as np
import viser

from abi.arm_planning.motion_law import ROUNDING
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from app.layers.result.time_plot import Lines, new_plot, plotted_samples, show_lines
from app.shared.computed_once import once_a_plan
from app.state.frame import Frame
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


class JointRatesLayer:
    """Plots and a table of peaks, drawn once the hand rests."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._drawn: object = None
        self._made: tuple[object, ...] | None = None
        self._plots: dict[str, viser.GuiUplotHandle] = {}
        with layout.plots:
            self._peaks = layout.client.gui.add_html("", visible=False)

    def __call__(self, frame: Frame) -> None:
        """Plot the plan's motion once the hand rests and the plots have been opened."""
        if frame.plots and not frame.interactive and frame.plan is not self._drawn:
            self._drawn = frame.plan
            self._replace(frame.plan)

    def _replace(self, plan: Plan) -> None:
        rates, motion = plan.joint_rates, plan.motion
        self._peaks.visible = rates is not None
        if rates is None or motion is None:
            self._remove()
            return
        made = motion.joints, plan.scene.unit, rates.torques is not None
        if self._made != made:
            self._remove()
            self._made = made
            self._make(motion.joints, motion.slides, plan.scene.unit)
        self._peaks.content = _peaks(plan)
        samples = plotted_samples(motion)
        time = motion.time[samples]
        for name, values in (
            ("speeds", rates.speeds),
            ("accelerations", rates.accelerations),
            ("torques", rates.torques),
        ):
            if values is None:
                self._plots[name].visible = False
            else:
                show_lines(self._plots[name], time, *values[samples].T)
        used = [100 * share[samples] for share in _shares(plan)]
        show_lines(self._plots["limits"], time, *used, np.full(len(time), 100.0))

    def _uses(self) -> Lines:
        """Lines of the plot of the limits: none of torques where these are not known."""
        has_torques = self._made is not None and self._made[-1]
        return tuple(line for line in _USES if has_torques or line[0] != "torque")

    def _remove(self) -> None:
        """Remove the plots: a page may miss that they are hidden first and removed at once."""
        for plot in self._plots.values():
            plot.remove()
        self._plots, self._made = {}, None

    def _make(self, joints: tuple[str, ...], slides: tuple[bool, ...], unit: str) -> None:
        """Make the plots for joints with these names."""
        gui = self._layout.client.gui
        labels = [
            f"{name} (slide, {unit})" if slide else name
            for name, slide in zip(joints, slides, strict=True)
        ]
        names = tuple(zip(labels, itertools.cycle(style.JOINTS), strict=False))
        also = (f", {unit}/s", f", {unit}/s²", ", N") if any(slides) else ("", "", "")
        titles = {
            "limits": "share of its limit, of the joint nearest to it [%]",
            "speeds": f"joint speeds [rad/s{also[0]}]",
            "accelerations": f"joint accelerations [rad/s²{also[1]}]",
            "torques": f"joint torques [N·m{also[2]}]",
        }
        with self._layout.plots:
            self._plots = {
                key: new_plot(gui, title, self._uses() if key == "limits" else names, 250)
                for key, title in titles.items()
            }


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

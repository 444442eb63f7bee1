"""Plots of speed (the paper's Fig. 8) and joint positions over time; the page marks the present."""

from __future__ import annotations

import itertools
import time as clock

import numpy as np
import viser

from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.robot.paper_arm.paper_arm import JOINTS
from app.layers.result.motion_curves import (
    acceleration,
    has_meshes,
    links_clearance,
    tool_clearance,
)
from app.layers.result.time_plot import Lines, new_plot, plotted_samples, show_lines
from app.state.frame import Frame
from app.ui import style
from app.ui.layout import Layout

_JOINTS = ("q1 base", "q2 shoulder", "q3 elbow", "q4 wrist", "q5 slide", "q6 gripper")
_NO_MOTION = (
    '<div style="box-sizing:border-box;height:{}px;padding:8px 10px;font-size:12.5px">'
    "No motion, nothing to plot.</div>"
)
_PERIOD = 0.25
"""Seconds between two plots of changing motions while a hand drags: it looks elsewhere."""
_SPEED_HEIGHT = 130
_AROUND = 71
"""Height of a plot's title and legend with the space around them, [px]."""
_ALONG = tuple(zip("xyz", style.AXES, strict=True))
_ANGLES = tuple((_JOINTS[i - 1], style.JOINTS[i - 1]) for i in (1, 2, 3, 4, 6))
_PLOTS: dict[str, tuple[str, Lines, int]] = {
    "speed": (
        "speed of the tool tip, and along x, y, z [{}/s]",
        (("speed", style.MARK), *_ALONG),
        _SPEED_HEIGHT,
    ),
    "angles": ("joint angles [rad]", _ANGLES, 250),
    "slide": ("slide [{}]", ((_JOINTS[4], style.JOINTS[4]),), 170),
    "clearance": ("clearance of the arm [{}]", (("links to obstacles", style.MARK),), 170),
    "tool": ("clearance of the tool tip [{}]", (("tool tip to obstacles", style.BSPLINE),), 170),
    "acceleration": (
        "acceleration of the tool tip [{}/s²]",
        (("acceleration", style.MARK), *_ALONG),
        190,
    ),
}
"""Title of each plot, with ``{}`` for the unit of length, its lines, and its height, [px]."""


class PlotsLayer:
    """The speed plot in the result tab, the joints in their own."""

    def __init__(self, layout: Layout) -> None:
        gui, self._unit = layout.client.gui, layout.unit
        self._layout = layout
        with layout.result:
            # as high as the plot: what is below is not to move under the hand
            notes = [gui.add_html(_NO_MOTION.format(_SPEED_HEIGHT + _AROUND), visible=False)]
            self._plots = {"speed": self._new_plot("speed")}
        with layout.plots:
            notes.append(gui.add_html(_NO_MOTION.format(40), visible=False))
            self._plots |= {name: self._new_plot(name) for name in list(_PLOTS)[1:]}
        self._no_motion = notes
        self._named: tuple[str, ...] = ()
        self._other: viser.GuiUplotHandle | None = None
        self._motion: object = self  # not that of the first plan, which may be None
        self._plotted: object = None
        self._resting: object = None
        self._waiting: list[tuple[viser.GuiUplotHandle, tuple[FloatArray, ...]]] = []
        self._next = 0.0

    def _new_plot(self, name: str) -> viser.GuiUplotHandle:
        title, lines, height = _PLOTS[name]
        return new_plot(self._layout.client.gui, title.format(self._unit), lines, height)

    def __call__(self, frame: Frame) -> None:
        """Plot the plan's motion; nothing where there is none."""
        plan = frame.plan
        if plan.motion is not self._motion:
            self._replace(plan)
        if frame.plots and plan.motion is not None:
            if self._plotted is not plan.motion:
                self._add_joints(plan, plan.motion)
            if not frame.interactive and self._resting is not plan.motion:
                self._add_slow(plan, plan.motion)
        self._send(frame.interactive)

    def _add(self, handle: viser.GuiUplotHandle, *lines: FloatArray) -> None:
        """Show times and lines, (m,) each, from the next time on that something is sent."""
        self._waiting.append((handle, lines))

    def _send(self, interactive: bool) -> None:
        """Send what is new; ``interactive``: while a hand drags, not at every frame."""
        now = clock.monotonic()
        if self._waiting and not (interactive and now < self._next):
            for handle, lines in self._waiting:
                show_lines(handle, *lines)
            self._waiting.clear()
            self._next = now + _PERIOD

    def _replace(self, plan: Plan) -> None:
        """Keep the plan's motion, to be plotted, and plot its speed."""
        motion = self._motion = plan.motion
        if self._other is not None and (motion is None or motion.joints == JOINTS):
            self._other.visible = False
        self._waiting.clear()
        for note in self._no_motion:
            note.visible = motion is None
        if motion is None:
            for plot in self._plots.values():
                plot.visible = False
            return
        # a new title builds the chart anew, which then forgets its time axis
        if plan.scene.unit != self._unit:
            self._unit = plan.scene.unit
            for name, (title, _, _) in _PLOTS.items():
                self._plots[name].title = title.format(self._unit)
        samples = plotted_samples(motion)
        velocity = motion.tool_velocity[samples]
        speed = np.linalg.norm(velocity, axis=1)
        self._add(self._plots["speed"], motion.time[samples], speed, *velocity.T)

    def _add_joints(self, plan: Plan, motion: ArmMotion) -> None:
        """Add what is plotted in the plots' tab, except for what is slow."""
        self._plotted = motion
        samples = plotted_samples(motion)
        time, positions = motion.time[samples], motion.positions[samples]
        if motion.joints == JOINTS:
            self._add(self._plots["angles"], time, *positions[:, [0, 1, 2, 3, 5]].T)
            self._add(self._plots["slide"], time, positions[:, 4])
        else:
            self._plots["angles"].visible = self._plots["slide"].visible = False
            others = self._others(motion, plan.scene.unit)
            self._add(others, time, *positions.T)
        if plan.arm_clearance is None or plan.arm_clearance.obstacle < 0:
            self._plots["clearance"].visible = False
        elif not has_meshes(plan):
            self._add_clearance(plan, motion)

    def _add_slow(self, plan: Plan, motion: ArmMotion) -> None:
        """Add what is plotted once the hand rests."""
        self._resting = motion
        samples = plotted_samples(motion)
        time = motion.time[samples]
        self._add(self._plots["acceleration"], time, *acceleration(plan)[samples].T)
        if has_meshes(plan):
            self._add_clearance(plan, motion)
        distances = tool_clearance(plan)
        if distances is None:
            self._plots["tool"].visible = False
        else:
            self._add(self._plots["tool"], time, distances[samples])

    def _add_clearance(self, plan: Plan, motion: ArmMotion) -> None:
        """Add the clearance of the arm, which takes a while where there are meshes."""
        samples = plotted_samples(motion)
        distances = links_clearance(plan, samples.step)
        if distances is not None:
            self._add(self._plots["clearance"], motion.time[samples], distances)

    def _others(self, motion: ArmMotion, unit: str) -> viser.GuiUplotHandle:
        """The plot of a motion's joints, made anew where names or units are others."""
        named = *motion.joints, _joints_title(motion, unit)
        if named != self._named or self._other is None:
            if self._other is not None:
                self._other.remove()
            lines = zip(motion.joints, itertools.cycle(style.JOINTS), strict=False)
            with self._layout.plots:
                title = named[-1]
                self._other = new_plot(self._layout.client.gui, title, tuple(lines), 250)
            self._named = named
        return self._other


def _joints_title(motion: ArmMotion, unit: str) -> str:
    """Title with the units of the joints: turning ones in radians, sliding ones in the scene's."""
    units = [*(["rad"] if not all(motion.slides) else []), *([unit] if any(motion.slides) else [])]
    return f"joint positions [{', '.join(units)}]"

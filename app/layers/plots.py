"""Plots of speed (the paper's Fig. 8) and joint positions over time; the page marks the present."""

from __future__ import annotations

import itertools
from typing import ClassVar

import numpy as np
import viser

from abi.arm.arm import JOINTS
from abi.arm.trajectory import ArmMotion
from abi.planner.plan import Plan
from app import style
from app.frame import Frame, Switch
from app.layers.motion_curves import (
    acceleration,
    has_meshes,
    links_clearance,
    tool_clearance,
)
from app.layers.time_plot import TimePlots, new_plot
from app.layout import Layout

_JOINTS = ("q1 base", "q2 shoulder", "q3 elbow", "q4 wrist", "q5 slide", "q6 gripper")
_NO_MOTION = (
    '<div style="box-sizing:border-box;height:{}px;padding:8px 10px;font-size:12.5px">'
    "No motion, nothing to plot.</div>"
)
_SPEED_HEIGHT = 130
_AROUND = 71
"""Height of a plot's title and legend with the space around them, [px]."""


class PlotsLayer:
    """The speed plot in the result tab, the joints in their own."""

    switches: ClassVar[tuple[Switch, ...]] = ()

    def __init__(self, layout: Layout) -> None:
        gui, unit = layout.client.gui, layout.unit
        speed = (("speed", style.MARK), *zip("xyz", style.AXES, strict=True))
        angles = tuple((_JOINTS[i - 1], style.JOINTS[i - 1]) for i in (1, 2, 3, 4, 6))
        with layout.result:
            # as high as the plot: what is below is not to move under the hand
            notes = [gui.add_html(_NO_MOTION.format(_SPEED_HEIGHT + _AROUND), visible=False)]
            self._speed = new_plot(gui, _speed_title(unit), speed, _SPEED_HEIGHT)
        with layout.plots:
            notes.append(gui.add_html(_NO_MOTION.format(40), visible=False))
            self._angles = new_plot(gui, "joint angles [rad]", angles, 250)
            self._slide = new_plot(gui, _slide_title(unit), ((_JOINTS[4], style.JOINTS[4]),), 170)
            clear = (("links to obstacles", style.MARK),)
            pulls = (("acceleration", style.MARK), *zip("xyz", style.AXES, strict=True))
            tool = (("tool to obstacles", style.BSPLINE),)
            self._clearance = new_plot(gui, _clearance_title(unit), clear, 170)
            self._tool = new_plot(gui, _tool_title(unit), tool, 170)
            self._pull = new_plot(gui, _pull_title(unit), pulls, 190)
        self._unit = unit
        self._no_motion = notes
        others = (self._angles, self._slide, self._clearance, self._tool, self._pull)
        self._plots = (self._speed, *others)
        self._layout = layout
        self._named: tuple[str, ...] = ()
        self._other: viser.GuiUplotHandle | None = None
        self._motion: object = self  # not that of the first plan, which may be None
        self._plotted: object = None
        self._resting: object = None
        self._shown = TimePlots()

    def draw(self, frame: Frame) -> None:
        """Plot the plan's motion; nothing where there is none."""
        plan = frame.plan
        if plan.motion is not self._motion:
            self._replace(plan)
        if frame.plots and plan.motion is not None:
            if self._plotted is not plan.motion:
                self._add_joints(plan, plan.motion)
            if not frame.interactive and self._resting is not plan.motion:
                self._add_slow(plan, plan.motion)
        self._shown.show(frame.interactive)

    def _replace(self, plan: Plan) -> None:
        """Keep the plan's motion, to be plotted, and plot its speed."""
        motion = self._motion = plan.motion
        if self._other is not None and (motion is None or motion.joints == JOINTS):
            self._other.visible = False
        self._shown.clear()
        for note in self._no_motion:
            note.visible = motion is None
        if motion is None:
            for plot in self._plots:
                plot.visible = False
            return
        # a new title builds the chart anew, which then forgets its time axis
        if plan.scene.unit != self._unit:
            self._unit = plan.scene.unit
            self._speed.title = _speed_title(self._unit)
            self._slide.title = _slide_title(self._unit)
            self._clearance.title = _clearance_title(self._unit)
            self._tool.title = _tool_title(self._unit)
            self._pull.title = _pull_title(self._unit)
        velocity = motion.velocity[_samples(motion)]
        speed = np.linalg.norm(velocity, axis=1)
        self._shown.add(self._speed, motion.time[_samples(motion)], speed, *velocity.T)

    def _add_joints(self, plan: Plan, motion: ArmMotion) -> None:
        """Add what is plotted in the plots' tab, except for what is slow."""
        self._plotted = motion
        time, positions = motion.time[_samples(motion)], motion.positions[_samples(motion)]
        if motion.joints == JOINTS:
            self._shown.add(self._angles, time, *positions[:, [0, 1, 2, 3, 5]].T)
            self._shown.add(self._slide, time, positions[:, 4])
        else:
            self._angles.visible = self._slide.visible = False
            others = self._others(motion, plan.scene.unit)
            self._shown.add(others, time, *positions.T)
        if plan.arm_clearance is None or plan.arm_clearance.obstacle < 0:
            self._clearance.visible = False
        elif not has_meshes(plan):
            self._add_clearance(plan, motion)

    def _add_slow(self, plan: Plan, motion: ArmMotion) -> None:
        """Add what is plotted once the hand rests."""
        self._resting = motion
        time = motion.time[_samples(motion)]
        self._shown.add(self._pull, time, *acceleration(plan)[_samples(motion)].T)
        if has_meshes(plan):
            self._add_clearance(plan, motion)
        distances = tool_clearance(plan)
        if distances is None:
            self._tool.visible = False
        else:
            self._shown.add(self._tool, time, distances[_samples(motion)])

    def _add_clearance(self, plan: Plan, motion: ArmMotion) -> None:
        """Add the clearance of the arm, which takes a while where there are meshes."""
        distances = links_clearance(plan, _samples(motion).step)
        if distances is not None:
            self._shown.add(self._clearance, motion.time[_samples(motion)], distances)

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


def _samples(motion: ArmMotion) -> slice:
    """About a hundred of a motion's samples."""
    return slice(None, None, max(1, len(motion.time) // 100))


def _joints_title(motion: ArmMotion, unit: str) -> str:
    """Title with the units of the joints: turning ones in radians, sliding ones in the scene's."""
    units = [*(["rad"] if not all(motion.slides) else []), *([unit] if any(motion.slides) else [])]
    return f"joint positions [{', '.join(units)}]"


def _speed_title(unit: str) -> str:
    return f"speed of the tool, and along x, y, z [{unit}/s]"


def _slide_title(unit: str) -> str:
    return f"slide [{unit}]"


def _tool_title(unit: str) -> str:
    return f"clearance of the tool [{unit}]"


def _pull_title(unit: str) -> str:
    return f"acceleration of the tool [{unit}/s²]"


def _clearance_title(unit: str) -> str:
    return f"clearance of the arm [{unit}]"

"""Plots over time of speed (the paper's Fig. 8) and joint positions, with a line at "now"."""

from __future__ import annotations

import itertools
import time as clock
from typing import ClassVar

import numpy as np
import viser
from viser import uplot

from abi.arm.arm import JOINTS
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from app import style
from app.frame import Frame, Switch
from app.layers.motion_curves import acceleration, joint_speeds, tool_clearance
from app.layout import Layout

_GREY = "rgba(128,128,128,0.25)"
_INK = "#868e96"
_FLAT = 1e-9
_JOINTS = ("q1 base", "q2 shoulder", "q3 elbow", "q4 wrist", "q5 slide", "q6 gripper")
_DASHES: tuple[tuple[float, ...], ...] = ((), (8, 4), (2, 3), (12, 4, 2, 4), (5, 3, 1, 3))
"""Of the lines of a plot, in order: none is told from another by its colour alone."""
_NO_MOTION = '<div style="margin:8px 10px;font-size:12.5px">No motion, nothing to plot.</div>'
_MARK_PERIOD = 0.08
"""Seconds between two moves of the line while the arm plays: each sends all curves anew."""


class PlotsLayer:
    """The speed plot in the result tab, the joints in their own."""

    switches: ClassVar[tuple[Switch, ...]] = ()

    def __init__(self, layout: Layout) -> None:
        gui, unit = layout.client.gui, layout.unit
        speed = (("speed", style.MARK), *zip("xyz", style.AXES, strict=True))
        angles = tuple((_JOINTS[i - 1], style.JOINTS[i - 1]) for i in (1, 2, 3, 4, 6))
        with layout.result:
            self._speed = _plot(gui, _speed_title(unit), speed, 160)
        with layout.joints:
            self._no_motion = gui.add_html(_NO_MOTION)
            self._angles = _plot(gui, "joint angles [rad]", angles, 250)
            self._slide = _plot(gui, _slide_title(unit), ((_JOINTS[4], style.JOINTS[4]),), 170)
            clear = (("links to obstacles", style.MARK),)
            rates = tuple((f"{name}′", colour) for name, colour in angles)
            pulls = (("acceleration", style.MARK), *zip("xyz", style.AXES, strict=True))
            tool = (("tool to obstacles", style.BSPLINE),)
            self._clearance = _plot(gui, _clearance_title(unit), clear, 170)
            self._tool = _plot(gui, _tool_title(unit), tool, 170)
            self._pull = _plot(gui, _pull_title(unit), pulls, 190)
            self._rates = _plot(gui, "joint speeds [rad/s]", rates, 230)
        self._unit = unit
        self._quick = (self._speed, self._angles, self._slide, self._clearance)
        self._plots = (*self._quick, self._tool, self._pull, self._rates)
        self._layout = layout
        self._named: tuple[str, ...] = ()
        self._other: viser.GuiUplotHandle | None = None
        self._motion: object = None
        self._resting: object = None
        self._marked: tuple[object, float] = (None, -1.0)
        self._next_mark = 0.0
        self._data: tuple[tuple[viser.GuiUplotHandle, tuple[FloatArray, ...]], ...] = ()

    def draw(self, frame: Frame) -> None:
        """Plot the plan's motion with a line at "now"; nothing where there is none."""
        if frame.plan.motion is not self._motion:
            self._replace(frame.plan)
        if not frame.interactive and self._resting is not self._motion:
            self._add_slow(frame.plan)
        if (self._motion, frame.time) != self._marked:
            self._mark(frame.time, frame.playing)

    def _replace(self, plan: Plan) -> None:
        """Keep the plan's motion, to be sent with the line."""
        self._motion = plan.motion
        if self._other is not None and (plan.motion is None or plan.motion.joints == JOINTS):
            self._other.visible = False
        self._next_mark = 0.0
        self._no_motion.visible = plan.motion is None
        if plan.motion is None:
            self._data = ()
            for plot in self._plots:
                plot.visible = False
            return
        motion = plan.motion
        samples = slice(None, None, max(1, len(motion.time) // 100))
        time, positions = motion.time[samples], motion.positions[samples]
        velocity = motion.velocity[samples]
        speed = np.linalg.norm(velocity, axis=1)
        # a new title builds the chart anew, which then forgets its time axis
        if plan.scene.unit != self._unit:
            self._unit = plan.scene.unit
            self._speed.title = _speed_title(self._unit)
            self._slide.title = _slide_title(self._unit)
            self._clearance.title = _clearance_title(self._unit)
            self._tool.title = _tool_title(self._unit)
            self._pull.title = _pull_title(self._unit)
        self._data = ((self._speed, (time, speed, *velocity.T)),)
        if motion.joints == JOINTS:
            self._data += (
                (self._angles, (time, *positions[:, [0, 1, 2, 3, 5]].T)),
                (self._slide, (time, positions[:, 4])),
            )
        else:
            self._angles.visible = self._slide.visible = False
            self._data += ((self._others(motion.joints), (time, *positions.T)),)
        clearance = plan.arm_clearance
        if clearance is not None and clearance.obstacle >= 0:
            self._data += ((self._clearance, (time, clearance.distances[samples])),)
        else:
            self._clearance.visible = False

    def _add_slow(self, plan: Plan) -> None:
        """Add what is plotted once the hand rests."""
        self._resting, self._marked = self._motion, (None, -1.0)
        self._next_mark = 0.0
        motion = plan.motion
        if motion is None:
            return
        samples = slice(None, None, max(1, len(motion.time) // 100))
        time = motion.time[samples]
        self._data += ((self._pull, (time, *acceleration(motion)[samples].T)),)
        if motion.joints == JOINTS:
            rates = joint_speeds(motion)[samples][:, [0, 1, 2, 3, 5]]
            self._data += ((self._rates, (time, *rates.T)),)
        else:
            self._rates.visible = False
        distances = tool_clearance(plan)
        if distances is None:
            self._tool.visible = False
        else:
            self._data += ((self._tool, (time, distances[samples])),)

    def _others(self, joints: tuple[str, ...]) -> viser.GuiUplotHandle:
        """The plot of joints with these names, made anew where they are others."""
        if joints != self._named or self._other is None:
            if self._other is not None:
                self._other.remove()
            lines = zip(joints, itertools.cycle(style.JOINTS), strict=False)
            with self._layout.joints:
                title = "joint positions [rad, m]"
                self._other = _plot(self._layout.client.gui, title, tuple(lines), 250)
            self._named = joints
        return self._other

    def _mark(self, time: float, playing: bool) -> None:
        """Draw the line at ``time`` [s]; while ``playing`` not at every frame."""
        now = clock.monotonic()
        if playing and now < self._next_mark:
            return
        self._next_mark = now + _MARK_PERIOD
        self._marked = self._motion, time
        for handle, (times, *series) in self._data:
            low = min(float(np.min(line)) for line in series)
            high = max(float(np.max(line)) for line in series)
            if high - low < _FLAT:
                low, high = low - 1, high + 1
            # three samples at the same time make the upright line, on a scale from 0 to 1 of its
            # own that leaves the rest of it outside; uplot has no marker
            index = int(np.searchsorted(times, time))
            marked = np.insert(times, index, (time, time, time))
            upright = np.full(len(marked), -1.0)
            upright[index + 1] = 2.0
            # uplot finds no scale for a constant: this line, not to be seen, spans one
            span = np.full(len(marked), high)
            span[0] = low
            lines = (np.interp(marked, times, line) for line in series)
            handle.data = (marked, *lines, upright, span)
            # Never shown before it has its data: a chart that gets them before it is drawn for the
            # first time stays without a time axis.
            handle.visible = True


def _speed_title(unit: str) -> str:
    return f"tool speed, and along x, y, z [{unit}/s]"


def _slide_title(unit: str) -> str:
    return f"slide [{unit}]"


def _tool_title(unit: str) -> str:
    return f"clearance of the tool [{unit}]"


def _pull_title(unit: str) -> str:
    return f"acceleration of the tool [{unit}/s²]"


def _clearance_title(unit: str) -> str:
    return f"clearance of the arm [{unit}]"


def _plot(
    gui: viser.GuiApi, title: str, lines: tuple[tuple[str, style.Colour], ...], height: int
) -> viser.GuiUplotHandle:
    series = [uplot.Series(label="t")]
    series += [
        uplot.Series(label=name, stroke=style.css(colour), width=2, dash=dash)
        for (name, colour), dash in zip(lines, _DASHES, strict=False)
    ]
    series += [
        uplot.Series(label="now", stroke=_INK, width=1, scale="mark"),
        uplot.Series(label="", stroke="transparent", width=0),
    ]
    axis = uplot.Axis(
        stroke=_INK, grid=uplot.Axis_Grid(stroke=_GREY, width=1), size=40, font="11px sans-serif"
    )
    empty = np.array([0.0, 1.0])
    return gui.add_uplot(
        (empty, *(np.zeros(2) for _ in series[1:])),
        tuple(series),
        title=title,
        scales={"x": uplot.Scale(time=False), "mark": uplot.Scale(range=(0.0, 1.0))},
        legend=uplot.Legend(live=False),
        axes=(axis, axis),
        height=height,
        visible=False,
    )

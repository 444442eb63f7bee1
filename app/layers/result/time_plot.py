"""Plot of curves over time, in which the page marks the present."""

from __future__ import annotations

import itertools

import numpy as np
import viser
from viser import uplot

from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import FloatArray
from app.ui import page, style

_GREY = "rgba(128,128,128,0.25)"
_FONT = "11px sans-serif"
_FLAT = 1e-9
_DASHES: tuple[tuple[float, ...], ...] = ((), (8, 4), (2, 3), (12, 4, 2, 4), (5, 3, 1, 3))
"""Of the lines of a plot, in turn: none is told from another by its colour alone. The legend's are
in ``assets/page/page.js``."""
_SPACE = 18
"""Least distance of two numbers beside a plot, [px]: more, and a low one has none but 0."""
_PADDING = (9, 14, 0, 0)
"""Above, right, below and left of the axes, [px]: half of the topmost number is above its line."""

Lines = tuple[tuple[str, style.Colour], ...]
"""Name and colour of each line of a plot."""


def plotted_samples(motion: ArmMotion) -> slice:
    """About a hundred of a motion's samples."""
    return slice(None, None, max(1, len(motion.time) // 100))


def new_plot(gui: viser.GuiApi, title: str, lines: Lines, height: int) -> viser.GuiUplotHandle:
    """New plot of curves over time, hidden until it has lines."""
    series = [uplot.Series(label="t")]
    series += [
        uplot.Series(label=name, stroke=style.css(colour), width=2, dash=dash)
        for (name, colour), dash in zip(lines, itertools.cycle(_DASHES), strict=False)
    ]
    series.append(uplot.Series(label="", stroke="transparent", width=0))
    # without a stroke the page takes the one of its theme, light or dark
    grid = uplot.Axis_Grid(stroke=_GREY, width=1)
    upright = uplot.Axis(grid=grid, size=46, font=_FONT, space=_SPACE)
    along = uplot.Axis(
        grid=grid, size=27, font=_FONT, label="time [s]", labelSize=14, labelGap=1, labelFont=_FONT
    )
    empty = np.array([0.0, 1.0])
    return gui.add_uplot(
        (empty, *(np.zeros(2) for _ in series[1:])),
        tuple(series),
        title=title,
        scales={"x": uplot.Scale(time=False)},
        legend=uplot.Legend(live=True),  # the page shows its values beside the pointer
        axes=(along, upright),
        height=height,
        padding=_PADDING,
        visible=False,
    )


def show_lines(handle: viser.GuiUplotHandle, times: FloatArray, *series: FloatArray) -> None:
    """Show lines (m,) over times (m,) in a plot."""
    shown = [line.astype(np.float32) for line in (times, *series)]
    low = min(float(line.min()) for line in shown[1:])
    high = max(float(line.max()) for line in shown[1:])
    if high - low < _FLAT:
        low, high = low - 1, high + 1
    # uplot finds no scale for a constant: this line, not to be seen, spans one
    span = np.full(len(times), high, np.float32)
    span[0] = low
    page.set_lines(handle, (*shown, span))
    # Never shown before it has its data: a chart that gets them before it is drawn for the
    # first time stays without a time axis.
    handle.visible = True

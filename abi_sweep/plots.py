"""Plots of a study: gaps, clearances and times against the first field that varies.

Each value of the second field that varies has a line of its own.
"""

from __future__ import annotations

import importlib.util
import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from abi_sweep.result_file import write_result
from abi_sweep.row import Row
from abi_sweep.table import grouped, quantile, share

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_INK, _GRID = "#888888", "#88888844"
"""Greys that show on light and on dark pages."""
_COLOURS = ("#e0409a", "#2f7fd6", "#e08a1e", "#2aa198", "#8a63d2", "#7f7f7f")
_DASHES = ("-", "--", "-.", ":")
_MARKERS = "osD^v*"
_GAP, _PART = "longer than the proven bound [%]", "share of the plans [%]"
_FEWEST = 0.5
"""Part of a group's plans that must have a value: the median of fewer says little."""

Panel = tuple[str, str, str]
"""Title, label of the ordinate, column."""

_FIGURES: dict[str, tuple[Panel, ...]] = {
    "gaps": (
        ("path on the mesh", _GAP, "path_gap"),
        ("taut path", _GAP, "taut_gap"),
        ("B-spline", _GAP, "bspline_gap"),
    ),
    "clearances": (
        ("plans that are complete", _PART, "complete"),
        ("B-splines proven clear", _PART, "bspline_proven"),
        ("quadratics proven clear", _PART, "quadratic_proven"),
    ),
    "times": (
        ("whole plan", "time [ms]", "total_ms"),
        ("mesh", "time [ms]", "mesh_ms"),
        ("taut path", "time [ms]", "taut_ms"),
    ),
}
_SHARES = ("complete", "bspline_proven", "quadratic_proven")


def write_plots(rows: Sequence[Row], fields: Sequence[str], folder: Path) -> list[Path]:
    """Write ``gaps.svg``, ``clearances.svg`` and ``times.svg``, and return the files written.

    Without matplotlib nothing is written.

    Args:
        rows: rows of a study.
        fields: the field on the abscissa, and the one whose values have lines, if there is one.
        folder: folder for the files.

    Raises:
        AbiError: one of them cannot be written; those before it are, and each is whole.
    """
    if importlib.util.find_spec("matplotlib") is None:
        return []
    import matplotlib

    written = []
    for name, panels in _FIGURES.items():
        path, picture = folder / f"{name}.svg", io.BytesIO()
        with matplotlib.rc_context({"svg.hashsalt": name}):
            figure = _figure(rows, fields, panels)
            figure.savefig(picture, format="svg", transparent=True, metadata={"Date": None})
        write_result(path, picture.getvalue())
        written.append(path)
    return written


def _figure(rows: Sequence[Row], fields: Sequence[str], panels: Sequence[Panel]) -> Figure:
    from matplotlib.figure import Figure

    across, along = fields[0], fields[1:2]
    figure = Figure(figsize=(10, 3.6), layout="constrained")
    every: Any = figure.subplots(1, len(panels))
    for axes, (title, label, column) in zip(every, panels, strict=True):
        for number, (names, group) in enumerate(grouped(rows, along).items()):
            _draw(axes, group, across, column, number, "".join(names))
        axes.set_title(title, color=_INK, fontsize=11)
        axes.set_xlabel(across, color=_INK)
        axes.set_ylabel(label, color=_INK)
        axes.tick_params(colors=_INK, which="both")
        axes.grid(color=_GRID)
        axes.spines[:].set_color(_GRID)
        if label == _PART:
            axes.set_ylim(-3, 103)
        elif not any(len(line.get_xdata()) for line in axes.lines):
            axes.text(0.5, 0.5, "none", color=_INK, ha="center", transform=axes.transAxes)
        elif "time" in label:
            axes.set_yscale("log")
    for field in along:
        handles, names = every[0].get_legend_handles_labels()
        figure.legend(
            handles, names, title=field, loc="outside right center", frameon=False, labelcolor=_INK
        ).get_title().set_color(_INK)
    return figure


def _draw(axes: Any, rows: Sequence[Row], across: str, column: str, number: int, name: str) -> None:
    """A line through the medians, with a band from the first to the last tenth; or the shares."""
    by_value = grouped(rows, [across]).items()
    groups = {_number(value): group for (value,), group in by_value if _has(group, column)}
    places = [*groups]
    look = {
        "color": _COLOURS[number % len(_COLOURS)],
        "linestyle": _DASHES[number % len(_DASHES)],
        "marker": _MARKERS[number % len(_MARKERS)],
        "markersize": 4,
        "label": name,
    }
    if column in _SHARES:
        axes.plot(places, [share(group, column) for group in groups.values()], **look)
        return
    factor = 100.0 if column.endswith("_gap") else 1.0
    low, middle, high = (
        [factor * (quantile(group, column, part) or 0.0) for group in groups.values()]
        for part in (0.1, 0.5, 0.9)
    )
    axes.plot(places, middle, **look)
    if not any(isinstance(place, str) for place in places):
        axes.fill_between(places, low, high, color=look["color"], alpha=0.12, linewidth=0)


def _has(rows: Sequence[Row], column: str) -> bool:
    """Check whether enough rows have a value in the column; a share counts them all."""
    found = sum(row.get(column) is not None for row in rows)
    return column in _SHARES or found >= _FEWEST * len(rows)


def _number(value: str) -> float | str:
    try:
        return float(value)
    except ValueError:
        return value

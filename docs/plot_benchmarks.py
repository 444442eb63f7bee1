"""Plots of what `abi bench` measured, from the file it writes.

python docs/plot_benchmarks.py [bench.json] [FOLDER]
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

Row = dict[str, Any]
HERE = Path(__file__).parent
INK, GRID = "#888888", "#88888844"
"""Greys that show on light and on dark pages."""
FRAME_MS = 1000 / 60
_LEFT_OUT = (", 10 ms", ", 50 ms")
_PLANNERS = {
    "ours": "#e0409a",
    "OMPL, as long as ours took": "#4f7fb5",
    "OMPL, 200 ms": "#9fbcd9",
}


def plot(data: Path, folder: Path) -> None:
    """Write ``bench-*.svg`` into ``folder``, unless they are newer than the data."""
    sections = json.loads(data.read_text(encoding="utf-8"))["sections"]
    for name, draw in {"frames": _frames, "ratios": _ratios, "quality": _quality}.items():
        rows = sections["frames" if name == "ratios" else name]
        file = folder / f"bench-{name}.svg"
        if not file.exists() or file.stat().st_mtime < data.stat().st_mtime:
            draw(rows).savefig(file, transparent=True, metadata={"Date": None})


def _frames(rows: list[Row]) -> Figure:
    """Milliseconds per frame against the number of nodes."""
    figure, axes = _axes("nodes", "milliseconds a frame")
    wanted = {"frame a_star": "ours, A*", "frame, scipy": "scipy", "frame, networkx": "networkx"}
    for method, label in {**wanted, "re-plan": "ours, all six stages"}.items():
        points = _series(rows, "cube", method, "ms")
        if points:
            axes.plot(*zip(*points, strict=True), marker="o", label=label)
    axes.axhline(FRAME_MS, color=INK, linestyle=":", label="60 Hz")
    axes.set(xscale="log", yscale="log")
    figure.legend(loc="outside right upper", frameon=False, labelcolor=INK)
    return figure


def _ratios(rows: list[Row]) -> Figure:
    """Ratio of the best library's time for a frame to ours, by scene."""
    figure, axes = _axes("nodes", "best library's time / ours")
    for scene in sorted({row["scene"] for row in rows}):
        points = _series(rows, scene, "frame a_star", "faster")
        axes.plot(*zip(*points, strict=True), marker="o", label=scene)
    axes.axhline(1.0, color=INK, linestyle=":")
    axes.set(xscale="log", ylim=(0, None))
    axes.legend(frameon=False, labelcolor=INK)
    return figure


def _quality(rows: list[Row]) -> Figure:
    """Excess over the best known length, in nine scenes of ten."""
    figure, axes = _axes("longer than the best known, nine of ten scenes [%]", "")
    found: dict[str, float] = {}
    for row in rows:
        name = str(row["method"])
        if row.get("p90") is not None and not name.endswith(_LEFT_OUT):
            found[name] = max(100 * (float(row["p90"]) - 1), 1e-3)
    names = sorted(found, key=lambda name: -found[name])
    figure.set_figheight(1.2 + 0.22 * len(names))
    for label, colour in _PLANNERS.items():
        rows_of = [k for k, name in enumerate(names) if _planner(name) == label]
        axes.barh(rows_of, [found[names[k]] for k in rows_of], color=colour, label=label)
    axes.set_yticks(range(len(names)), names)
    axes.set_xscale("log")
    axes.legend(frameon=False, labelcolor=INK)
    return figure


def _planner(method: str) -> str:
    """Whose a method is, by the time that it has."""
    _, _, budget = method.partition(", ")
    return {"": "ours", "equal": "OMPL, as long as ours took"}.get(budget, f"OMPL, {budget}")


def _series(rows: list[Row], scene: str, method: str, value: str) -> list[tuple[float, float]]:
    return sorted(
        (row["nodes"], row[value])
        for row in rows
        if row["scene"] == scene and row["method"] == method and row.get(value) is not None
    )


def _axes(across: str, up: str) -> tuple[Figure, Any]:
    figure = Figure(figsize=(7, 4), layout="constrained")
    axes: Any = figure.add_subplot()
    axes.set_xlabel(across, color=INK)
    axes.set_ylabel(up, color=INK)
    axes.tick_params(colors=INK, which="both")
    axes.grid(color=GRID)
    axes.spines[:].set_color(GRID)
    return figure, axes


if __name__ == "__main__":
    arguments = [Path(argument) for argument in sys.argv[1:]]
    defaults = [HERE / "data" / "bench.json", HERE / "data"]
    plot(*[*arguments, *defaults[len(arguments) :]])

"""Results of the benchmarks as tables, as JSON and as pictures."""

from __future__ import annotations

import json
import math
import os
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

Row = dict[str, Any]


def table(rows: Sequence[Row]) -> str:
    """The rows, one a line under the names of their fields."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    cells = [names, *([_cell(row.get(name)) for name in names] for row in rows)]
    widths = [max(len(line[k]) for line in cells) for k in range(len(names))]
    return "\n".join(
        "  ".join(
            cell.ljust(width) if k == 0 else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in cells
    )


def save(sections: dict[str, list[Row]], folder: Path) -> list[Path]:
    """Write ``bench.json``, and pictures where matplotlib is installed; the files written."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "bench.json"
    data = {"machine": machine(), "sections": sections}
    file.write_text(json.dumps(_finite(data), indent=1) + "\n", encoding="utf-8")
    written = [file]
    for name, rows in sections.items():
        curves = _curves(rows)
        if curves and (picture := _picture(name, curves, folder / f"{name}.png")):
            written.append(picture)
    return written


def machine() -> Row:
    """Machine and versions that the figures depend on."""
    packages = ("numpy", "scipy", "numba", "viser")
    return {
        "system": platform.platform(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        **{name: version(name) for name in packages},
    }


def _curves(rows: Sequence[Row]) -> dict[str, list[tuple[float, float]]]:
    """Cost against nodes by method, for sections that have both."""
    curves: dict[str, list[tuple[float, float]]] = {}
    for row in rows:
        if {"nodes", "method", "ms"} <= row.keys():
            label = " · ".join(str(row[key]) for key in ("scene", "method") if key in row)
            curves.setdefault(label, []).append((row["nodes"], row["ms"]))
    return {label: points for label, points in curves.items() if len(points) > 1}


def _picture(name: str, curves: dict[str, list[tuple[float, float]]], path: Path) -> Path | None:
    try:
        from matplotlib.figure import Figure
    except ImportError:
        return None
    figure = Figure(figsize=(8, 5.5), layout="constrained")
    axes = figure.add_subplot(xlabel="nodes", ylabel="ms", title=name, xscale="log", yscale="log")
    for label, points in curves.items():
        axes.plot(*zip(*sorted(points), strict=True), marker="o", markersize=3, label=label)
    axes.grid(True, which="both", alpha=0.25)
    axes.axhline(1000 / 60, linestyle=":", color="grey")
    axes.legend(fontsize=7)
    figure.savefig(path, dpi=120)
    return path


def _cell(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
    return f"{value:,}" if isinstance(value, int) else str(value)


def _finite(value: Any) -> Any:
    """The value with None for infinities, which JSON has not."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value

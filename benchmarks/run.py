"""All benchmarks in one run: tables on the screen, JSON and pictures in a folder."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Sequence
from pathlib import Path

import click

from benchmarks import report
from benchmarks.report import Row

SIZES = (200, 2_000, 20_000, 200_000, 1_000_000)
SCENES = 30
_MAX_TAB_NODES = 200_000


def run(parts: Sequence[str], sizes: Sequence[int], scenes: int, folder: Path) -> None:
    """Run the parts one after the other, print their tables and save them.

    Args:
        parts: of :data:`PARTS`; all when empty.
        sizes: numbers of nodes.
        scenes: how many random scenes the quality is taken from.
        folder: where ``bench.json`` and the pictures go.
    """
    sections: dict[str, list[Row]] = {}
    for name in parts or PARTS:
        missing = [module for module in _NEEDS[name] if importlib.util.find_spec(module) is None]
        if missing:
            click.echo(f"{name}: left out, {' and '.join(missing)} is not installed.\n")
            continue
        sections[name] = PARTS[name](sizes, scenes)
        click.echo(f"{name}\n{report.table(sections[name])}\n")
    for file in report.save(sections, folder):
        click.echo(f"written: {file}")


def _frames(sizes: Sequence[int], scenes: int) -> list[Row]:
    from benchmarks import frames

    return frames.measure(sizes)


def _quality(sizes: Sequence[int], scenes: int) -> list[Row]:
    from benchmarks import quality

    runs, _ = quality.measure(range(scenes), 0.25, (0.01, 0.05, 0.2), quality.is_ompl_installed())
    return quality.summary(runs)


def _browser(sizes: Sequence[int], scenes: int) -> list[Row]:
    from benchmarks import browser

    with browser.chromium() as running:
        return [browser.measure(nodes, running) for nodes in sizes if nodes <= _MAX_TAB_NODES]


def _start(sizes: Sequence[int], scenes: int) -> list[Row]:
    from benchmarks import browser, start

    with browser.chromium() as running:
        return [start.measure(running)]


def _tab(sizes: Sequence[int], scenes: int) -> list[Row]:
    from benchmarks import tab

    return [tab.measure(nodes) for nodes in sizes if nodes <= _MAX_TAB_NODES]


def _tabs(sizes: Sequence[int], scenes: int) -> list[Row]:
    from benchmarks import tabs

    return tabs.measure(tabs.COUNTS)


def _crowds(sizes: Sequence[int], scenes: int) -> list[Row]:
    from benchmarks import crowds

    return crowds.measure(crowds.COUNTS) + crowds.measure(crowds.COUNTS, meshes=0.33)


def _arm(sizes: Sequence[int], scenes: int) -> list[Row]:
    from benchmarks import arm

    return arm.measure(scenes)


def _shapes(sizes: Sequence[int], scenes: int) -> list[Row]:
    from benchmarks import shapes

    rows = shapes.measure([nodes for nodes in sizes if nodes <= _MAX_TAB_NODES])
    return rows + shapes.measure_rooms()


PARTS: dict[str, Callable[[Sequence[int], int], list[Row]]] = {
    "frames": _frames,
    "quality": _quality,
    "browser": _browser,
    "start": _start,
    "tab": _tab,
    "tabs": _tabs,
    "crowds": _crowds,
    "shapes": _shapes,
    "arm": _arm,
}
"""Costs of a drag, lengths over the optimum, latency in the browser, start, cost of a tab,
many tabs that all drag, drags among many obstacles, of triangle meshes beside libraries, and
plans of the whole arm."""

_NEEDS: dict[str, tuple[str, ...]] = {
    "frames": (),
    "quality": (),
    "browser": ("playwright",),
    "start": ("playwright",),
    "tab": ("playwright",),
    "tabs": (),
    "crowds": (),
    "shapes": (),
    "arm": (),
}

"""Pictures of the page with each shipped scene, at several sizes and times, on one sheet a scene.

    python -m tools.contact_sheets FOLDER [--scenes NAME …] [--sizes 1440x900 …] [--themes dark …]

One looks at them for what is cut off, hidden or overlaps. A sheet has a row for each size of the
page and a column for each time of the motion; each theme has sheets of its own.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser

from abi.scene.scene import scene_names
from benchmarks.browser import chromium
from tools.visit import Visit, visit

SIZES = ("1440x900", "1280x720", "1920x1080", "390x844")
THEMES = ("dark", "light")
TIMES = (0.0, 0.25, 0.5, 0.75, 1.0)
_HEIGHT = 450
"""Of a picture on a sheet, [px]."""
_RATIO = 0.6
"""Pixels of the scene for one of the page: the text around it is drawn in full all the same."""


def sheets(
    browser: Browser, scene: str, sizes: Sequence[str], themes: Sequence[str]
) -> dict[str, Image.Image]:
    """The sheets of a scene, by theme."""
    rows: dict[str, list[Image.Image]] = {theme: [] for theme in themes}
    for size in sizes:
        width, height = map(int, size.split("x"))
        with visit(browser, scene, width, height, ratio=_RATIO) as visited:
            for theme, found in rows.items():
                visited.darken(theme == "dark")
                found.append(_beside([_picture(visited, time) for time in TIMES]))
    return {theme: _below(found) for theme, found in rows.items()}


def _picture(visited: Visit, time: float) -> Image.Image:
    plan = visited.session.plan
    if plan is not None and plan.profile is not None:
        visited.time(time)
    whole = visited.picture()
    return whole.resize((whole.width * _HEIGHT // whole.height, _HEIGHT))


def _beside(pictures: Sequence[Image.Image]) -> Image.Image:
    row = Image.new("RGB", (sum(one.width for one in pictures), _HEIGHT))
    left = 0
    for one in pictures:
        row.paste(one, (left, 0))
        left += one.width
    return row


def _below(rows: Sequence[Image.Image]) -> Image.Image:
    sheet = Image.new("RGB", (max(row.width for row in rows), _HEIGHT * len(rows)))
    for number, row in enumerate(rows):
        sheet.paste(row, (0, _HEIGHT * number))
    return sheet


def main() -> None:
    """Write the sheets."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--scenes", nargs="+", default=scene_names())
    parser.add_argument("--sizes", nargs="+", default=SIZES)
    parser.add_argument("--themes", nargs="+", choices=THEMES, default=THEMES)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    with chromium() as browser:
        for name in options.scenes:
            for theme, sheet in sheets(browser, name, options.sizes, options.themes).items():
                file = options.folder / f"{name}-{theme}.png"
                sheet.save(file)
                print(file, flush=True)


if __name__ == "__main__":
    main()

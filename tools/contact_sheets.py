"""Pictures of the page with each shipped scene, at several sizes and times, a sheet for each size.

    python -m tools.contact_sheets FOLDER [--scenes NAME …] [--sizes 1440x900 …] [--themes dark …]

One looks at them for what is cut off, hidden or overlaps. A sheet has a row for each theme: the
whole page at the begin of the motion, and the scene between the panels at each of its times. One
page is opened for each scene, and resized.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser

from abi.scene.scene import scene_names
from benchmarks.browser import chromium
from tools.visit import Visit, visit

SIZES = ("1440x900", "1280x720", "1920x1080", "390x844")
THEMES = ("dark", "light")
TIMES = (0.0, 0.25, 0.5, 0.75, 1.0)
_HEIGHT, _HEIGHT_UPRIGHT = 340, 500
"""Of a picture on a sheet, [px], of pages that are wider than high and of others."""
_RATIO = 0.4
"""Pixels of the scene for one of the page: the text around it is drawn in full all the same."""


def sheets(
    browser: Browser, scene: str, sizes: Sequence[str], themes: Sequence[str]
) -> Iterator[tuple[str, Image.Image]]:
    """The sheets of a scene, with their sizes."""
    with visit(browser, scene, *_numbers(sizes[0]), ratio=_RATIO) as visited:
        for size in sizes:
            width, height = _numbers(size)
            visited.resize(width, height)
            yield size, _below([_row(visited, theme, upright=width < height) for theme in themes])


def _numbers(size: str) -> tuple[int, int]:
    width, height = map(int, size.split("x"))
    return width, height


def _row(visited: Visit, theme: str, upright: bool) -> Image.Image:
    """Pictures of the motion's times beside each other, and of the whole page."""
    visited.darken(theme == "dark")
    pictures = [] if upright else [visited.picture()]
    plan = visited.session.plan
    moves = plan is not None and plan.profile is not None
    for time in TIMES if moves else TIMES[:1]:
        if moves:
            visited.time(time)
        pictures.append(visited.picture(panels=upright))
    return _beside(pictures, _HEIGHT_UPRIGHT if upright else _HEIGHT)


def _beside(pictures: Sequence[Image.Image], height: int) -> Image.Image:
    small = [one.resize((one.width * height // one.height, height)) for one in pictures]
    row = Image.new("RGB", (sum(one.width for one in small), height))
    left = 0
    for one in small:
        row.paste(one, (left, 0))
        left += one.width
    return row


def _below(rows: Sequence[Image.Image]) -> Image.Image:
    sheet = Image.new("RGB", (max(row.width for row in rows), sum(row.height for row in rows)))
    for number, row in enumerate(rows):
        sheet.paste(row, (0, number * row.height))
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
            for size, sheet in sheets(browser, name, options.sizes, options.themes):
                file = options.folder / f"{name}-{size}.png"
                sheet.save(file)
                print(file, flush=True)


if __name__ == "__main__":
    main()

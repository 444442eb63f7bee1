"""Pictures of the page with each shipped scene, at several sizes and times, on one sheet a scene.

    python -m tools.contact_sheets FOLDER [--scenes NAME …] [--sizes 1440x900 …] [--light]

One looks at them for what is cut off, hidden or overlaps. A sheet has a row for each size of the
page and a column for each time of the motion.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser

from abi.scene.scene import scene_names
from benchmarks.browser import chromium
from tools.visit import Visit, visit

SIZES = ("1440x900", "1280x720", "1920x1080", "390x844")
TIMES = (0.0, 0.25, 0.5, 0.75, 1.0)
_HEIGHT = 360
"""Of a picture on a sheet, [px]."""


def sheet(browser: Browser, scene: str, sizes: tuple[str, ...], dark: bool) -> Image.Image:
    """The sheet of a scene."""
    rows = [_row(browser, scene, size, dark) for size in sizes]
    whole = Image.new("RGB", (max(row.width for row in rows), _HEIGHT * len(rows)))
    for number, row in enumerate(rows):
        whole.paste(row, (0, _HEIGHT * number))
    return whole


def _row(browser: Browser, scene: str, size: str, dark: bool) -> Image.Image:
    width, height = map(int, size.split("x"))
    with visit(browser, scene, width, height, dark) as visited:
        pictures = [_picture(visited, time) for time in TIMES]
    row = Image.new("RGB", (sum(one.width for one in pictures), _HEIGHT))
    left = 0
    for one in pictures:
        row.paste(one, (left, 0))
        left += one.width
    return row


def _picture(visited: Visit, time: float) -> Image.Image:
    plan = visited.session.plan
    if plan is not None and plan.profile is not None:
        visited.time(time)
    whole = visited.picture()
    return whole.resize((whole.width * _HEIGHT // whole.height, _HEIGHT))


def main() -> None:
    """Write the sheets."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--scenes", nargs="+", default=scene_names())
    parser.add_argument("--sizes", nargs="+", default=SIZES)
    parser.add_argument("--light", action="store_true", help="the page in light colours")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    with chromium() as browser:
        for name in options.scenes:
            file = options.folder / f"{name}-{'light' if options.light else 'dark'}.png"
            sheet(browser, name, tuple(options.sizes), not options.light).save(file)
            print(file, flush=True)


if __name__ == "__main__":
    main()

"""Take the pictures of README and documentation anew, from the running application.

    python -m tools.pictures [NAME ...]

Without a name: all of them. ``film`` is the moving one; see :mod:`tools.film`.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from PIL import Image
from playwright.sync_api import Browser

import abi
from abi.scene.scene import Scene, load_scene
from app.state.appearance import OPENING
from benchmarks.browser import chromium
from tools import film
from tools.visit import Visit, visit

FOLDER = Path(__file__).parents[1] / "docs" / "pictures"
WIDE = 1500
"""Width of a page whose middle is cut out, [px]."""

MARGIN = 60
"""Height cut off above and below, [px]."""

_SKY, _FOOT = 160, 125
"""The same of the heat map, which is small in the middle."""
_ABOVE, _BELOW = 225, 235
"""The same of the kitchen."""

BASE = ("workspace", "obstacles")
STAGES: dict[str, tuple[str, ...]] = {
    "stage-1-mesh": (*BASE, "edges", "nodes", "excluded"),
    "stage-2-graph": (*BASE, "edges", "nodes"),
    "stage-3-search": (*BASE, "names", "a_star", "dijkstra", "bellman_ford"),
    "stage-3-taut": (*BASE, "a_star", "taut"),
    "stage-4-bspline": (*BASE, "taut", "bspline", "control"),
    "stage-5-quadratic": (*BASE, "bspline", "quadratic"),
    "stage-6-arm": (*BASE, "bspline", "trace", "arm"),
}
SEARCHED = 100  # percent of the search that its picture shows
UNDERWAY = 0.62  # of the motion: where the arm is
PAGES: dict[str, tuple[str, str | None]] = {
    "page": (OPENING, None),
    "page-two-boxes": ("two-boxes", None),
    "page-scene-tab": ("forest", "Scene"),
    "page-plots-tab": ("wall-with-window", "Plots"),
    "page-no-way": ("no-way", None),
}
"""Scene and tab of the pictures that show the whole page."""
BASES = "find-a-base"
"""The picture of the bases that were tried, and its scene."""
SHADOW = "arm-shadow"
"""The picture of the positions that the arm forbids the tool."""
SHADOWED = "two-boxes"


class Pair(NamedTuple):
    """Two pictures of one scene side by side: the tool's own plan, and one for the whole arm.

    Attributes:
        position, look_at: of the camera, [unit], world.
        part: of the motion (0 to 1): where the arm is.
        above, below: what is cut off there, [px].
    """

    position: tuple[float, float, float]
    look_at: tuple[float, float, float]
    part: float
    above: int
    below: int


PAIRS: dict[str, Pair] = {
    "kitchen-ur5e": Pair((1.7, -1.1, 1.15), (0.0, 0.3, 0.3), 0.5, _ABOVE, _BELOW),
    "arm-in-the-way": Pair((-9.0, -6.5, 7.5), (3.0, 1.5, 2.6), 0.5, 120, 120),
    "wrong-elbow": Pair((-12.5, -9.5, 8.0), (2.4, 0.8, 3.8), 0.5, 120, 120),
}
"""Pairs, by their scenes."""
ALL = (*STAGES, *PAGES, BASES, *PAIRS, SHADOW, "film")


def take(names: Sequence[str], browser: Browser) -> None:
    """Take these pictures, or all; each is written into :data:`FOLDER`."""
    wanted = names or ALL
    FOLDER.mkdir(exist_ok=True)
    if stages := [name for name in wanted if name in STAGES]:
        with visit(browser, stage_scene(), width=WIDE) as visited:
            _stand(visited)
            for name in stages:
                _keep(name, _stage(visited, name))
    for name in wanted:
        if name in PAGES:
            _keep(name, _page(browser, *PAGES[name]))
    if BASES in wanted:
        _keep(BASES, _bases(browser))
    for name in wanted:
        if name in PAIRS:
            _keep(name, _pair(browser, name, PAIRS[name]))
    if SHADOW in wanted:
        _keep(SHADOW, _shadow(browser))
    if "film" in wanted:
        film.write(film.shoot(browser), FOLDER / "film.webp")
        print("film", flush=True)


def stage_scene() -> Scene:
    """The scene that all stages are shown on, coarse enough to see single edges."""
    return load_scene("two-boxes").replace(mesh={"pitch": 0.75})


def _stand(visited: Visit) -> None:
    """Stand where both boxes and the way between them are seen."""
    visited.hide_overlay()
    visited.look((0.4, -5.6, 5.4), (3.0, 3.0, 2.6))
    visited.rest()


def _stage(visited: Visit, name: str) -> Image.Image:
    visited.show(*STAGES[name])
    visited.search(SEARCHED if name == "stage-3-search" else 0)
    if "arm" in STAGES[name]:
        visited.look((-6.4, -6.6, 6.4), (3.0, 0.7, 3.5))
        visited.time(UNDERWAY)
    scene = visited.picture(panels=False)
    return scene.crop((0, MARGIN, scene.width, scene.height - MARGIN))


def _page(browser: Browser, scene: str, tab: str | None) -> Image.Image:
    with visit(browser, scene) as visited:
        plan = visited.session.plan
        if plan is not None and plan.error is None:
            visited.time(UNDERWAY)
        else:
            visited.page.until(lambda: visited.session.frame.reason is not None, "the reason")
            visited.rest()
        if tab is not None:
            visited.page.click(tab)
            visited.rest()
        return visited.picture()


def _pair(browser: Browser, scene: str, pair: Pair) -> Image.Image:
    """The tool's own plan, and that for the whole arm."""
    taken = []
    for avoid in (False, True):
        with visit(browser, load_scene(scene).replace(arm={"avoid": avoid}), width=WIDE) as visited:
            visited.hide_overlay()
            visited.show(*BASE, "bspline", "trace", "arm")
            visited.look(pair.position, pair.look_at)
            visited.time(pair.part)
            taken.append(visited.picture(panels=False))
    half = taken[0].width // 2
    whole = Image.new("RGB", (2 * half, taken[0].height - pair.above - pair.below))
    for k, image in enumerate(taken):
        middle = image.crop((half // 2, pair.above, half // 2 + half, image.height - pair.below))
        whole.paste(middle, (k * half, 0))
    return whole


def _shadow(browser: Browser) -> Image.Image:
    """Places that the obstacles keep the tool from on account of the arm's links."""
    with visit(browser, SHADOWED, width=WIDE) as visited:
        visited.hide_overlay()
        visited.show(*BASE, "bspline", "arm", "shadow")
        visited.look((-6.4, -6.6, 6.4), (3.0, 0.7, 3.5))
        visited.time(UNDERWAY)
        scene = visited.picture(panels=False)
        return scene.crop((0, MARGIN, scene.width, scene.height - MARGIN))


def _bases(browser: Browser) -> Image.Image:
    """The heat map from above, with the arm at the best base."""
    with visit(browser, BASES, width=WIDE) as visited:
        session, panel = visited.session, visited.session.panels.stages.bases
        session.panels.layer_switches.boxes["nodes"].value = False
        panel.find.value = True
        visited.follow()
        visited.page.until(
            lambda: session.frame.bases is not None and session.frame.bases.is_done, "the bases"
        )
        panel.put.value = True
        visited.follow()
        visited.page.until(lambda: session.frame.plan.error is None, "a plan")
        panel.show_region.value = False
        visited.hide_overlay()
        visited.show(*BASE, "bspline", "arm", "bases")
        visited.look((14.0, -9.0, 19.0), (3.0, 4.0, 0.5))
        visited.time(UNDERWAY)
        scene = visited.picture(panels=False)
        return scene.crop((0, _SKY, scene.width, scene.height - _FOOT))


def _keep(name: str, image: Image.Image) -> None:
    image.save(FOLDER / f"{name}.webp", quality=88, method=6)
    print(name, flush=True)


def main() -> None:
    """Take the pictures that are named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "names",
        nargs="*",
        metavar="NAME",
        help=", ".join(ALL),
    )
    names = parser.parse_args().names
    if unknown := set(names) - set(ALL):
        parser.error(f"no picture {sorted(unknown)[0]!r}")
    abi.compile()
    with chromium() as browser:
        take(names, browser)


if __name__ == "__main__":
    main()

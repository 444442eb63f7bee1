"""Search for the arm's best base, in steps of one plan each: start, stop, and take the best."""

from __future__ import annotations

import html
from collections.abc import Iterator
from typing import Any

import viser

from abi.explain.base_map import BaseMap
from abi.explain.find_base import base_maps
from abi.scene.scene import Scene
from app.panels.stages.base_region import BaseRegion
from app.panels.widgets import Wake, pressed
from app.state.frame import Frame
from app.ui import style
from app.ui.numbers import format_length, format_lower_bound, format_setting, unbroken

_PORTION = 0.005
"""Seconds between two plans, in which other tabs and the hand have their turn."""
_REASONS = 4
_INTRO = "Tries the base at many places in a region and shows how long the curve is from each."


class FindBasePanel:
    """Folder of stage 6: region, progress, and what was found.

    Attributes:
        whose: of which legs the search is, as a part of a sentence; empty where there is one.
    """

    def __init__(self, client: viser.ClientHandle, scene: Scene, wake: Wake) -> None:
        gui = client.gui
        with gui.add_folder("Find a base", expand_by_default=False):
            gui.add_html(style.paragraph(_INTRO))
            self.region = BaseRegion(client, scene, wake)
            self.find = gui.add_button("Find a base", hint="Searches the region while you go on.")
            self.progress = gui.add_progress_bar(0.0, visible=False)
            self.put = gui.add_button(
                "Put the arm here", hint="Moves the base to the best place found.", visible=False
            )
            self._text = gui.add_html("", visible=False)
        self.find.on_click(wake)
        self.put.on_click(wake)
        self._maps: Iterator[BaseMap] | None = None
        self._found: BaseMap | None = None
        self._asked = False
        self.whose = ""
        self._showed = False  # whether the region is shown only for the search
        self._drawn: tuple[object, ...] = ()

    @property
    def running(self) -> bool:
        """Whether there is another place to try."""
        return self._asked or self._maps is not None

    def timeout(self) -> float | None:
        """Time until the next portion, [s]; None while none is due."""
        return _PORTION if self.running else None

    def read(self) -> dict[str, Any]:
        """Take the region and the buttons; no section of the scene.

        Raises:
            SceneError: the region is none.
        """
        if pressed(self.find):
            self._asked = not self.running
            self._maps = None
        self.region.read()
        return {}

    def write(self, scene: Scene) -> None:
        """Show the region for ``scene``."""
        self.region.write(scene)

    def accepted_change(self) -> dict[str, Any] | None:
        """The base whose button was pressed since the last call, as a change of the scene."""
        best = None if self._found is None else self._found.best
        if not pressed(self.put) or best is None:
            return None
        return {"arm": {"base": list(best.base)}}

    def step(self, scene: Scene, leg: int | None = None) -> None:
        """Plan with the base at one more place.

        Args:
            scene: the scene.
            leg: number of the leg, from 0, where it is one; the first is the scene with all legs.
        """
        if self._asked:
            self._asked = False
            count = len(scene.tasks)
            self.whose = f" for leg {leg + 1} alone" if leg else ""
            self.whose = f" for all {count} legs" if count > 1 else self.whose
            self._showed |= not self.region.shown.value
            self.region.shown.value = True
            self._maps = base_maps(scene, *self.region.corners)
        if self._maps is not None:
            self._found = next(self._maps, self._found)
            if self._found is None or self._found.is_done:
                self._maps = None

    def found(self, scene: Scene) -> BaseMap | None:
        """Findings for ``scene``, wherever its base; forgotten once all else is another."""
        found = self._found
        if found is None or scene is found.scene or _with_base(scene, found) == found.scene:
            return found
        self._found = self._maps = None
        if self._showed:
            self._showed = self.region.shown.value = False
        return None

    def draw(self, frame: Frame) -> None:
        """Show region, progress and result."""
        self.region.draw()
        state = frame.bases, self.running
        if state == self._drawn:
            return
        self._drawn = state
        found = frame.bases
        self.find.label = "Stop" if self.running else "Find a base"
        self.progress.visible = self.running
        self._text.visible = found is not None
        best = None if found is None else found.best
        self.put.visible = best is not None
        if found is not None:
            done, of = found.planned
            self.progress.value = min(100.0, 100 * done / of)
            self._text.content = unbroken(style.paragraph(_result(found, self.whose)))


def _with_base(scene: Scene, found: BaseMap) -> Scene:
    """Scene whose arm stands where it stood when the search for a base began."""
    arm = scene.arm.model_copy(update={"base": found.scene.arm.base})
    return scene.model_copy(update={"arm": arm})


def _result(found: BaseMap, whose: str) -> str:
    """Findings as HTML."""
    if found.fault:
        return f"No base helps{whose}: {html.escape(found.fault)}"
    unit, best, lengths = found.scene.unit, found.best, found.lengths
    reasons = list(found.faults.items())[:_REASONS]
    counted = ", ".join(f"{count} × {html.escape(reason)}" for reason, count in reasons)
    without = f" Grey places have none: {counted}." if counted else ""
    tried = len(found.trials)
    if best is None or best.length is None or lengths is None:
        so_far = "" if found.is_done else " so far"
        return f"None of {tried} places{so_far} has a certified plan{whose}.{without}"
    place = ", ".join(format_setting(round(number, 4)) for number in best.base)
    clear = ""
    if best.clearance < float("inf"):
        clear = f", its links {format_lower_bound(best.clearance)} {unit} clear"
    count = tried - sum(found.faults.values())
    return (
        f"<b>Shortest{whose}: {format_length(best.length)} {unit}</b> with the base at "
        f"({place}){clear}. {count} of {tried} places have a certified plan."
        f"{without}{_scale(*lengths, unit)}"
    )


def _scale(least: float, most: float, unit: str) -> str:
    """The colours and their lengths, as HTML."""
    if most - least < 1e-9 * most:
        return ""
    stops = ",".join(style.css(colour) for colour in style.HEAT)
    return (
        '<div style="display:flex;gap:6px;align-items:center;margin-top:4px">'
        f"{format_length(least)}"
        f'<span style="flex:1;height:8px;background:linear-gradient(90deg,{stops})"></span>'
        f"{format_length(most)} {unit}</div>"
    )

"""The legend: a switch in its colour for each layer, the mesh's view, dark or light page."""

from __future__ import annotations

from collections.abc import Iterable

import viser

from app.panels.widgets import Wake, pressed
from app.state.frame import Frame
from app.state.legend import SHOWN, SWITCHES, Switch
from app.ui import page, style
from app.ui.layout import Layout

MESH_VIEWS = {
    "near path and obstacles": "near",
    "slice across x": "slice_x",
    "slice across y": "slice_y",
    "slice across z": "slice_z",
    "surface": "surface",
}


class LayerSwitches:
    """Checkboxes of the legend, and how mesh and page are shown."""

    def __init__(self, layout: Layout, wake: Wake, dark: bool) -> None:
        self._gui = gui = layout.client.gui
        with layout.layers:
            self.dark = gui.add_checkbox("dark page", dark)
            self.mesh_view = gui.add_dropdown(
                "part of the mesh",
                tuple(MESH_VIEWS),
                hint="Grids above 4,000 nodes are shown only in part: near path and "
                "obstacles, or as chosen here.",
            )
            self.usual = gui.add_button(
                "Usual layers",
                hint="Shows the layers of a new tab, such as after a figure or a lesson.",
            )
            self.boxes = {
                switch.name: gui.add_checkbox(switch.label, switch.on, hint=switch.hint)
                for switch in SWITCHES
            }
            gui.add_html(_swatch_style(zip(self.boxes.values(), SWITCHES, strict=True)))
        self.usual.on_click(wake)
        for box in (self.dark, *self.boxes.values()):
            box.on_update(wake)
        self.mesh_view.on_update(wake)
        self._dark = dark
        self._configure_theme()

    def restore(self, shown: frozenset[str] | None, dark: bool | None) -> None:
        """Set the switches as they were, where that is known."""
        if shown is not None:
            for name, box in self.boxes.items():
                box.value = name in shown
        if dark is not None:
            self.dark.value = dark

    def shown(self) -> frozenset[str]:
        """Names of the switches that are on; the usual ones where they were asked for."""
        if pressed(self.usual):
            self.restore(SHOWN, None)
        return frozenset(name for name, box in self.boxes.items() if box.value)

    def chosen_mesh_view(self) -> str:
        """Part of the mesh to draw, of :data:`abi.search.subset.VIEWS`."""
        return MESH_VIEWS.get(self.mesh_view.value, "near")

    def draw(self, frame: Frame) -> None:
        """Darken or light the page; no frame changes it."""
        if bool(self.dark.value) != self._dark:
            self._dark = bool(self.dark.value)
            self._configure_theme()

    def _configure_theme(self) -> None:
        self._gui.configure_theme(dark_mode=self._dark, show_logo=False, show_share_button=False)


def _swatch_style(boxes: Iterable[tuple[viser.GuiCheckboxHandle, Switch]]) -> str:
    """Style sheet that puts a line as in the scene, if any, before each checkbox's label."""
    rules = [
        f'label[for="{page.uuid(handle)}"]::before{{content:"";display:inline-block;width:14px;'
        f"height:4px;margin-right:7px;vertical-align:middle;background:{_filling(switch)}}}"
        for handle, switch in boxes
    ]
    return f"<style>{''.join(rules)}</style>"


def _filling(switch: Switch) -> str:
    colour = switch.colour
    return "transparent" if colour is None else style.filling(colour, switch.name)

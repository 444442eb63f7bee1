"""The legend: a switch for all that is drawn, in its colour; part of the mesh; dark or light."""

from __future__ import annotations

from app import page
from app.frame import Frame, Switch
from app.layout import Layout
from app.panels.widgets import Wake

MESH_VIEWS = {
    "near path and obstacles": "near",
    "slice across x": "slice_x",
    "slice across y": "slice_y",
    "slice across z": "slice_z",
    "surface": "surface",
}


class LayerSwitches:
    """The legend and the switches in one."""

    def __init__(
        self, layout: Layout, switches: tuple[Switch, ...], wake: Wake, dark: bool
    ) -> None:
        self._gui = gui = layout.client.gui
        with layout.layers:
            self.dark = gui.add_checkbox("dark page", dark)
            self.mesh_view = gui.add_dropdown(
                "mesh shown",
                tuple(MESH_VIEWS),
                hint="A mesh of up to about 4,000 nodes is shown whole by the first of these.",
            )
            self.boxes = {one.name: gui.add_checkbox(one.label, one.on) for one in switches}
            gui.add_html(page.swatch_style((self.boxes[one.name], one.colour) for one in switches))
        for box in (self.dark, *self.boxes.values()):
            box.on_update(wake)
        self.mesh_view.on_update(wake)
        self._dark = dark
        self._theme()

    def shown(self) -> frozenset[str]:
        """Names of the switches that are on."""
        return frozenset(name for name, handle in self.boxes.items() if handle.value)

    def mesh_part(self) -> str:
        """Which part of the mesh to draw, of :data:`abi.search.subset.VIEWS`."""
        return MESH_VIEWS.get(self.mesh_view.value, "near")

    def draw(self, frame: Frame) -> None:
        """Darken or light the page, whatever is in the frame."""
        if bool(self.dark.value) != self._dark:
            self._dark = bool(self.dark.value)
            self._theme()

    def _theme(self) -> None:
        self._gui.configure_theme(dark_mode=self._dark, show_logo=False, show_share_button=False)

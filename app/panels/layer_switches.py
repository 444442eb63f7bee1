"""What is shown: a switch a layer, with the layer's colour, and dark or light."""

from __future__ import annotations

import viser

from app import page, style
from app.panels.widgets import Wake

LAYERS: dict[str, tuple[str, style.Colour, bool]] = {
    "workspace": ("workspace box", style.WORKSPACE, True),
    "edges": ("mesh edges", style.MESH, True),
    "nodes": ("mesh nodes", style.MESH, True),
    "excluded": ("excluded", style.EXCLUDED, True),
    "a_star": ("A*", style.A_STAR, True),
    "dijkstra": ("Dijkstra", style.DIJKSTRA, True),
    "bellman_ford": ("Bellman-Ford", style.BELLMAN_FORD, True),
    "taut": ("taut path", style.TAUT, True),
    "bspline": ("B-spline", style.BSPLINE, True),
    "control": ("control points", style.BSPLINE, True),
    "quadratic": ("quadratic", style.QUADRATIC, True),
    "obstacles": ("obstacles", style.OBSTACLE, True),
    "trace": ("tool trace", style.TRACE, True),
    "arm": ("arm", style.POINT, True),
}


MESH_VIEWS = {
    "near path and obstacles": "near",
    "slice across x": "slice_x",
    "slice across y": "slice_y",
    "slice across z": "slice_z",
    "surface": "surface",
}


class LayerSwitches:
    """The legend and the switches in one."""

    def __init__(self, client: viser.ClientHandle, wake: Wake, dark: bool) -> None:
        gui = client.gui
        self.dark = gui.add_checkbox("dark page", dark)
        self.dark.on_update(wake)
        self.mesh_view = gui.add_dropdown(
            "mesh shown",
            tuple(MESH_VIEWS),
            hint="A mesh of up to about 4,000 nodes is shown whole by the first of these.",
        )
        self.mesh_view.on_update(wake)
        self.switches = {
            name: gui.add_checkbox(label, shown) for name, (label, _, shown) in LAYERS.items()
        }
        colours = [(handle, LAYERS[name][1]) for name, handle in self.switches.items()]
        gui.add_html(page.swatch_style(colours))
        for handle in self.switches.values():
            handle.on_update(wake)

    def mesh_part(self) -> str:
        """Which part of the mesh to draw, of :data:`abi.tet_mesh.subset.VIEWS`."""
        return MESH_VIEWS.get(self.mesh_view.value, "near")

    def read(self) -> dict[str, bool]:
        """Which layers are to be seen."""
        return {name: bool(handle.value) for name, handle in self.switches.items()}

"""Layout of the page: panels, tabs and the stages' folders."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import viser

from app.ui import page, style
from app.ui.overlay import Overlay

TITLE = "ABI path planning"
PLOTS = "Plots"
LEARN = "Learn"


@dataclass(frozen=True, eq=False)
class Layout:
    """Containers that layers and panels fill.

    Attributes:
        client: the browser tab; ``client.scene`` lies between the panels.
        unit: of lengths in the tab's first scene.
        folders: of the stages, in the left panel.
        result: tab of the right panel, as are the others.
        search: the search step by step, and all of them compared.
        plots: plots of the motion.
        scene: files, and positions as numbers.
        layers: the legend.
        learn: lessons, the paper's figures, and its text.
        overlay: text and controls over the scene.
        right: the right panel.
    """

    client: viser.ClientHandle
    unit: str
    folders: Mapping[str, viser.GuiFolderHandle]
    result: viser.GuiTabHandle
    search: viser.GuiTabHandle
    plots: viser.GuiTabHandle
    scene: viser.GuiTabHandle
    layers: viser.GuiTabHandle
    learn: viser.GuiTabHandle
    overlay: Overlay
    right: viser.PanelHandle

    @classmethod
    def of(
        cls, client: viser.ClientHandle, unit: str, folders: Mapping[str, viser.GuiFolderHandle]
    ) -> Layout:
        """Dock the two panels and add the right one's tabs."""
        gui = client.gui
        gui.set_panel_label(TITLE)
        gui.main_panel.dock_left()
        gui.main_panel.set_width(style.LEFT_WIDTH)
        right = gui.add_panel()
        # who is new finds the lessons beside what is open at first
        names = ("Result", LEARN, "Search", PLOTS, "Scene", "Layers")
        tabs = [right.add_tab(name) for name in names]
        right.dock_right()
        right.set_width(style.RIGHT_WIDTH)
        result, learn, search, plots, scene, layers = tabs
        overlay = Overlay(client)
        return cls(
            client, unit, folders, result, search, plots, scene, layers, learn, overlay, right
        )

    def open_learn(self, _event: object) -> None:
        """Open the tab with the lessons, and the panel that it is in."""
        self.right.expand()
        page.call(self.client, "openTab", LEARN)

    @property
    def panels(self) -> tuple[viser.MainPanelHandle, viser.PanelHandle]:
        """The left and the right panel."""
        return self.client.gui.main_panel, self.right

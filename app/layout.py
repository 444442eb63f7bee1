"""Places on the page: which panel, which tab, which stage's folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import viser

from app import page, style


@dataclass(frozen=True, eq=False)
class Layout:
    """Where layers and panels put what they add to the page.

    Attributes:
        client: the tab; ``client.scene`` is what lies between the panels.
        unit: of lengths in the scene that the tab begins with.
        folders: of the stages, in the panel on the left.
        result: tab of the panel on the right, as the others.
        joints: plots of the joints.
        scene: files and what is placed by number.
        layers: the legend.
        paper: the lesson.
    """

    client: viser.ClientHandle
    unit: str
    folders: Mapping[str, viser.GuiFolderHandle]
    result: viser.GuiTabHandle
    joints: viser.GuiTabHandle
    scene: viser.GuiTabHandle
    layers: viser.GuiTabHandle
    paper: viser.GuiTabHandle

    @classmethod
    def of(
        cls, client: viser.ClientHandle, unit: str, folders: Mapping[str, viser.GuiFolderHandle]
    ) -> Layout:
        """Dock the two panels and name the tabs of the right one."""
        gui = client.gui
        page.set_title(client, "ABI visualiser")
        gui.set_panel_label("ABI path planner")
        gui.main_panel.dock_left()
        gui.main_panel.set_width(style.LEFT_WIDTH)
        right = gui.add_panel()
        names = ("Result", "Joints", "Scene", "Layers", "Paper")
        tabs = [right.add_tab(name) for name in names]
        right.dock_right()
        right.set_width(style.RIGHT_WIDTH)
        return cls(client, unit, folders, *tabs)

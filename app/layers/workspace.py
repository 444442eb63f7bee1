"""The workspace box and the ground."""

from __future__ import annotations

import itertools

import numpy as np
import viser

from abi.scene.scene import Workspace
from app import style

_CORNERS = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
_EDGES = [(a, b) for a, b in itertools.combinations(range(8), 2) if bin(a ^ b).count("1") == 1]


class WorkspaceLayer:
    """Draws the box that is meshed."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._box = client.scene.add_line_segments(
            "/workspace",
            np.zeros((12, 2, 3)),
            style.WORKSPACE,
            thickness=1.5,
            thickness_units="screen",
        )
        self._grid: viser.GridHandle | None = None
        self._drawn: tuple[Workspace, float] | None = None

    def draw(self, workspace: Workspace, base: tuple[float, float, float]) -> None:
        """Draw the box, and a faint ground below it and the arm's base."""
        if (workspace, base[2]) == self._drawn:
            return
        self._drawn = workspace, base[2]
        corners = np.array(workspace.min) + _CORNERS * workspace.size
        self._box.points = corners[_EDGES].astype(np.float32)
        longest = max(workspace.size)
        centre = np.add(workspace.min, workspace.max) / 2
        ground = min(workspace.min[2], base[2]) - 0.002 * longest
        self._grid = self._client.scene.add_grid(
            "/ground",
            width=4 * longest,
            height=4 * longest,
            cell_size=longest / 6,
            section_size=longest,
            cell_color=style.WORKSPACE,
            section_color=style.WORKSPACE,
            cell_thickness=0.6,
            section_thickness=1.0,
            fade_distance=3.2 * longest,
            fade_strength=1.5,
            fade_from="origin",
            shadow_opacity=0.1,
            position=(centre[0], centre[1], ground),
        )

    def show(self, visible: bool) -> None:
        """Switch the layer."""
        self._box.visible = visible

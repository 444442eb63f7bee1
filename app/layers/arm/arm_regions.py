"""Two regions: where the tool may not go because of the arm, and where it can reach at all."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.planner.plan import Plan
from app.layers.arm.kinds import kind_of
from app.state.frame import Frame, Layer, Switch
from app.ui import style
from app.ui.layout import Layout

_SENTENCES = (
    "The arm's shadow, in red: with the tool tip there, a link would be inside an obstacle. The "
    "arm's reach, in blue: where the tool tip can be within the limits of the joints."
)
_COLOURS = {"shadow": style.VIOLATION, "reach": style.A_STAR}
_OPACITY = {"shadow": 0.28, "reach": 0.1}
_NOTHING = np.zeros((1, 3, 3))


class ArmRegionsLayer(Layer):
    """The arm's shadow, which follows the obstacles, and its reach."""

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch("shadow", "arm's shadow", style.VIOLATION, on=False),
        Switch("reach", "arm's reach", style.A_STAR, on=False),
    )

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        self._meshes: dict[str, viser.MeshHandle] = {}
        self._drawn: dict[str, tuple[object, ...]] = {}
        with layout.layers:
            layout.client.gui.add_html(style.paragraph(_SENTENCES))

    def draw(self, frame: Frame) -> None:
        """Draw what is switched on, anew where obstacles or arm have changed."""
        for name in _COLOURS:
            seen = name in frame.shown and self._update(name, frame.plan, frame.interactive)
            if name in self._meshes:
                self._meshes[name].visible = seen

    def _update(self, name: str, plan: Plan, interactive: bool) -> bool:
        """Draw a region; whether there is one, as where the arm reaches the start.

        Those that take longer than a frame where the start is another change little: while that is
        dragged they stay as they are.
        """
        scene, arm = plan.scene, plan.arm
        if arm is None:
            return False
        kind = kind_of(arm)
        start = kind.region_start(plan, arm)
        if start is None:
            return False
        obstacles = scene.obstacles if name == "shadow" else None
        state = (start, scene.arm, scene.workspace, scene.unit, obstacles)
        drawn = self._drawn.get(name, ())
        if drawn == state:
            return True
        if interactive and kind.SLOW_REGIONS and drawn[1:] == state[1:]:
            return True
        self._drawn[name] = state
        self._show(name, kind.region(name, plan, arm))
        return True

    def _show(self, name: str, triangles: FloatArray) -> None:
        corners = (triangles if len(triangles) else _NOTHING).reshape(-1, 3).astype(np.float32)
        vertices, faces = np.unique(corners, axis=0, return_inverse=True)
        self._meshes[name] = self._scene.add_mesh_simple(
            f"/arm_region/{name}",
            vertices,
            faces.reshape(-1, 3).astype(np.uint32),
            color=_COLOURS[name],
            opacity=_OPACITY[name],
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

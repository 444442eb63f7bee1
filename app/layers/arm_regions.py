"""Two regions: where the tool may not go because of the arm, and where it can reach at all."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import viser

from abi.arm.arm import Arm
from abi.arm.regions import reachable, shadow
from abi.arm.surroundings import surroundings
from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.plan import Plan
from app import style
from app.frame import Frame, Switch
from app.layers.arm_ghosts import elbow_of
from app.layout import Layout

_SENTENCES = (
    "The arm's shadow, in red: with the tool in there, a link would be inside an obstacle. The "
    "arm's reach, in blue: all that the tool can reach within the limits of shoulder and elbow."
)
_COLOURS = {"shadow": style.VIOLATION, "reach": style.A_STAR}
_OPACITY = {"shadow": 0.28, "reach": 0.1}
_NOTHING = np.zeros((1, 3, 3))


class ArmRegionsLayer:
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
            layout.client.gui.add_html(f"{style.BOX}{_SENTENCES}</div>")

    def draw(self, frame: Frame) -> None:
        """Draw what is switched on, anew where obstacles or arm have changed."""
        plan = frame.plan
        for name in _COLOURS:
            shown = name in frame.shown and isinstance(plan.arm, Arm)
            if shown and isinstance(plan.arm, Arm):
                self._update(name, plan, plan.arm)
            if name in self._meshes:
                self._meshes[name].visible = shown

    def _update(self, name: str, plan: Plan, arm: Arm) -> None:
        scene, elbow = plan.scene, elbow_of(plan)
        state: tuple[object, ...] = (scene.arm, elbow, scene.workspace, scene.unit)
        if name == "shadow":
            state = (*state, scene.obstacles)
        if self._drawn.get(name) == state:
            return
        self._drawn[name] = state
        lowest, box = scene.workspace.min[2], (scene.workspace.min, scene.workspace.max)
        if name == "shadow":
            around = surroundings(arm, ObstacleSet(scene.obstacles), lowest)
            triangles = shadow(arm, elbow, scene.arm.q5, around, box)
        else:
            floor = min(lowest, scene.arm.base[2])
            triangles = reachable(arm, elbow, scene.arm.q5, floor)
        self._show(name, triangles)

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

"""Two regions: where the tool may not go because of the arm, and where it can reach at all."""

from __future__ import annotations

import functools
from typing import ClassVar

import numpy as np
import viser

from abi.arm_planning.exclusion.chain_regions import (
    chain_reach,
    chain_shadow,
    configurations_in,
    reach_box,
)
from abi.arm_planning.exclusion.node_configurations import NodeConfigurations
from abi.arm_planning.exclusion.paper_arm_regions import reachable, shadow
from abi.arm_planning.world.collision_world import chain_world, paper_arm_world
from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import Vec3
from abi.planner.plan import Plan
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.robot.urdf_arm import UrdfArm
from app.layers.arm.arm_ghosts import elbow_of
from app.layers.arm.urdf_poses import end_pose
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

        Those of a URDF arm take longer than a frame where the start is another, and change little:
        while a hand drags that they stay as they are.
        """
        scene, arm = plan.scene, plan.arm
        start = _start_of(plan)
        if arm is None or start is None:
            return False
        obstacles = scene.obstacles if name == "shadow" else None
        state = (start, scene.arm, scene.workspace, scene.unit, obstacles)
        drawn = self._drawn.get(name, ())
        if drawn == state:
            return True
        if interactive and isinstance(arm, UrdfArm) and drawn[1:] == state[1:]:
            return True
        self._drawn[name] = state
        if isinstance(arm, PaperArm):
            self._show(name, _paper_region(name, plan, arm))
        elif isinstance(arm, UrdfArm):
            self._show(name, _chain_region(name, plan, arm))
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


def _start_of(plan: Plan) -> object:
    """Values that an arm's poses depend on beside its settings; None where it reaches no start."""
    if not isinstance(plan.arm, UrdfArm):
        return elbow_of(plan)
    pose = end_pose(plan, plan.arm, "start")
    return None if pose is None else (plan.scene.start, *np.round(pose, 6).tolist())


def _paper_region(name: str, plan: Plan, arm: PaperArm) -> FloatArray:
    """Triangles (n, 3, 3) of a region of the paper's arm, [unit], world."""
    scene, elbow = plan.scene, elbow_of(plan)
    lowest, box = scene.workspace.min[2], (scene.workspace.min, scene.workspace.max)
    if name == "shadow":
        obstacles = paper_arm_world(arm, ObstacleSet(scene.obstacles), lowest)
        return shadow(arm, elbow, scene.arm.q5, obstacles, box)
    floor = min(lowest, scene.arm.base[2])
    return reachable(arm, elbow, scene.arm.q5, floor)


def _chain_region(name: str, plan: Plan, arm: UrdfArm) -> FloatArray:
    """Triangles of a region of a URDF arm."""
    scene, first = plan.scene, end_pose(plan, arm, "start")
    assert first is not None
    lowest = scene.workspace.min[2]
    if name == "reach":
        box = reach_box(arm, min(lowest, scene.arm.base[2]))
    else:
        box = scene.workspace.min, scene.workspace.max
    configurations = _configurations(arm, tuple(np.round(first, 6).tolist()), scene.start, box)
    if name == "reach":
        return chain_reach(configurations)
    return chain_shadow(arm, configurations, chain_world(arm, ObstacleSet(scene.obstacles), lowest))


@functools.lru_cache(8)
def _configurations(
    arm: UrdfArm, first: tuple[float, ...], start: Vec3, box: tuple[Vec3, Vec3]
) -> NodeConfigurations:
    """Configurations in a box, which stay while obstacles are dragged."""
    return configurations_in(arm, np.array(first), np.array(start, dtype=float), box)

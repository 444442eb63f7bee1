"""Two regions: where the tool may not go because of the arm, and where it can reach at all."""

from __future__ import annotations

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.planner.plan import Plan
from app.layers.arm.kinds import kind_of
from app.state.frame import Draw, Frame
from app.ui import style
from app.ui.layout import Layout

_SENTENCES = (
    "The arm's shadow, in red: with the tool tip there, a link would be inside an obstacle. The "
    "arm's reach, in blue: where the tool tip can be within the limits of the joints."
)
_COLOURS = {"shadow": style.VIOLATION, "reach": style.A_STAR}
_OPACITY = {"shadow": 0.28, "reach": 0.1}
_NOTHING = np.zeros((1, 3, 3))


def arm_regions_layer(layout: Layout) -> Draw:
    """The arm's shadow, which follows the obstacles, and its reach."""
    scene = layout.client.scene
    meshes: dict[str, viser.MeshHandle] = {}
    drawn: dict[str, tuple[object, ...]] = {}
    with layout.layers:
        layout.client.gui.add_html(style.paragraph(_SENTENCES))

    def draw(frame: Frame) -> None:
        for name in _COLOURS:
            state = _state(name, frame.plan) if name in frame.shown else None
            if state is not None and not _stays(drawn.get(name, ()), state, frame):
                assert frame.plan.arm is not None
                drawn[name] = state
                triangles = kind_of(frame.plan.arm).region(name, frame.plan, frame.plan.arm)
                meshes[name] = _add_region(scene, name, triangles)
            if name in meshes:
                meshes[name].visible = state is not None

    return draw


def _state(name: str, plan: Plan) -> tuple[object, ...] | None:
    """What a region depends on; None where there is none, as where the start is out of reach."""
    scene, arm = plan.scene, plan.arm
    start = None if arm is None else kind_of(arm).region_start(plan, arm)
    if start is None:
        return None
    obstacles = scene.obstacles if name == "shadow" else None
    return start, scene.arm, scene.workspace, scene.unit, obstacles


def _stays(drawn: tuple[object, ...], state: tuple[object, ...], frame: Frame) -> bool:
    """Check whether a region stays as it was drawn.

    Those that take longer than a frame where the start is another change little: while that is
    dragged they stay.
    """
    assert frame.plan.arm is not None
    slow = frame.interactive and kind_of(frame.plan.arm).SLOW_REGIONS
    return drawn[1:] == state[1:] if slow else drawn == state


def _add_region(scene: viser.SceneApi, name: str, triangles: FloatArray) -> viser.MeshHandle:
    corners = (triangles if len(triangles) else _NOTHING).reshape(-1, 3).astype(np.float32)
    vertices, faces = np.unique(corners, axis=0, return_inverse=True)
    return scene.add_mesh_simple(
        f"/arm_region/{name}",
        vertices,
        faces.reshape(-1, 3).astype(np.uint32),
        color=_COLOURS[name],
        opacity=_OPACITY[name],
        side="double",
        cast_shadow=False,
        receive_shadow=False,
    )

"""What is placed by hand in the scene: obstacles, start and goal, each under a gizmo.

The body is a child of its gizmo, so it moves in the browser at once; the server hears the pose.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh
import viser

from abi.scene import Scene
from abi.shapes import Box, Cylinder, Obstacle, Sphere
from app import style
from app.panels.stages import Wake

_OPACITY = 0.62


class ObstaclesPanel:
    """One gizmo an obstacle; only the chosen one shows its handles."""

    def __init__(self, client: viser.ClientHandle, scene: Scene, wake: Wake) -> None:
        self._scene = client.scene
        self._wake = wake
        self._shapes: tuple[Obstacle, ...] = ()
        self._gizmos: list[viser.TransformControlsHandle] = []
        self._bodies: list[viser.MeshHandle] = []
        self.chosen = 0
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """The ``obstacles`` list, at the poses of the gizmos."""
        return {
            "obstacles": [
                {
                    **shape.model_dump(mode="json"),
                    "position": [float(number) for number in gizmo.position],
                    "wxyz": [float(number) for number in gizmo.wxyz],
                }
                for shape, gizmo in zip(self._shapes, self._gizmos, strict=True)
            ]
        }

    def write(self, scene: Scene) -> None:
        """Show ``scene``; gizmos are kept where the shapes are the same."""
        for gizmo in self._gizmos:
            gizmo.remove()
        self._shapes = scene.obstacles
        size = max(scene.workspace.size)
        self._gizmos, self._bodies = [], []
        for number, shape in enumerate(scene.obstacles):
            name = f"/obstacle_{number + 1}"
            gizmo = self._scene.add_transform_controls(
                name,
                scale=1.35 * _radius(shape) + 0.03 * size,
                line_width=2.5,
                position=shape.position,
                wxyz=shape.wxyz,
                depth_test=False,
                opacity=0.9,
            )
            gizmo.on_update(self._wake)
            mesh = _mesh(shape)
            body = self._scene.add_mesh_simple(
                f"{name}/body",
                mesh.vertices.astype(np.float32),
                mesh.faces.astype(np.uint32),
                color=style.OBSTACLE,
                opacity=_OPACITY,
                flat_shading=isinstance(shape, Box),
                side="double",
            )
            body.on_click(self._clicked)
            self._gizmos.append(gizmo)
            self._bodies.append(body)
        self.choose(0)

    def choose(self, number: int) -> None:
        """Give the handles to obstacle ``number``, counted from 0."""
        self.chosen = number
        for index, gizmo in enumerate(self._gizmos):
            idle = index != number
            gizmo.disable_axes = gizmo.disable_sliders = gizmo.disable_rotations = idle

    def show(self, visible: bool) -> None:
        """Switch the obstacles, with their gizmos."""
        for gizmo in self._gizmos:
            gizmo.visible = visible

    async def _clicked(self, event: viser.SceneNodePointerEvent[Any]) -> None:
        self.choose(self._bodies.index(event.target))


class PointsPanel:
    """Start and goal: a ball under a gizmo without rotations, and a label with coordinates."""

    def __init__(self, client: viser.ClientHandle, scene: Scene, wake: Wake) -> None:
        self._scene = client.scene
        size = max(scene.workspace.size)
        self._gizmos: dict[str, viser.TransformControlsHandle] = {}
        self._labels: dict[str, viser.LabelHandle] = {}
        for name in ("start", "goal"):
            gizmo = client.scene.add_transform_controls(
                f"/{name}",
                scale=0.13 * size,
                line_width=3.0,
                disable_rotations=True,
                disable_sliders=True,
                depth_test=False,
                opacity=0.9,
            )
            client.scene.add_icosphere(f"/{name}/ball", radius=0.018 * size, color=style.POINT)
            self._labels[name] = client.scene.add_label(
                f"/{name}/label", name, anchor="top-center", position=(0, 0, -0.05 * size)
            )
            gizmo.on_update(wake)
            self._gizmos[name] = gizmo
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """``start`` and ``goal``."""
        return {
            name: [float(number) for number in gizmo.position]
            for name, gizmo in self._gizmos.items()
        }

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        limits = tuple(zip(scene.workspace.min, scene.workspace.max, strict=True))
        for name, gizmo in self._gizmos.items():
            gizmo.translation_limits = limits  # type: ignore[assignment]
            gizmo.position = getattr(scene, name)
        self.label(scene)

    def label(self, scene: Scene) -> None:
        """Write the coordinates on the labels."""
        for name, label in self._labels.items():
            label.text = f"{name} ({', '.join(f'{number:.3g}' for number in getattr(scene, name))})"


def _radius(shape: Obstacle) -> float:
    low, high = shape.bounds()
    return float(np.linalg.norm(high - low) / 2)


def _mesh(shape: Obstacle) -> trimesh.Trimesh:
    """The surface, in the obstacle's own frame."""
    mesh: trimesh.Trimesh
    if isinstance(shape, Box):
        mesh = trimesh.creation.box(extents=shape.size)
    elif isinstance(shape, Sphere):
        mesh = trimesh.creation.icosphere(subdivisions=3, radius=shape.radius)
    elif isinstance(shape, Cylinder):
        mesh = trimesh.creation.cylinder(radius=shape.radius, height=shape.height, sections=48)
    else:
        mesh = trimesh.creation.capsule(radius=shape.radius, height=shape.height, count=(24, 24))
        mesh.apply_translation((0, 0, -mesh.bounds.mean(axis=0)[2]))
    return mesh

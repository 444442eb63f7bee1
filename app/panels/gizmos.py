"""What is placed by hand in the scene: obstacles, start and goal, each under a gizmo.

The body is a child of its gizmo, so it moves in the browser at once; the server hears the pose.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.obstacles.primitives import Box, Cylinder, MeshShape, Obstacle, Sphere
from abi.scene.scene import Scene
from app import style
from app.frame import Frame, Switch
from app.panels.widgets import Wake

_Body = viser.BoxHandle | viser.IcosphereHandle | viser.MeshHandle

_OPACITY = 0.62
_FACETS = 8
_POSE = {"position", "wxyz"}
_ROUNDING = 1e-9


class ObstacleGizmos:
    """One gizmo an obstacle; only the chosen one shows its handles.

    Attributes:
        data: each obstacle as a scene file has it, without its pose; the editor changes it.
        chosen: which one has the handles, counted from 0.
    """

    switches: ClassVar[tuple[Switch, ...]] = (Switch("obstacles", "obstacles", style.OBSTACLE),)

    def __init__(self, client: viser.ClientHandle, scene: Scene, wake: Wake) -> None:
        self._scene = client.scene
        self._wake = wake
        self._size = 1.0
        self.data: list[dict[str, Any]] = []
        self.gizmos: list[viser.TransformControlsHandle] = []
        self._bodies: list[_Body] = []
        self._drawn: list[dict[str, Any]] = []
        self._added = 0
        self._visible = True
        self._placed: Sequence[Obstacle] | None = None
        self._said: list[dict[str, Any]] = []
        self._checked: list[tuple[dict[str, Any], Obstacle]] = []
        self._handled = -1
        self.chosen = 0
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """The ``obstacles`` list, at the poses of the gizmos; what stayed is the scene's own."""
        self._said = list(map(_placed, self.data, self.gizmos))
        pairs = zip(self._said, self._checked, strict=True)
        return {"obstacles": [shape if said == before else said for said, (before, shape) in pairs]}

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        while self.gizmos:
            self.remove(0)
        self._size = max(scene.workspace.size)
        for shape in scene.obstacles:
            self.add(shape)
        self._said = [said for said, _ in self._checked]
        self._give_bodies(scene.obstacles)
        self.choose(0)

    def draw(self, frame: Frame) -> None:
        """Give each gizmo the body of its obstacle, and show or hide all of them."""
        if (visible := "obstacles" in frame.shown) != self._visible:
            self._visible = visible
            for gizmo in self.gizmos:
                gizmo.visible = visible
        if not frame.faded and frame.plan.scene.obstacles is not self._placed:
            self._give_bodies(frame.plan.scene.obstacles)
            self._checked = list(zip(self._said, frame.plan.scene.obstacles, strict=True))

    def _give_bodies(self, obstacles: Sequence[Obstacle]) -> None:
        """Draw bodies anew where a gizmo's obstacle has another shape or size now."""
        self._placed = obstacles
        for number, shape in enumerate(obstacles):
            if self._drawn[number] == self.data[number]:
                continue
            self._drawn[number] = dict(self.data[number])
            gizmo = self.gizmos[number]
            gizmo.scale = min(1.35 * _radius(shape), 0.4 * self._size) + 0.03 * self._size
            self._bodies[number] = body = _body(self._scene, f"{gizmo.name}/body", shape)
            body.on_click(self._clicked)

    def add(self, shape: Obstacle) -> None:
        """Put one more obstacle into the scene; the next frame gives it its body."""
        self._added += 1
        gizmo = self._scene.add_transform_controls(
            f"/obstacle_{self._added}",
            scale=self._size,
            line_width=2.5,
            position=shape.position,
            wxyz=shape.wxyz,
            depth_test=False,
            opacity=0.9,
            visible=self._visible,
        )
        gizmo.on_update(self._wake)
        self.gizmos.append(gizmo)
        self.data.append(shape.model_dump(mode="json", exclude=_POSE))
        self._checked.append((_placed(self.data[-1], gizmo), shape))
        self._drawn.append({})
        self._bodies.append(None)  # type: ignore[arg-type]
        self._placed = None
        self._handled = -1

    def remove(self, number: int) -> None:
        """Take obstacle ``number`` away."""
        self.gizmos.pop(number).remove()
        for kept in (self.data, self._drawn, self._bodies, self._checked):
            kept.pop(number)
        self._handled = -1

    def choose(self, number: int) -> None:
        """Give the handles to obstacle ``number``, counted from 0."""
        self.chosen = number
        if number == self._handled:
            return
        self._handled = number
        for index, gizmo in enumerate(self.gizmos):
            idle = index != number
            gizmo.disable_axes = gizmo.disable_sliders = gizmo.disable_rotations = idle

    def _clicked(self, event: viser.SceneNodePointerEvent[Any]) -> None:
        self.chosen = next(i for i, body in enumerate(self._bodies) if body is event.target)
        self._wake(event)


class EndGizmos:
    """Start and goal: a ball under a gizmo without rotations, and a label with coordinates.

    Attributes:
        gizmos: by name; who moves one from here does so with :meth:`place`.
    """

    def __init__(self, client: viser.ClientHandle, scene: Scene, wake: Wake) -> None:
        self._scene = client.scene
        size = max(scene.workspace.size)
        self.gizmos: dict[str, viser.TransformControlsHandle] = {}
        self._labels: dict[str, viser.LabelHandle] = {}
        self._balls: dict[str, viser.IcosphereHandle] = {}
        self._origins: dict[str, FloatArray] = {}
        for name in ("start", "goal"):
            place = np.array(getattr(scene, name))
            gizmo = client.scene.add_transform_controls(
                f"/{name}",
                position=place,
                line_width=3.0,
                disable_rotations=True,
                disable_sliders=True,
                depth_test=False,
                opacity=0.9,
            )
            gizmo.on_update(wake)
            self.gizmos[name], self._origins[name] = gizmo, place
            self._balls[name] = client.scene.add_icosphere(
                f"/{name}/ball", radius=0.018 * size, color=style.POINT
            )
            self._labels[name] = client.scene.add_label(
                f"/{name}/label", name, anchor="top-center", depth_test=False
            )
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """``start`` and ``goal``."""
        return {name: self._held(gizmo.position).tolist() for name, gizmo in self.gizmos.items()}

    def place(self, name: str, position: Sequence[float]) -> None:
        """Move an end to ``position`` (3,), [unit]; by hand it goes no further than the workspace.

        The page holds its limits against what the hand has moved a gizmo in all, wherever else it
        was put meanwhile.
        """
        gizmo = self.gizmos[name]
        moved = np.asarray(position) - gizmo.position
        if np.isfinite(moved).all():
            self._origins[name] = self._origins[name] + moved
        low, high = (side - self._origins[name] for side in self._sides)
        x, y, z = zip(low.tolist(), high.tolist(), strict=True)
        gizmo.translation_limits = (x, y, z)
        gizmo.position = np.asarray(position)

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        size = max(scene.workspace.size)
        self._sides = np.array(scene.workspace.min), np.array(scene.workspace.max)
        for name, gizmo in self.gizmos.items():
            self.place(name, getattr(scene, name))
            gizmo.scale = 0.13 * size
            self._balls[name].radius = 0.018 * size
            self._labels[name].position = (0.0, 0.0, -0.05 * size)
        self._label(scene)

    def draw(self, frame: Frame) -> None:
        """Write the coordinates on the labels."""
        if not frame.faded and frame.plan.scene is not self._labelled:
            self._label(frame.plan.scene)

    def _label(self, scene: Scene) -> None:
        self._labelled = scene
        for name, label in self._labels.items():
            label.text = f"{name} ({', '.join(f'{number:.3g}' for number in getattr(scene, name))})"

    def _held(self, position: FloatArray) -> FloatArray:
        """``position`` (3,), without what the page's rounding puts it outside the workspace."""
        low, high = self._sides
        inside = np.clip(position, low, high)
        near = np.abs(position - inside).max() <= _ROUNDING * (high - low).max()
        return inside if near else position


def _placed(data: dict[str, Any], gizmo: viser.TransformControlsHandle) -> dict[str, Any]:
    """An obstacle as a scene file has it."""
    return {**data, "position": gizmo.position.tolist(), "wxyz": gizmo.wxyz.tolist()}


def _radius(shape: Obstacle) -> float:
    low, high = shape.bounds()
    return float(np.linalg.norm(high - low) / 2)


def _body(scene: viser.SceneApi, name: str, shape: Obstacle) -> _Body:
    """Draw the surface, in the obstacle's own frame."""
    look: dict[str, Any] = {"color": style.OBSTACLE, "opacity": _OPACITY, "side": "double"}
    if isinstance(shape, Box):
        return scene.add_box(name, dimensions=shape.size, **look)
    if isinstance(shape, Sphere):
        return scene.add_icosphere(name, radius=shape.radius, subdivisions=_FACETS, **look)
    if isinstance(shape, MeshShape):
        vertices = (shape.surface.vertices * shape.factor).astype(np.float32)
        faces = shape.surface.faces.astype(np.uint32)
        return scene.add_mesh_simple(name, vertices, faces, flat_shading=True, **look)
    from trimesh import creation  # here, since it takes long to import

    if isinstance(shape, Cylinder):
        mesh = creation.cylinder(radius=shape.radius, height=shape.height, sections=48)
    else:
        mesh = creation.capsule(radius=shape.radius, height=shape.height, count=(24, 24))
        mesh.apply_translation((0, 0, -mesh.bounds.mean(axis=0)[2]))
    vertices, faces = mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)
    return scene.add_mesh_simple(name, vertices, faces, **look)

"""Obstacles in the scene, each under a gizmo.

A body is a child of its gizmo, so it moves in the browser at once; the server receives the pose.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.triangle_mesh.mesh_source import Files
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.scene import Scene
from app.drawing.obstacle_body import Body, add_body, add_edges
from app.panels.obstacles.refused_obstacles import accepted_obstacles
from app.panels.widgets import Wake, phase_holds
from app.state.frame import Frame
from app.state.named_obstacles import named_obstacles
from app.ui import page

_MOST_NUMBERED = 40
"""Obstacles that are all numbered in the scene: more numbers would hide it."""
_POSE = {"position", "wxyz"}
_FORESEEN = 0.4
"""Part of its opacity that a mesh has which is not planned with yet."""
_FADED = 0.35
"""Part of it that obstacles keep while one looks at the nodes of a search, also at those behind."""


@dataclass(eq=False)
class ObstacleNodes:
    """An obstacle in the scene, or the preview of an uploaded mesh that is to be one.

    Attributes:
        data: as in a scene file, without its pose; the editor changes it.
        gizmo: that its body is under.
        label: its number.
        valid: its data with its pose when it was valid last.
        obstacle: of these.
        read: its data with its pose when they were read last, without what was refused of them.
        drawn: data that its body is of.
        body: None until the next frame gives it one.
    """

    data: dict[str, Any]
    gizmo: viser.TransformControlsHandle
    label: viser.LabelHandle
    valid: dict[str, Any]
    obstacle: Obstacle
    read: dict[str, Any]
    drawn: dict[str, Any] | None = None
    body: Body | None = None


class ObstacleGizmos:
    """One gizmo for each obstacle; only the chosen one shows its handles.

    Attributes:
        shown: the obstacles in their order.
        chosen: number of the obstacle with the handles, from 0.
        held: whether a hand holds an obstacle or its handles.
        dragged: whether a hand has ever moved one.
        foreseen: a mesh that is no obstacle yet.
    """

    def __init__(self, client: viser.ClientHandle, scene: Scene, wake: Wake) -> None:
        self._scene = client.scene
        self._wake = wake
        self._scene_size = 1.0
        self.shown: list[ObstacleNodes] = []
        self._edges: dict[str, tuple[viser.MeshHandle, tuple[Surface, float]]] = {}
        self._added = 0
        self._visible, self._faded = True, False
        self._embodied: Sequence[Obstacle] | None = None
        self._accepted: Sequence[Obstacle] | None = None
        self._with_handles = -2
        self._touched = False
        self._grip: FloatArray | None = None
        self._placing = threading.Lock()  # hands are heard in another thread than places one
        self.dragged = False
        self.foreseen: ObstacleNodes | None = None
        self.chosen = 0
        self.write(scene)

    @property
    def gizmos(self) -> list[viser.TransformControlsHandle]:
        """The gizmos in the order of the obstacles."""
        return [one.gizmo for one in self.shown]

    def read(self) -> dict[str, Any]:
        """Read the ``obstacles``, posed as the gizmos; the unchanged ones are the scene's own."""
        for one in self.shown:
            one.read = _with_pose(one.data, one.gizmo)
        found = [one.obstacle if one.read == one.valid else one.read for one in self.shown]
        return {"obstacles": found}

    def accept(self, scene: Scene, files: Files) -> Scene:
        """The scene with the obstacles as they were read; a refused one is as it was before.

        It is turned and moved all the same, where that was not what was refused.
        """
        choices = [_choices(one) for one in self.shown]
        scene, accepted = accepted_obstacles(scene, files, choices)
        self._accepted = scene.obstacles if accepted else None
        if accepted:
            for one, choice in zip(self.shown, accepted, strict=True):
                one.read = one.valid if choice is one.obstacle else choice
        return scene

    def write(self, scene: Scene) -> None:
        """Show ``scene``; gizmos of the same shapes stay, so that little is sent."""
        self.forget_foreseen()
        size = max(scene.workspace.size)
        old = [one.obstacle for one in self.shown]
        if size == self._scene_size and _same_shapes(old, scene.obstacles):
            for one, obstacle in zip(self.shown, scene.obstacles, strict=True):
                _put(one, obstacle)
        else:
            while self.shown:
                self.remove(0)
            self._scene_size = size
            for obstacle in scene.obstacles:
                self.add(obstacle)
        self._update_bodies(scene.obstacles)
        self.chosen, self._touched, self.held = 0, False, False
        self.choose(0)

    def draw(self, frame: Frame) -> None:
        """Give each gizmo its obstacle's body, and show or hide all of them."""
        if (visible := "obstacles" in frame.shown) != self._visible:
            self._visible = visible
            for gizmo in self.gizmos:
                gizmo.visible = visible
        if (faded := frame.theatre is not None) != self._faded:
            self._faded = faded
            for one in self.shown:
                if one.body is not None:
                    one.body.opacity = (one.body.opacity or 1.0) * (_FADED if faded else 1 / _FADED)
        self._number(frame)
        obstacles = frame.plan.scene.obstacles
        accepted = obstacles is self._accepted and not frame.outdated
        if (frame.current or accepted) and obstacles is not self._embodied:
            self._update_bodies(obstacles)
            for one, obstacle in zip(self.shown, obstacles, strict=True):
                one.valid, one.obstacle = one.read, obstacle

    def _number(self, frame: Frame) -> None:
        """Write on each obstacle the number by which messages call it, where there are several.

        Of very many, on those alone that a message names now.
        """
        count = len(self.shown)
        numbered = range(count) if 1 < count <= _MOST_NUMBERED else frozenset[int]()
        if count > _MOST_NUMBERED:
            numbered = named_obstacles(frame)
        for index, one in enumerate(self.shown):
            one.label.text = str(index + 1)
            one.label.visible = index in numbered
            one.label.font_screen_scale = frame.label_scale

    def _update_bodies(self, obstacles: Sequence[Obstacle]) -> None:
        """Draw the bodies anew whose obstacles have another shape or size."""
        self._embodied = obstacles
        for one, obstacle in zip(self.shown, obstacles, strict=True):
            shape = {name: value for name, value in one.read.items() if name not in _POSE}
            if one.drawn != shape:
                one.drawn = shape
                self._embody(one, self._new_body(one.gizmo, obstacle, _radius(obstacle)))

    def _new_body(
        self, gizmo: viser.TransformControlsHandle, obstacle: Obstacle, radius: float
    ) -> Body:
        """The body of an obstacle of that radius, [unit], under a gizmo that is made to fit it."""
        gizmo.scale = min(1.35 * radius, 0.4 * self._scene_size) + 0.03 * self._scene_size
        share = 2 * radius / (3**0.5 * self._scene_size)
        return add_body(self._scene, f"{gizmo.name}/body", obstacle, share)

    def _embody(self, one: ObstacleNodes, body: Body) -> None:
        one.body = body
        if self._faded:
            body.opacity = (body.opacity or 1.0) * _FADED
        body.on_click(self._choose_clicked)
        body.on_drag(self._drag_body)

    def foresee(self, mesh: MeshShape) -> None:
        """Draw a mesh that is not turned, faintly, until it is added."""
        self.forget_foreseen()
        self.foreseen = one = self._new_nodes(mesh)
        # its bounds take longer, and are found while it is prepared
        diagonal = mesh.factor * np.ptp(mesh.surface.vertices, axis=0)
        radius = float(np.linalg.norm(diagonal) / 2)
        one.body = body = self._new_body(one.gizmo, mesh, radius)
        body.opacity = _FORESEEN * (body.opacity or 1.0)

    def forget_foreseen(self) -> None:
        """Remove the mesh that is no obstacle yet."""
        if self.foreseen is not None:
            self.foreseen.gizmo.remove()
            self.foreseen = None

    def show_edges(self, shown: bool) -> None:
        """Show or hide the edges of the meshes' triangles."""
        meshes = [
            (f"{one.gizmo.name}/edges", obstacle)
            for one, obstacle in zip(self.shown, self._embodied or (), strict=False)
            if shown and isinstance(obstacle, MeshShape)
        ]
        wanted = {name: (mesh.surface, mesh.factor) for name, mesh in meshes}
        for name in [name for name in self._edges if name not in wanted]:
            self._edges.pop(name)[0].remove()
        for name, mesh in meshes:
            if name not in self._edges or self._edges[name][1] != wanted[name]:
                self._edges[name] = (add_edges(self._scene, name, mesh), wanted[name])

    def add(self, obstacle: Obstacle) -> None:
        """Add an obstacle's gizmo; the next frame gives it a body, if it was not foreseen."""
        one, self.foreseen = self.foreseen, None
        if one is not None and one.body is not None and _is_drawn_as(obstacle, one.obstacle):
            _put(one, obstacle)
            one.drawn = dict(one.data)
            one.body.opacity = (one.body.opacity or 1.0) / _FORESEEN
            self._embody(one, one.body)
        else:
            if one is not None:
                one.gizmo.remove()
            one = self._new_nodes(obstacle)
        self.shown.append(one)
        self._embodied = None
        self._with_handles = -2

    def _new_nodes(self, obstacle: Obstacle) -> ObstacleNodes:
        """A gizmo without handles where an obstacle is, and its label; no body yet."""
        self._added += 1
        gizmo = self._scene.add_transform_controls(
            f"/obstacle_{self._added}",
            scale=self._scene_size,
            line_width=2.5,
            position=obstacle.position,
            wxyz=obstacle.wxyz,
            depth_test=False,
            opacity=0.9,
            visible=self._visible,
            disable_axes=True,
            disable_sliders=True,
            disable_rotations=True,
        )
        gizmo.on_update(self._drag_gizmo)
        page.keep_to_tab(gizmo)
        label = self._scene.add_label(
            f"{gizmo.name}/number", "", anchor="center-center", visible=False
        )
        data = obstacle.model_dump(mode="json", exclude=_POSE)
        posed = _with_pose(data, gizmo)
        return ObstacleNodes(data, gizmo, label, posed, obstacle, posed)

    def remove(self, number: int) -> None:
        """Remove obstacle ``number``, from 0."""
        gizmo = self.shown.pop(number).gizmo
        self._edges.pop(f"{gizmo.name}/edges", None)  # it goes with the gizmo
        gizmo.remove()
        self._with_handles = -2

    def place(self, number: int, position: FloatArray) -> None:
        """Move obstacle ``number``, from 0, unless a hand has ``dragged`` one."""
        with self._placing:
            if not self.dragged:
                self.shown[number].gizmo.position = position

    def point_out(self, number: int) -> None:
        """Choose obstacle ``number``, from 0, and give it the handles."""
        self._touched = True
        self.choose(number)

    def choose(self, number: int) -> None:
        """Give the handles to obstacle ``number``, from 0; to none before a hand chose one."""
        self._touched |= number != self.chosen
        self.chosen = number
        handles = number if self._touched else -1
        if handles == self._with_handles:
            return
        self._with_handles = handles
        for index, gizmo in enumerate(self.gizmos):
            hidden = index != handles
            if gizmo.disable_axes == hidden:
                continue
            gizmo.disable_axes = gizmo.disable_sliders = gizmo.disable_rotations = hidden

    def _drag_gizmo(self, event: viser.TransformControlsEvent) -> None:
        self.dragged = True
        self.held = phase_holds(event.phase, self.held)
        self._wake(event)

    def _choose_clicked(self, event: viser.SceneNodePointerEvent[Any]) -> None:
        if self._faded:  # a node of the search is meant, and handles would cover others
            return
        self.chosen = next(i for i, one in enumerate(self.shown) if one.body is event.target)
        self._touched = True
        self._wake(event)

    def _drag_body(self, event: viser.SceneNodeDragEvent[Any]) -> None:
        """Move a body with the hand, in the plane that faces the camera."""
        number = next((i for i, one in enumerate(self.shown) if one.body is event.target), None)
        if number is None:
            return
        gizmo = self.shown[number].gizmo
        if self._grip is None:
            self._grip = np.subtract(gizmo.position, event.start_position)
        position = np.add(event.end_position, self._grip)
        if np.isfinite(position).all():
            with self._placing:
                self.dragged = True
                gizmo.position = position
        self.held = phase_holds(event.phase, self.held)
        if event.phase == "end":
            self._grip = None
        self.chosen, self._touched = number, True
        self._wake(event)


def _same_shapes(old: Sequence[Obstacle], new: Sequence[Obstacle]) -> bool:
    """Check whether each obstacle is of the old one's shape, and of the same surface."""
    return len(old) == len(new) and all(
        type(a) is type(b) and _surface(a) is _surface(b) for a, b in zip(old, new, strict=True)
    )


def _surface(obstacle: Obstacle) -> Surface | None:
    """The surface of a mesh; None for other shapes, which make theirs anew each time."""
    return obstacle.surface if isinstance(obstacle, MeshShape) else None


def _put(one: ObstacleNodes, obstacle: Obstacle) -> None:
    """Show another obstacle of the same shape."""
    one.gizmo.position, one.gizmo.wxyz = obstacle.position, obstacle.wxyz
    one.data, one.obstacle = obstacle.model_dump(mode="json", exclude=_POSE), obstacle
    one.read = one.valid = _with_pose(one.data, one.gizmo)


def _choices(one: ObstacleNodes) -> tuple[Any, ...]:
    """An obstacle as it was read, then with its last valid shape, then as it was."""
    if one.read == one.valid:
        return (one.obstacle,)
    moved = {name: one.read[name] for name in _POSE}
    return one.read, {**one.valid, **moved}, one.obstacle


def _with_pose(data: dict[str, Any], gizmo: viser.TransformControlsHandle) -> dict[str, Any]:
    """An obstacle's data with the pose of its gizmo, as in a scene file."""
    return {**data, "position": gizmo.position.tolist(), "wxyz": gizmo.wxyz.tolist()}


def _radius(obstacle: Obstacle) -> float:
    """Half the diagonal of the bounds, [unit]."""
    low, high = obstacle.bounds()
    return float(np.linalg.norm(high - low) / 2)


def _is_drawn_as(one: Obstacle, other: Obstacle) -> bool:
    """Check whether two are meshes of the same surface, of the same size, in the same place."""
    if not (isinstance(one, MeshShape) and isinstance(other, MeshShape)):
        return False
    if one.surface != other.surface:
        return False
    pose = one.factor, one.position, one.wxyz
    return pose == (other.factor, other.position, other.wxyz)

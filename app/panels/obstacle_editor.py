"""Start, goal and the chosen obstacle as numbers; add, duplicate and delete obstacles.

A box and its gizmo show the same numbers. The one that changed since the last time counts: a typed
number moves the gizmo, a drag rewrites the box.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import viser
from viser.transforms import SO3

from abi.arrays import FloatArray
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.pose import METRES
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.scene import Scene
from app import page
from app.frame import Frame
from app.labels import sentence
from app.panels.end_gizmos import EndGizmos
from app.panels.mesh_note import MeshNote
from app.panels.obstacle_gizmos import ObstacleGizmos
from app.panels.obstacle_sizes import ObstacleSizes
from app.panels.widgets import Vec3, VectorBox, Wake

_NONE = "none"
_FIELDS = ("obstacles", "start", "goal", "file")
"""Fields of a scene that are typed here, or uploaded."""


class ObstacleEditor:
    """Numbers of start, goal and the chosen obstacle, under the obstacles' buttons.

    Attributes:
        surfaces: uploaded meshes, by the names of their files.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        obstacles: ObstacleGizmos,
        ends: EndGizmos,
        wake: Wake,
    ) -> None:
        self._client = client
        gui = client.gui
        self._obstacles, self._ends = obstacles, ends
        self._end_boxes = {
            name: VectorBox(gui, name, 0.1, f"Where the tool's path has its {name}.", wake)
            for name in ("start", "goal")
        }
        self.choice = gui.add_dropdown(
            "obstacle", (_NONE,), hint="Or click an obstacle in the scene."
        )
        self.sizes = ObstacleSizes(gui, wake)
        self._mesh_note = MeshNote(gui, wake)
        self._position = VectorBox(gui, "position", 0.1, "The obstacle's centre.", wake)
        self._angles = VectorBox(gui, "turned [°]", 5.0, "About x, then y, then z.", wake)
        self.kind = gui.add_dropdown("new shape", ("box", "sphere", "cylinder", "capsule"))
        self.buttons = gui.add_button_group("change", ("Add", "Duplicate", "Delete"))
        self.upload = gui.add_upload_button(
            "Add a mesh…", mime_type=".stl,.obj,.glb", hint="STL, OBJ or GLB, up to 50 MB."
        )
        self._uploaded: object = self.upload.value
        self.surfaces: dict[str, Surface] = {}
        self._noted: tuple[Scene, int] | None = None
        self._refused = ""
        self._shown: dict[str, Any] = {}
        self._listed = -1
        self._pressed = False
        self.choice.on_update(wake)
        self.upload.on_upload(wake)
        self._wake = wake
        self.buttons.on_click(self._note_press)

    def apply(self, scene: Scene) -> None:
        """Apply what was typed, pressed or dragged; ``scene`` is the last valid one.

        Raises:
            SceneError: a typed number is not finite, or an uploaded file is not a mesh.
        """
        if self.upload.value is not self._uploaded:
            self._uploaded = self.upload.value
            self._add_mesh(self.upload.value, scene)
        if (unit := self._mesh_note.accepted()) is not None:
            self.sizes.choose_unit(unit)
        if self._pressed:
            self._pressed = False
            self._change(self.buttons.value, scene)
        self._follow_choice()
        for name, box in self._end_boxes.items():
            if (typed := box.typed(name)) is not None:
                self._ends.place(name, typed)
            box.show(self._ends.gizmos[name].position)
        if self._obstacles.gizmos:
            self._edit(self._obstacles.chosen, scene)

    def write(self, scene: Scene) -> None:
        """Show ``scene``, whose gizmos are in place, instead of anything typed."""
        self._forget()
        for name, box in self._end_boxes.items():
            box.write(self._ends.gizmos[name].position)
        self._follow_choice()
        if self._obstacles.gizmos:
            self._edit(self._obstacles.chosen, scene)

    def _forget(self) -> None:
        """Take none of the numbers for typed: they are of another obstacle than before."""
        self._listed = -1
        self._shown = {}

    def meshes(self, scene: Scene) -> MeshSource:
        """Surfaces that obstacles can name: those of ``scene`` and the uploaded ones."""
        return MeshSource({**scene.meshes.files, **self.surfaces})

    def _add_mesh(self, file: viser.UploadedFile, scene: Scene) -> None:
        """Add an uploaded mesh in the middle of the workspace.

        Raises:
            SceneError: not a mesh; nothing is added.
        """
        name = _safe_name(file.name)
        surface = MeshSource({name: file.content}).surface(name)
        self.surfaces[name] = surface
        middle = np.add(scene.workspace.min, scene.workspace.max) / 2
        position = tuple(map(float, middle - _middle(surface)))
        mesh = MeshShape.of(surface, file=name, position=position)
        mesh.prepare()
        self._obstacles.add(mesh)
        self._obstacles.choose(len(self._obstacles.gizmos) - 1)
        self._forget()

    def draw(self, frame: Frame) -> None:
        """Describe the chosen mesh, and notify once of an error in what was typed here.

        The heading that names the error may be out of sight.
        """
        error = frame.refused
        if str(error or "") != self._refused:
            self._refused = str(error or "")
            if error is not None and getattr(error, "field", "").startswith(_FIELDS):
                page.notify_refusal(self._client, "Not changed", sentence(error))
        scene, number = frame.plan.scene, self._obstacles.chosen
        if frame.current and (scene, number) != self._noted:
            self._noted = scene, number
            chosen = scene.obstacles[number] if number < len(scene.obstacles) else None
            current = len(scene.obstacles) == len(self._obstacles.data)
            self._mesh_note.write(
                chosen if current and isinstance(chosen, MeshShape) else None, scene
            )

    def _note_press(self, event: object) -> None:
        self._pressed = True
        self._wake(event)

    def _change(self, action: str, scene: Scene) -> None:
        """Add, duplicate or delete."""
        obstacles = self._obstacles
        if action == "Add":
            obstacles.add(_new_obstacle(self.kind.value, scene))
        elif action == "Duplicate" and obstacles.gizmos:
            twin = scene.obstacles[min(obstacles.chosen, len(scene.obstacles) - 1)]
            position = np.array(twin.position) + 0.1 * np.array(scene.workspace.size)
            obstacles.add(twin.model_copy(update={"position": tuple(map(float, position))}))
        elif action == "Delete" and obstacles.gizmos:
            obstacles.remove(obstacles.chosen)
        obstacles.choose(max(len(obstacles.gizmos) - 1, 0))
        self._forget()

    def _follow_choice(self) -> None:
        """Choose the same obstacle in the list and in the scene: the newer choice."""
        obstacles = self._obstacles
        names = tuple(f"{i + 1} · {data['shape']}" for i, data in enumerate(obstacles.data))
        if tuple(self.choice.options) != (names or (_NONE,)):
            self.choice.options = names or (_NONE,)
            self._listed = -1
        for box in (self._position, self._angles):
            box.handle.disabled = not names
        if not names:
            self.sizes.write({})
            return
        listed = names.index(self.choice.value) if self.choice.value in names else 0
        number = min(obstacles.chosen, len(names) - 1)
        if self._listed not in (-1, listed):
            number = listed
        self._listed = number
        self.choice.value = names[number]
        obstacles.choose(number)

    def _edit(self, number: int, scene: Scene) -> None:
        """Apply, then show, the numbers of the chosen obstacle."""
        data, gizmo = self._obstacles.data[number], self._obstacles.gizmos[number]
        field = f"obstacles[{number}]"
        if number != self._shown.get("number"):
            self._position.write(gizmo.position)
            self._angles.write(_degrees(gizmo.wxyz) or (0.0, 0.0, 0.0))
        if (number, data) != (self._shown.get("number"), self._shown.get("data")):
            self.sizes.write(data)
        else:
            before = dict(data)
            data.update(self.sizes.read(data))
            if "file" in data and data != before:
                self._keep_in_place(gizmo, before, data, scene)
        self._shown = {"number": number, "data": dict(data)}
        if (position := self._position.typed(f"{field}.position")) is not None:
            gizmo.position = position
        if (angles := self._angles.typed(f"{field}.wxyz")) is not None:
            gizmo.wxyz = SO3.from_rpy_radians(*np.radians(angles)).wxyz
        self._position.show(gizmo.position)
        if angles is None and (turned := _degrees(gizmo.wxyz)) is not None:
            self._angles.show(turned)

    def _keep_in_place(
        self,
        gizmo: viser.TransformControlsHandle,
        before: dict[str, Any],
        data: dict[str, Any],
        scene: Scene,
    ) -> None:
        """Keep a mesh's middle in place as its size changes; its file's origin may be anywhere."""
        middle = _middle(self.meshes(scene).surface(data["file"]))
        growth = _factor(data, scene) - _factor(before, scene)
        position = np.asarray(gizmo.position)
        position = position - growth * SO3(np.asarray(gizmo.wxyz)).apply(middle)
        if np.isfinite(position).all():
            gizmo.position = position


def _degrees(wxyz: Any) -> Vec3 | None:
    """Roll, pitch and yaw of a quaternion, [°]; None where it is no rotation."""
    wxyz = np.asarray(wxyz)
    if not (np.isfinite(wxyz).all() and wxyz.any()):
        return None
    roll, pitch, yaw = np.degrees(SO3(wxyz).normalize().as_rpy_radians()).tolist()
    return roll, pitch, yaw


def _middle(surface: Surface) -> FloatArray:
    """Middle of the bounds (3,), in the file's units."""
    return np.asarray((surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2)


def _factor(data: dict[str, Any], scene: Scene) -> float:
    """Lengths of the scene, [unit], per length of a mesh file."""
    unit = data["unit"]
    return float(data["scale"] * (METRES[unit] / METRES[scene.unit] if unit else 1.0))


def _safe_name(name: str) -> str:
    """File name for the scene from an uploaded one, which may have any characters."""
    stem, dot, ending = name.rpartition(".")
    kept = "".join(c if c.isalnum() or c in "-_" else "_" for c in stem)[:60] or "mesh"
    return f"{kept}{dot}{ending.lower()}"


def _new_obstacle(kind: str, scene: Scene) -> Obstacle:
    """An obstacle of a sixth of the workspace, above its middle."""
    length = max(scene.workspace.size) / 6
    x, y, z = (
        a + share * (b - a)
        for a, b, share in zip(
            scene.workspace.min, scene.workspace.max, (0.5, 0.5, 0.75), strict=True
        )
    )
    pose = {"position": (x, y, z)}
    if kind == "box":
        return Box(shape="box", size=(length, length, length), **pose)
    if kind == "sphere":
        return Sphere(shape="sphere", radius=length / 2, **pose)
    if kind == "cylinder":
        return Cylinder(shape="cylinder", radius=length / 2, height=length, **pose)
    return Capsule(shape="capsule", radius=length / 3, height=length, **pose)

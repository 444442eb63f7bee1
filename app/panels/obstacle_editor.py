"""Obstacles, start and goal as numbers; add, duplicate and delete obstacles.

A number box and its gizmo show the same thing. The one that moved since the last look is right:
what was typed moves the gizmo, what was dragged rewrites the box.
"""

from __future__ import annotations

import html
from typing import Any

import numpy as np
import viser
from viser.transforms import SO3

from abi.errors import AbiError
from abi.obstacles.mesh_shape import suggest_unit
from abi.obstacles.pose import METRES
from abi.obstacles.primitives import Box, Capsule, Cylinder, MeshShape, Obstacle, Sphere
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.repair import Surface
from abi.scene.scene import Scene
from app import page
from app.frame import Frame
from app.labels import as_labelled
from app.panels.gizmos import EndGizmos, ObstacleGizmos
from app.panels.widgets import DIGITS, NumberBox, Triple, Wake, label_of

_NONE = "none"
_SIZES = ("size", "radius", "height", "scale", "unit")
_UNITS: dict[str, str | None] = {"the scene's unit": None, "m": "m", "cm": "cm", "mm": "mm"}


_FIELDS = ("obstacles", "start", "goal", "file")
"""What fields of a scene are typed here, or uploaded."""


class ObstacleEditor:
    """The numbers of start, goal and the chosen obstacle.

    Attributes:
        surfaces: meshes that were uploaded, by the names of their files.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        obstacles: ObstacleGizmos,
        points: EndGizmos,
        wake: Wake,
    ) -> None:
        self._client = client
        gui = client.gui
        self._obstacles, self._points = obstacles, points
        self._ends = {
            name: NumberBox(gui, name, 0.1, f"Where the tool's path has its {name}.", wake)
            for name in ("start", "goal")
        }
        self.choice = gui.add_dropdown(
            "obstacle", (_NONE,), hint="Or click an obstacle in the scene."
        )
        self.size = gui.add_vector3("size", (1.0, 1.0, 1.0), step=0.1, hint="Edge lengths.")
        self.radius = gui.add_number("radius", 1.0, step=0.1)
        self.height = gui.add_number(
            "height", 1.0, step=0.1, hint="A capsule's is between the centres of its two caps."
        )
        self.scale = gui.add_number("scale", 1.0, step=0.1, hint="Of the file's lengths.")
        self.unit = gui.add_dropdown("file is in", tuple(_UNITS), hint="The unit of the file.")
        self.note = gui.add_html("", visible=False)
        self.accept = gui.add_button("", visible=False)
        self._position = NumberBox(gui, "position", 0.1, "The obstacle's centre.", wake)
        self._angles = NumberBox(gui, "turned [°]", 5.0, "About x, then y, then z.", wake)
        self.kind = gui.add_dropdown("new shape", ("box", "sphere", "cylinder", "capsule"))
        self.buttons = gui.add_button_group("change", ("Add", "Duplicate", "Delete"))
        self.upload = gui.add_upload_button(
            "Add a mesh…", mime_type=".stl,.obj,.glb", hint="STL, OBJ or GLB, up to 50 MB."
        )
        self._uploaded: object = self.upload.value
        self.surfaces: dict[str, Surface] = {}
        self._suggested = ""
        self._suggested_for: tuple[Scene, int] | None = None
        self._refused = ""
        self._shown: dict[str, Any] = {}
        self._listed = -1
        self._pressed = False
        for box in (self.size, self.radius, self.height, self.scale):
            box.precision = DIGITS
            box.on_update(wake)
        for handle in (self.choice, self.unit):
            handle.on_update(wake)
        self.accept.on_click(wake)
        self.upload.on_upload(wake)
        self._wake = wake
        self.buttons.on_click(self._press)

    def apply(self, scene: Scene) -> None:
        """Bring numbers, buttons and gizmos together; ``scene`` is the last good one.

        Raises:
            SceneError: a typed number is not finite, or an uploaded file is not a mesh.
        """
        if self.upload.value is not self._uploaded:
            self._uploaded = self.upload.value
            self._add_mesh(self.upload.value, scene)
        if self.accept.value:
            self.accept.value = False
            self.unit.value = label_of(_UNITS, self._suggested)
        if self._pressed:
            self._pressed = False
            self._change(self.buttons.value, scene)
        self._follow_choice()
        for name, box in self._ends.items():
            if (typed := box.typed(name)) is not None:
                self._points.place(name, typed)
            box.show(self._points.gizmos[name].position)
        if self._obstacles.gizmos:
            self._edit(self._obstacles.chosen, scene)

    def write(self, scene: Scene) -> None:
        """Show ``scene``, which is placed already, whatever was typed."""
        self._forget()
        for name, box in self._ends.items():
            box.write(self._points.gizmos[name].position)
        self._follow_choice()
        if self._obstacles.gizmos:
            self._edit(self._obstacles.chosen, scene)

    def _forget(self) -> None:
        """What the numbers show is of another obstacle than before."""
        self._listed = -1
        self._shown = {}

    def meshes(self, scene: Scene) -> MeshSource:
        """The surfaces that obstacles can name: those of ``scene`` and those uploaded here."""
        return MeshSource({**scene.meshes.files, **self.surfaces})

    def _add_mesh(self, file: viser.UploadedFile, scene: Scene) -> None:
        """Put an uploaded mesh into the middle of the workspace.

        Raises:
            SceneError: not a mesh; nothing is added.
        """
        name = _plain(file.name)
        surface = MeshSource({name: file.content}).surface(name)
        self.surfaces[name] = surface
        middle = np.add(scene.workspace.min, scene.workspace.max) / 2
        centre = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
        place = tuple(map(float, middle - centre))
        shape = MeshShape.of(surface, file=name, position=place)
        shape.prepare()
        self._obstacles.add(shape)
        self._obstacles.choose(len(self._obstacles.gizmos) - 1)
        self._forget()

    def draw(self, frame: Frame) -> None:
        """Ask when the chosen mesh is hugely out of scale, and say what was repaired in it.

        What was typed here and is wrong is told of once: the heading that complains is far away.
        """
        if (refused := str(frame.refused or "")) != self._refused:
            self._refused = refused
            self._tell(frame.refused)
        state = frame.plan.scene, self._obstacles.chosen
        if not frame.faded and state != self._suggested_for:
            self._suggested_for = state
            self._suggest(*state)

    def _tell(self, error: AbiError | None) -> None:
        if isinstance(error, AbiError) and getattr(error, "field", "").startswith(_FIELDS):
            page.refuse(self._client, "Not taken over", as_labelled(error, error.message))

    def _suggest(self, scene: Scene, number: int) -> None:
        shape = scene.obstacles[number] if number < len(scene.obstacles) else None
        shown = isinstance(shape, MeshShape) and len(scene.obstacles) == len(self._obstacles.data)
        self._suggested, notes = "", []
        if shown and isinstance(shape, MeshShape):
            extent = shape.surface.extent * shape.factor
            unit = shape.unit or scene.unit
            self._suggested = suggest_unit(extent, scene.workspace.size, unit) or ""
            notes = [f"{len(shape.surface.faces):,} triangles, {extent:.3g} {scene.unit} wide."]
            notes += shape.surface.notes
        if self._suggested:
            notes.append(
                f"That is far from the workspace's size: is the file in {self._suggested}?"
            )
            self.accept.label = f"Yes, read it in {self._suggested}"
        self.accept.visible = bool(self._suggested)
        self.note.visible = bool(notes)
        text = html.escape(" ".join(notes))
        self.note.content = f'<div style="margin:0 10px;font-size:12.5px">{text}</div>'

    def _press(self, event: object) -> None:
        self._pressed = True
        self._wake(event)

    def _change(self, what: str, scene: Scene) -> None:
        """Add, duplicate or delete."""
        obstacles = self._obstacles
        if what == "Add":
            obstacles.add(_new(self.kind.value, scene))
        elif what == "Duplicate" and obstacles.gizmos:
            twin = scene.obstacles[min(obstacles.chosen, len(scene.obstacles) - 1)]
            aside = np.array(twin.position) + 0.1 * np.array(scene.workspace.size)
            obstacles.add(twin.model_copy(update={"position": tuple(map(float, aside))}))
        elif what == "Delete" and obstacles.gizmos:
            obstacles.remove(obstacles.chosen)
        obstacles.choose(max(len(obstacles.gizmos) - 1, 0))
        self._forget()

    def _follow_choice(self) -> None:
        """One obstacle is chosen, in the list and in the scene alike."""
        obstacles = self._obstacles
        names = tuple(f"{i + 1} · {data['shape']}" for i, data in enumerate(obstacles.data))
        if tuple(self.choice.options) != (names or (_NONE,)):
            self.choice.options = names or (_NONE,)
            self._listed = -1
        for box in (self._position, self._angles):
            box.handle.disabled = not names
        if not names:
            self._show_sizes({})
            return
        listed = names.index(self.choice.value) if self.choice.value in names else 0
        number = min(obstacles.chosen, len(names) - 1)
        if self._listed not in (-1, listed):
            number = listed
        self._listed = number
        self.choice.value = names[number]
        obstacles.choose(number)

    def _edit(self, number: int, scene: Scene) -> None:
        """The numbers of the chosen obstacle."""
        data, gizmo = self._obstacles.data[number], self._obstacles.gizmos[number]
        field = f"obstacles[{number}]"
        if number != self._shown.get("number"):
            self._position.write(gizmo.position)
            self._angles.write(_degrees(gizmo.wxyz) or (0.0, 0.0, 0.0))
        if (number, data) != (self._shown.get("number"), self._shown.get("data")):
            self._show_sizes(data)
        else:
            before = dict(data)
            for name in _SIZES:
                if name in data:
                    data[name] = self._size(name)
            if "file" in data and data != before:
                self._keep_in_place(gizmo, before, data, scene)
        self._shown = {"number": number, "data": dict(data)}
        if (place := self._position.typed(f"{field}.position")) is not None:
            gizmo.position = place
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
        """Let a mesh grow about its middle: the origin of its file may be anywhere."""
        vertices = self.meshes(scene).surface(data["file"]).vertices
        middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        growth = _factor(data, scene) - _factor(before, scene)
        moved = np.asarray(gizmo.position) - growth * SO3(np.asarray(gizmo.wxyz)).apply(middle)
        if np.isfinite(moved).all():
            gizmo.position = moved

    def _show_sizes(self, data: dict[str, Any]) -> None:
        """Only the sizes that this shape has."""
        for name in _SIZES:
            handle = getattr(self, name)
            handle.visible = name in data
            if name == "unit" and name in data:
                handle.value = label_of(_UNITS, data[name])
            elif name in data:
                handle.value = tuple(data[name]) if name == "size" else data[name]

    def _size(self, name: str) -> Any:
        """One of the sizes as a scene file has it."""
        value = getattr(self, name).value
        if name == "unit":
            return _UNITS[value]
        return list(value) if name == "size" else value


def _degrees(wxyz: Any) -> Triple | None:
    """Roll, pitch and yaw of a quaternion, [°]; None where it is no rotation."""
    wxyz = np.asarray(wxyz)
    if not (np.isfinite(wxyz).all() and wxyz.any()):
        return None
    roll, pitch, yaw = np.degrees(SO3(wxyz).normalize().as_rpy_radians()).tolist()
    return roll, pitch, yaw


def _factor(data: dict[str, Any], scene: Scene) -> float:
    """The scene's [unit] per unit of a mesh file."""
    unit = data["unit"]
    return float(data["scale"] * (METRES[unit] / METRES[scene.unit] if unit else 1.0))


def _plain(name: str) -> str:
    """A file name for the scene: what a browser sends may be anything."""
    stem, dot, ending = name.rpartition(".")
    kept = "".join(c if c.isalnum() or c in "-_" else "_" for c in stem)[:60] or "mesh"
    return f"{kept}{dot}{ending.lower()}"


def _new(kind: str, scene: Scene) -> Obstacle:
    """A new obstacle of a sixth of the workspace, above its middle."""
    length = max(scene.workspace.size) / 6
    x, y, z = (
        a + share * (b - a)
        for a, b, share in zip(
            scene.workspace.min, scene.workspace.max, (0.5, 0.5, 0.75), strict=True
        )
    )
    place = {"position": (x, y, z)}
    if kind == "box":
        return Box(shape="box", size=(length, length, length), **place)
    if kind == "sphere":
        return Sphere(shape="sphere", radius=length / 2, **place)
    if kind == "cylinder":
        return Cylinder(shape="cylinder", radius=length / 2, height=length, **place)
    return Capsule(shape="capsule", radius=length / 3, height=length, **place)

"""Start, goal and the chosen obstacle as numbers; add, duplicate and delete obstacles.

A number box and its gizmo show the same values. The one that has changed since the last time
counts: a typed number moves the gizmo, and a drag rewrites the box.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import viser
from viser.transforms import SO3

from abi.arrays import FloatArray
from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape, file_factor
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.pose import Vec3
from abi.obstacles.primitives import PRIMITIVES
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.scene import Scene
from app.panels.files.mesh_uploads import add_mesh_uploads
from app.panels.length_step import length_step
from app.panels.obstacles.end_gizmos import EndGizmos
from app.panels.obstacles.free_place import Bounds, free_place
from app.panels.obstacles.mesh_note import fitted_scale
from app.panels.obstacles.obstacle_gizmos import ObstacleGizmos
from app.panels.obstacles.obstacle_sizes import ObstacleSizes
from app.panels.widgets import VectorBox, Wake
from app.state.frame import Frame
from app.ui import notices
from app.ui.labels import sentence
from app.ui.numbers import format_setting

_NONE = "none"
_FORESEEN = "mesh.stl"
"""Name of a mesh that is only drawn yet."""
_FIELDS = ("obstacles", "start", "goal")
"""Fields of a scene that are typed here."""

_END_HINT = "Where the tool tip is at the {}: x, y and z."


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
            name: VectorBox(gui, name, 0.1, _END_HINT.format(name), wake)
            for name in ("start", "goal")
        }
        self.choice = gui.add_dropdown(
            "obstacle", (_NONE,), hint="Or click or tap an obstacle in the scene."
        )
        self.sizes = ObstacleSizes(gui, wake)
        self._position = VectorBox(gui, "position", 0.1, "The obstacle's centre.", wake)
        self._angles = VectorBox(gui, "rotation [°]", 5.0, "About x, then y, then z.", wake)
        self.kind = gui.add_dropdown(
            "new shape",
            tuple(PRIMITIVES),
            hint="The shape that Add puts into the nearest free place.",
        )
        self.buttons = gui.add_button_group("edit", ("Add", "Duplicate", "Delete"))
        self.uploads = add_mesh_uploads(gui, wake)
        self.surfaces: dict[str, Surface] = {}
        self._previewed: Surface | None = None
        self._noted: tuple[Scene, int] | None = None
        self._refused = ""
        self._notice: viser.NotificationHandle | None = None
        self._shown: dict[str, Any] = {}
        self._turned: list[float] | None = None
        self._listed = -1
        self._pressed = False
        self._removed: int | None = None
        self._added: list[Bounds] = []
        self.choice.on_update(wake)
        self._fitted: tuple[object, ...] = ()
        self._wake = wake
        self.buttons.on_click(self._note_press)

    def apply(self, scene: Scene) -> None:
        """Apply what was typed, pressed or dragged; ``scene`` is the last valid one.

        Raises:
            SceneError: a typed number is too large, or not finite; all else was applied.
        """
        self._receive(scene)
        self.sizes.take_offers()
        if self._pressed:
            self._pressed = False
            self._change(self.buttons.value, scene)
        self._follow_choice()
        refused: SceneError | None = None
        for name, box in self._end_boxes.items():
            try:
                typed = box.typed(name)
            except SceneError as error:
                refused = error
                continue
            if typed is not None:
                self._ends.place(name, typed)
            box.show(self._ends.gizmos[name].position)
        if self._obstacles.shown:
            self._edit(self._obstacles.chosen, scene)
        if refused is not None:
            raise refused

    def removed(self) -> int | None:
        """Number of the obstacle that was deleted since the last call, from 0; None for none."""
        number, self._removed = self._removed, None
        return number

    def write(self, scene: Scene) -> None:
        """Show ``scene``, whose gizmos are in place, instead of anything typed."""
        self._forget()
        for name, box in self._end_boxes.items():
            box.write(self._ends.gizmos[name].position)
        self._follow_choice()
        if self._obstacles.shown:
            self._edit(self._obstacles.chosen, scene)

    def _forget(self) -> None:
        """Take none of the numbers for typed: they are of another obstacle than before."""
        self._listed = -1
        self._shown = {}

    def meshes(self, scene: Scene) -> MeshSource:
        """Surfaces that obstacles can name: those of ``scene`` and the uploaded ones."""
        return MeshSource({**scene.meshes.files, **self.surfaces})

    def _receive(self, scene: Scene) -> None:
        """Draw the uploaded meshes that are read, and add those that are prepared."""
        preview = self.uploads.preview
        for one in self.uploads.ended():
            if isinstance(one.result, Surface):
                self._add_mesh(one.name, one.result, scene)
            elif one.result is not None:
                title = f"{one.name} is not added"
                notices.notify_refusal(self._client, title, sentence(one.result), stays=True)
            self._obstacles.forget_foreseen()
        if preview is None or preview is not self.uploads.preview:
            self._obstacles.forget_foreseen()
        elif preview is not self._previewed:
            self._obstacles.foresee(self._placed(_FORESEEN, preview, scene))
        self._previewed = preview

    def _add_mesh(self, name: str, surface: Surface, scene: Scene) -> None:
        """Add an uploaded mesh where it was foreseen, or else at the next free place."""
        known = self.meshes(scene).files
        while known.get(name, surface) != surface:  # another file of the same name
            name = f"_{name}"
        self.surfaces[name] = surface
        mesh = self._placed(name, surface, scene)
        self._added.append(mesh.bounds())
        self._obstacles.add(mesh)
        self._obstacles.choose(len(self._obstacles.shown) - 1)
        self._forget()

    def _placed(self, name: str, surface: Surface, scene: Scene) -> MeshShape:
        """A mesh at a size that can be seen, where it was foreseen or else at a free place."""
        preview = self._obstacles.foreseen
        foreseen = None if preview is None else preview.obstacle
        if isinstance(foreseen, MeshShape) and foreseen.surface == surface:
            pose: dict[str, Any] = {"position": foreseen.position}
            mesh = MeshShape.of(surface, file=name, scale=foreseen.scale, **pose)
            return mesh.in_unit(scene.unit)
        scale = fitted_scale(surface, scene)
        factor = scale * file_factor(surface, None, scene.unit)
        half = factor * np.ptp(surface.vertices, axis=0) / 2
        wanted = np.add(scene.workspace.min, scene.workspace.max) / 2
        place = free_place(half, wanted, scene, self._occupied(scene))
        x, y, z = (place - factor * _middle(surface)).tolist()
        mesh = MeshShape.of(surface, file=name, position=(x, y, z), scale=scale)
        return mesh.in_unit(scene.unit)

    def _occupied(self, scene: Scene) -> list[Bounds]:
        """Bounds of the obstacles of the last valid scene, and of those added since."""
        return [*(obstacle.bounds() for obstacle in scene.obstacles), *self._added]

    def draw(self, frame: Frame) -> None:
        """Describe the chosen mesh, and notify once of an error in what was typed here.

        The heading that names the error may be out of sight. The notice goes with the error: on the
        way to 0.5 a box holds 0 for a moment.
        """
        error = frame.refused
        if str(error or "") != self._refused:
            self._refused = str(error or "")
            if self._notice is not None:
                self._notice.remove()
                self._notice = None
            if error is not None and getattr(error, "field", "").startswith(_FIELDS):
                title = "Not changed"
                self._notice = notices.notify_refusal(self._client, title, sentence(error))
        self._fit_boxes(frame.plan.scene)
        self._added.clear()
        self._obstacles.show_edges(self.sizes.shows_edges)
        scene, number = frame.plan.scene, self._obstacles.chosen
        if frame.current and (scene, number) != self._noted:
            self._noted = scene, number
            chosen = scene.obstacles[number] if number < len(scene.obstacles) else None
            current = len(scene.obstacles) == len(self._obstacles.shown)
            self.sizes.describe(
                chosen if current and isinstance(chosen, MeshShape) else None, scene
            )

    def _fit_boxes(self, scene: Scene) -> None:
        """Name the unit of the scene's lengths in the labels; their steps follow the workspace."""
        unit, step = scene.unit, length_step(scene)
        if (unit, step, scene.workspace) == self._fitted:
            return
        self._fitted = unit, step, scene.workspace
        for name, box in self._end_boxes.items():
            box.handle.hint = f"{_END_HINT.format(name)} {_ranges(scene)}"
        for name, box in {**self._end_boxes, "position": self._position}.items():
            box.handle.label = f"{name} [{unit}]"
            box.handle.step = step
        self.sizes.fit(unit, step)

    def _note_press(self, event: object) -> None:
        self._pressed = True
        self._wake(event)

    def _change(self, action: str, scene: Scene) -> None:
        """Add, duplicate or delete."""
        obstacles = self._obstacles
        if action == "Add":
            self._add_apart(_new_obstacle(self.kind.value, scene), scene)
        elif action == "Duplicate" and obstacles.shown:
            self._add_apart(scene.obstacles[min(obstacles.chosen, len(scene.obstacles) - 1)], scene)
        elif action == "Delete" and obstacles.shown:
            obstacles.remove(obstacles.chosen)
            self._removed = obstacles.chosen
        obstacles.choose(max(len(obstacles.shown) - 1, 0))
        self._forget()

    def _add_apart(self, obstacle: Obstacle, scene: Scene) -> None:
        """Add an obstacle at the free place nearest to its own."""
        low, high = obstacle.bounds()
        middle, half = (low + high) / 2, (high - low) / 2
        place = free_place(half, middle, scene, self._occupied(scene))
        self._added.append((place - half, place + half))
        x, y, z = (np.array(obstacle.position) + place - middle).tolist()
        self._obstacles.add(obstacle.model_copy(update={"position": (x, y, z)}))

    def _follow_choice(self) -> None:
        """Choose the same obstacle in the list and in the scene: the newer choice."""
        obstacles = self._obstacles
        names = tuple(
            f"{i} · {one.data.get('file', one.data['shape'])}"
            for i, one in enumerate(obstacles.shown, 1)
        )
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
        one = self._obstacles.shown[number]
        data, gizmo = one.data, one.gizmo
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
                self._fit_again(before, data, scene)
                self._keep_in_place(gizmo, before, data, scene)
        self._shown = {"number": number, "data": dict(data)}
        if (position := self._position.typed(f"{field}.position")) is not None:
            gizmo.position = position
        if (angles := self._angles.typed(f"{field}.wxyz")) is not None:
            gizmo.wxyz = SO3.from_rpy_radians(*np.radians(angles)).wxyz
            self._turned = None
        self._position.show(gizmo.position)
        turned = gizmo.wxyz.tolist()
        if angles is None and turned != self._turned and (shown := _degrees(turned)) is not None:
            self._angles.show(shown)
            self._turned = turned

    def _fit_again(self, before: dict[str, Any], data: dict[str, Any], scene: Scene) -> None:
        """Fit a mesh to the workspace in its new unit, where it was fitted in the one before."""
        surface = self.meshes(scene).surface(data["file"])
        fitted = before["scale"] == fitted_scale(surface, scene, before["unit"]) != 1
        if fitted and data["unit"] != before["unit"]:
            data["scale"] = fitted_scale(surface, scene, data["unit"])
            self.sizes.write(data)

    def _keep_in_place(
        self,
        gizmo: viser.TransformControlsHandle,
        before: dict[str, Any],
        data: dict[str, Any],
        scene: Scene,
    ) -> None:
        """Keep a mesh's middle in place as its size changes; its file's origin may be anywhere."""
        surface = self.meshes(scene).surface(data["file"])
        middle = _middle(surface)
        growth = _factor(data, surface, scene) - _factor(before, surface, scene)
        position = np.asarray(gizmo.position)
        position = position - growth * SO3(np.asarray(gizmo.wxyz)).apply(middle)
        if np.isfinite(position).all():
            gizmo.position = position


def _ranges(scene: Scene) -> str:
    """Ranges of the workspace's coordinates as a sentence."""
    ranges = (
        f"{axis} from {format_setting(low)} to {format_setting(high)}"
        for axis, low, high in zip("xyz", scene.workspace.min, scene.workspace.max, strict=True)
    )
    return f"In the workspace: {', '.join(ranges)} {scene.unit}."


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


def _factor(data: dict[str, Any], surface: Surface, scene: Scene) -> float:
    """Lengths of the scene, [unit], per length of a mesh file."""
    return float(data["scale"] * file_factor(surface, data["unit"], scene.unit))


def _new_obstacle(kind: str, scene: Scene) -> Obstacle:
    """An obstacle of a sixth of the workspace, above its middle."""
    length = max(scene.workspace.size) / 6
    x, y, z = (
        a + share * (b - a)
        for a, b, share in zip(
            scene.workspace.min, scene.workspace.max, (0.5, 0.5, 0.75), strict=True
        )
    )
    return PRIMITIVES[kind].of_length(length, (x, y, z))

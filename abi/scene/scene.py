"""The scene: workspace, obstacles, start, goal and the settings of every stage.

A scene is frozen, hashable and compares by value. It is what a scene file holds, what the panels
of the visualiser read, and the only input of a plan.
"""

import json
import os
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, ValidationInfo, field_validator, model_validator

from abi import assets
from abi.errors import MISSING, SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacles
from abi.obstacles.per_shape import per_shape
from abi.obstacles.pose import LARGEST, METRES, Vec3
from abi.obstacles.triangle_mesh.mesh_source import Files, MeshSource
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import SHIPPED
from abi.scene import scene_archive
from abi.scene.arm_end import (
    ENDS,
    check_said_once,
    check_said_so,
    with_arm_ends,
    without_stale_ends,
)
from abi.scene.arm_settings import ArmSettings
from abi.scene.field_errors import first_error
from abi.scene.leg import (
    MOST_LEGS,
    Leg,
    check_held_alike,
    held_on_first_leg,
    with_first_leg,
)
from abi.scene.numpy_data import plain, plain_fields
from abi.scene.scene_changes import (
    changed_value,
    with_files,
    without_stale_arm,
    without_stale_grasp,
    without_stale_meshes,
)
from abi.scene.scene_file import ENDINGS, parse, read_file, write
from abi.scene.section import Settings
from abi.scene.settings import (
    Count,
    MeshSettings,
    MotionSettings,
    QuadraticSettings,
    SearchSettings,
    SplineSettings,
    Workspace,
)
from abi.scene.task_checks import check_tasks

MOST_OBSTACLES = 5_000
"""Largest number of obstacles of a scene; the first plan with so many takes about a second."""


def _in_unit(unit: str, shape: MeshShape) -> MeshShape | SceneError:
    """A mesh in a scene of this unit, or the fault that prevents it."""
    try:
        return shape.in_unit(unit)
    except SceneError as error:
        return error


_IN_UNIT = {unit: per_shape(partial(_in_unit, unit)) for unit in METRES}


class Scene(Settings):
    """Everything that a plan depends on: workspace, ends, obstacles and settings.

    A scene is frozen and compares by value. Lengths are in its ``unit``, points in the world frame.
    :func:`load_scene`, :meth:`from_dict` and :meth:`replace` make one, and say what is wrong if a
    field is.
    """

    version: Annotated[Count, Field(ge=1, le=1)]
    unit: Literal["m", "cm", "mm"] = "cm"
    workspace: Workspace = Workspace()
    start: Vec3 = (0.0, 0.0, 0.0)
    goal: Vec3 = (6.0, 6.0, 6.0)
    obstacles: Obstacles = ()
    mesh: MeshSettings = MeshSettings()
    search: SearchSettings = SearchSettings()
    spline: SplineSettings = SplineSettings()
    quadratic: QuadraticSettings = QuadraticSettings()
    motion: MotionSettings = MotionSettings()
    arm: ArmSettings = ArmSettings()
    tasks: Annotated[tuple[Leg, ...], Field(max_length=MOST_LEGS)] = ()

    @field_validator("obstacles", mode="before")
    @classmethod
    def _can_be_planned(cls, obstacles: object) -> object:
        if isinstance(obstacles, list | tuple) and len(obstacles) > MOST_OBSTACLES:
            expected = f"at most {MOST_OBSTACLES:,} of them: more cannot be planned in time"
            raise SceneError("obstacles", len(obstacles), expected)
        return obstacles

    @field_validator("obstacles")
    @classmethod
    def _scale_meshes(cls, obstacles: Obstacles, info: ValidationInfo) -> Obstacles:
        scaled = list(obstacles)
        meshes = [k for k, shape in enumerate(obstacles) if isinstance(shape, MeshShape)]
        in_unit = _IN_UNIT[info.data.get("unit", "m")]([obstacles[k] for k in meshes])
        first_of: dict[str, MeshShape] = {}
        for index, shape in zip(meshes, in_unit, strict=True):
            if isinstance(shape, SceneError):
                raise SceneError(f"obstacles[{index}].{shape.field}", shape.value, shape.expected)
            first = first_of.setdefault(shape.file, shape).surface
            if first is not shape.surface and first != shape.surface:
                expected = "another name: an obstacle before it has this one with other content"
                raise SceneError(f"obstacles[{index}].file", shape.file, expected)
            scaled[index] = shape
        return tuple(scaled)

    @field_validator("arm")
    @classmethod
    def _open_gripper(cls, arm: ArmSettings, info: ValidationInfo) -> ArmSettings:
        if not isinstance(arm.gripper, str):
            return arm
        metres = METRES[info.data.get("unit", "m")]
        held = arm.held("arm.gripper", arm.gripper, metres)
        return arm.model_copy(update={"gripper": held})

    @field_validator("tasks")
    @classmethod
    def _open_grippers(cls, tasks: tuple[Leg, ...], info: ValidationInfo) -> tuple[Leg, ...]:
        arm, metres = info.data.get("arm"), METRES[info.data.get("unit", "m")]
        if arm is None:
            return tasks
        found = []
        for number, leg in enumerate(tasks):
            if isinstance(leg.gripper, str):
                held = arm.held(f"tasks[{number}].gripper", leg.gripper, metres)
                leg = leg.model_copy(update={"gripper": held})
            found.append(leg)
        return tuple(found)

    @field_validator("arm")
    @classmethod
    def _scale_attached(cls, arm: ArmSettings, info: ValidationInfo) -> ArmSettings:
        if not isinstance(arm.attached, MeshShape):
            return arm
        scaled = _in_unit(info.data.get("unit", "m"), arm.attached)
        if isinstance(scaled, SceneError):
            raise SceneError(f"arm.attached.{scaled.field}", scaled.value, scaled.expected)
        return arm.model_copy(update={"attached": scaled})

    @model_validator(mode="before")
    @classmethod
    def _move_ends(cls, data: object) -> object:
        return with_arm_ends(with_first_leg(data)) if isinstance(data, dict) else data

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        arm, tasks = held_on_first_leg(self.arm, self.tasks)
        object.__setattr__(self, "arm", arm)  # frozen from here on
        object.__setattr__(self, "tasks", tasks)
        for end in ENDS:
            place = self.arm.tool_at(end, METRES[self.unit])
            if place is not None:  # what the arm's joints or pose say counts
                object.__setattr__(self, end, place)
        for name in ("start", "goal"):
            point = getattr(self, name)
            if not (bounds := self.workspace.left_bounds(point, self.unit)):
                continue
            if getattr(self.arm, name) is not None:
                expected = f"the tool tip in the workspace, {bounds}"
                raise SceneError(f"arm.{name}", f"the tool tip at {point}", expected)
            if name not in self.model_fields_set:  # a default, which nobody has given
                expected = f"a point of the workspace, as the default {point} is outside"
                raise SceneError(name, MISSING, expected)
            raise SceneError(name, point, bounds)
        self.arm.check_gripper(METRES[self.unit])
        self.arm.check_allowed(len(self.obstacles))
        check_tasks(self.tasks, self.arm, self.obstacles, self.workspace, self.unit)
        nodes = self.mesh.node_count(self.workspace)
        if nodes > self.mesh.max_nodes:
            coarsest = self.mesh.model_copy(update={"pitch": LARGEST}).node_count(self.workspace)
            if coarsest > self.mesh.max_nodes:
                expected = f"at least {coarsest:,}, the nodes of the coarsest mesh"
                raise SceneError("mesh.max_nodes", self.mesh.max_nodes, expected)
            raise SceneError(
                "mesh.pitch",
                self.mesh.pitch,
                f"at least {self.mesh.finest_pitch(self.workspace):g} {self.unit}: less takes more "
                f"nodes than mesh.max_nodes, {self.mesh.max_nodes:,}",
            )
        return self

    @property
    def robot(self) -> Robot:
        """The robot that is the arm, with the object that it holds; only of a URDF arm."""
        return self.arm.with_attached(METRES[self.unit])

    @classmethod
    def from_dict(cls, data: object, folder: Path | Files | MeshSource | None = None) -> Self:
        """Build a scene from plain data, and check every field.

        Args:
            data: a mapping with the fields of a scene file. Numbers may be numpy's; an array (4, 4)
                is a pose, as ``start``, ``goal``, or ``pose`` of an obstacle; an obstacle may be a
                mesh of trimesh, where it stands.
            folder: source of its mesh files: the folder of the scene file, outside which nothing is
                opened, or the content of each file by its name. None for a scene without files.

        Raises:
            SceneError: a field is wrong; names the first such field.
        """
        if not isinstance(data, dict):
            raise SceneError("scene", data, "a mapping with version: 1")
        plain_data = plain_fields(data)
        check_said_once(plain_data)
        scene = cls._checked(plain_data, MeshSource.of(folder))
        check_said_so(plain_data, scene.arm, {name: getattr(scene, name) for name in ENDS})
        check_held_alike(plain_data, scene.arm, METRES[scene.unit])
        return scene

    @classmethod
    def _checked(cls, data: dict[str, Any], meshes: MeshSource) -> Self:
        try:
            return cls.model_validate(data, context={"meshes": meshes})
        except ValidationError as error:
            raise first_error(error, cls) from None

    def to_dict(self) -> dict[str, Any]:
        """Plain data that :meth:`from_dict` reads, with all defaults filled in."""
        plain: dict[str, Any] = json.loads(self.model_dump_json())
        return plain

    @property
    def meshes(self) -> MeshSource:
        """Files of the scene by name, as they were read: the surfaces of its meshes, its robot."""
        shapes = self._mesh_shapes
        files: dict[str, object] = {shape.file: shape.surface for shape in shapes}
        if self.arm.model == "urdf" and self.arm.urdf not in SHIPPED:
            files[self.arm.urdf] = self.arm.whole_robot
        return MeshSource(files)

    @property
    def _mesh_shapes(self) -> list[MeshShape]:
        """Its obstacles, and what its arm holds, that are meshes."""
        solids = (*self.obstacles, self.arm.attached)
        return [shape for shape in solids if isinstance(shape, MeshShape)]

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on its files: units of meshes, and what is planned, left out or repaired.

        The last ones name fields that say something of another arm, or another search, only.
        """
        told = [*self._notes(self.arm.notes(METRES[self.unit]))]
        if self.arm.unused:
            named = ", ".join(f"arm.{name}" for name in self.arm.unused)
            told.append(f"Not used, as arm.model is {self.arm.model}: {named}.")
        if self.arm.start is not None or self.arm.goal is not None or self.arm.search == "joints":
            given = {"arm.avoid": self.arm.avoid, "motion.curve": self.motion.curve == "auto"}
            if passed := ", ".join(name for name, is_usual in given.items() if not is_usual):
                told.append(f"Not used, as the motion is sought among the joints: {passed}.")
        return tuple(told)

    @property
    def file_notes(self) -> tuple[str, ...]:
        """Sentences on its files: units of meshes, and what is left out or repaired."""
        return self._notes(self.arm.file_notes)

    def _notes(self, on_arm: Sequence[str]) -> tuple[str, ...]:
        """Sentences on its meshes, and some on its arm, each with the name of the file."""
        sentences = (f"{one.file}: {note}" for one in self._mesh_shapes for note in one.notes)
        return tuple(dict.fromkeys((*sentences, *(f"{self.arm.urdf}: {note}" for note in on_arm))))

    def replace(self, files: Files | None = None, **changes: Any) -> Self:
        """Return a copy with changed fields, or the scene itself if nothing differs.

        Only fields that differ, and those that depend on them, are checked again, so that this can
        run at every movement of a drag.

        Args:
            files: content of files by name, for meshes and an arm that name a new file, or one
                that has changed; an arm's own meshes come with its URDF.
            changes: plain data by field. A dict changes fields of a section; ``obstacles`` may also
                be a sequence of the scene's own objects.

        Raises:
            SceneError: a field is wrong; names it.
        """
        if not isinstance(files, Mapping | None):
            raise SceneError("files", files, "the content of each file by its name")
        given = MeshSource(files)
        data: dict[str, Any] = dict(vars(self))
        for name, change in changes.items():
            data[name] = changed_value(data.get(name), plain(name, change))
        data["arm"] = without_stale_grasp(data, changes, self.tasks)
        data = without_stale_ends(data, vars(self))
        data["obstacles"] = without_stale_meshes(data["obstacles"], given)
        if given.files:
            data["arm"] = without_stale_arm(data["arm"], given, with_files(self.meshes, given))
        if len(data) == len(type(self).model_fields) and all(
            data[name] is value for name, value in vars(self).items()
        ):
            return self
        return self._checked(data, with_files(self.meshes, given))

    def pack(self) -> bytes:
        """Pack the scene, its meshes and its arm into a zip archive for :func:`load_scene`.

        The scene that this loads is equal. Meshes are stored as the triangles of their files, not
        as the bytes.

        Raises:
            SceneError: the archive would be too large to be read again.
        """
        return scene_archive.pack(self.to_dict(), self.meshes.files)

    def save(self, path: str | Path) -> None:
        """Write a scene file; if that fails, an existing file is unchanged.

        Args:
            path: file to write; its ending decides between YAML and JSON.

        Raises:
            SceneError: the file cannot be written, or :func:`load_scene` would refuse it.
        """
        if not isinstance(path, str | os.PathLike):
            raise SceneError("path", path, "the file to write, such as 'mine.yaml'")
        write(self.to_dict(), Path(path))


def load_scene(name_or_path: str | Path) -> Scene:
    """Load a shipped scene by its name, or a scene file.

    Args:
        name_or_path: name of a shipped scene (see :func:`scene_names`), or path of a ``.yaml``,
            ``.yml`` or ``.json`` file, or of a ``.zip`` that holds a scene with its meshes and its
            arm (:mod:`abi.scene.scene_archive`).

    Raises:
        SceneError: there is no such scene, the file is not readable, or a field is wrong.
    """
    if not isinstance(name_or_path, str | os.PathLike):
        raise SceneError("scene", name_or_path, "the name or path of one, such as 'paper'")
    shipped = scene_names()
    if str(name_or_path) in shipped:
        path = assets.path("scenes", f"{name_or_path}.yaml")
        return Scene.from_dict(parse(path), path.parent)
    path = Path(name_or_path)
    if not path.suffix and not os.path.lexists(path):
        raise SceneError("scene", str(name_or_path), f"a file or one of {', '.join(shipped)}")
    if path.suffix.lower() not in (*ENDINGS, scene_archive.SUFFIX):
        raise SceneError("scene", str(path), "a file that ends in .yaml, .yml, .json or .zip")
    if path.suffix.lower() == scene_archive.SUFFIX:
        data, files = scene_archive.unpack(read_file(path, scene_archive.MAX_BYTES), path.name)
        return Scene.from_dict(data, MeshSource(files))
    return Scene.from_dict(parse(path), path.parent)


def require_scene(value: object) -> None:
    """Raise a SceneError for anything but a scene."""
    if not isinstance(value, Scene):
        raise SceneError("scene", value, "a Scene, such as abi.load_scene('paper')")


def scene_names() -> tuple[str, ...]:
    """Names of the shipped scenes, ``paper`` first."""
    names = sorted(path.stem for path in assets.path("scenes").glob("*.yaml"))
    return tuple(sorted(names, key=lambda name: name != "paper"))

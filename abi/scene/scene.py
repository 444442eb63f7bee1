"""The scene: workspace, obstacles, start, goal and the settings of every stage.

A scene is frozen, hashable and compares by value. It is what a scene file holds, what the panels
of the visualiser read, and the only input of a plan.
"""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    Strict,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from abi import assets
from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacles
from abi.obstacles.pose import LARGEST, Length, Vec3
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.surface import Surface
from abi.robot.robot import Robot, joints_to, usual_tip
from abi.robot.robot_files import SHIPPED, load_robot
from abi.scene import scene_archive
from abi.scene.field_errors import first_error
from abi.scene.scene_changes import changed_value, without_stale_meshes
from abi.scene.scene_file import parse, read_file, write

Lattice = Literal["bcc", "kuhn", "delaunay"]
Elbow = Literal["up", "down"]
Algorithm = Literal["a_star", "dijkstra", "bellman_ford"]
Count = Annotated[int, Strict()]
Number = Annotated[float, Strict(), Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
Rate = Annotated[float, Strict(), Field(allow_inf_nan=False, ge=1e-6, le=1e6)]
Rates = tuple[Rate, Rate, Rate]

MOST_OBSTACLES = 5_000
"""Obstacles that a scene may have: their first plan takes about a second."""
FINEST_PITCH = 1e-6
"""Smallest pitch, [unit]: the shortest side that a workspace may have."""


class _Settings(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True)


class Workspace(_Settings):
    """The box that is meshed, axis-aligned; corners ``min`` and ``max`` in [unit], world."""

    min: Vec3 = (0.0, 0.0, 0.0)
    max: Vec3 = (6.0, 6.0, 6.0)

    @model_validator(mode="after")
    def _has_volume(self) -> Self:
        if any(high - low < 1e-6 for low, high in zip(self.min, self.max, strict=True)):
            raise SceneError("workspace.max", self.max, f"every number above min {self.min}")
        return self

    @property
    def size(self) -> Vec3:
        """Edge lengths, [unit]."""
        x, y, z = (high - low for low, high in zip(self.min, self.max, strict=True))
        return (x, y, z)

    def contains(self, point: Vec3) -> bool:
        """Whether ``point`` lies in the closed box."""
        return all(a <= p <= b for a, p, b in zip(self.min, point, self.max, strict=True))


class MeshSettings(_Settings):
    """Stage 1. ``pitch`` is the distance between neighbouring nodes, [unit]."""

    lattice: Lattice = "bcc"
    pitch: Annotated[Number, Field(ge=FINEST_PITCH)] = 1.2
    seed: Annotated[Count, Field(ge=0, le=2**32 - 1)] = 0
    max_nodes: Annotated[Count, Field(ge=8, le=20_000_000)] = 1_000_000

    def cells(self, workspace: Workspace) -> tuple[int, int, int]:
        """Cells along each axis, as nearly cubes as the box allows.

        In the body-centred lattice the nearest neighbours are half a cube's diagonal apart, so
        its cubes are 2/√3 times the pitch.
        """
        cube = self.pitch * (2 / math.sqrt(3) if self.lattice == "bcc" else 1.0)
        x, y, z = (max(1, round(size / cube)) for size in workspace.size)
        return (x, y, z)

    def node_count(self, workspace: Workspace) -> int:
        """Number of mesh nodes this pitch gives, before any memory is taken."""
        x, y, z = self.cells(workspace)
        return (x + 1) * (y + 1) * (z + 1) + (x * y * z if self.lattice == "bcc" else 0)

    def finest_pitch(self, workspace: Workspace) -> float:
        """Smallest pitch, to three digits, whose mesh keeps within ``max_nodes``.

        The largest there is where none does.
        """
        low, high = FINEST_PITCH, min(max(workspace.size) * 2, LARGEST)
        for _ in range(80):
            middle = math.sqrt(low * high)
            fits = self.model_copy(update={"pitch": middle}).node_count(workspace) <= self.max_nodes
            low, high = (low, middle) if fits else (middle, high)
        digits = 2 - math.floor(math.log10(high))
        return float(math.ceil(high * 10**digits) / 10**digits)


class SearchSettings(_Settings):
    """Stage 3. All three algorithms run; ``algorithm`` chooses whose path goes on.

    ``taut`` pulls that path taut before the curves are made of it (stage 3½); the paper does not.
    """

    algorithm: Algorithm = "a_star"
    weight: Literal["length", "hops"] = "length"
    taut: Annotated[bool, Strict()] = True


class SplineSettings(_Settings):
    """Stage 4. ``clearance`` is the distance to keep from every obstacle, [unit]."""

    degree: Annotated[Count, Field(ge=2, le=5)] = 4
    clearance: Annotated[Number, Field(ge=0)] = 0.2


class QuadraticSettings(_Settings):
    """Stage 5, the curve: nearest to the B-spline, the clear one nearest to that, or pieces."""

    mode: Literal["least_squares", "clear", "pieces"] = "least_squares"


class MotionSettings(_Settings):
    """Stage 5, the motion: cruise speed [unit/s], acceleration and deceleration [unit/s²].

    ``curve`` is the one the tool follows; ``auto`` is the quadratic when it keeps the clearance,
    the B-spline otherwise. ``law`` is the paper's three phases, those slowed down until the joints'
    limits hold, the fastest motion under these limits, or one of limited jerk [unit/s³].
    ``joint_acceleration`` limits each joint, [rad/s²], sliding ones [m/s²].
    """

    speed: Rate = 4.0
    acceleration: Rate = 6.0
    deceleration: Rate = 6.0
    curve: Literal["auto", "quadratic", "bspline"] = "auto"
    law: Literal["three_phase", "slowed", "time_optimal", "jerk_limited"] = "three_phase"
    joint_acceleration: Rate = 8.0
    jerk: Rate = 40.0


class ArmSettings(_Settings):
    """Stage 6. Link lengths and base position in [unit]; ``q5`` is the initial extension, [unit].

    ``model`` is the paper's ``abi``, or ``urdf``: a shipped arm's name, or a ``.urdf`` or ``.zip``
    file. Of that, ``tip`` is the link whose origin is the tool, and ``axis`` the direction that
    the tip's z axis is held to, None for any; what else there is but ``base`` is the paper's.
    With ``avoid`` the plan keeps the whole arm clear, its links ``clearance`` [unit] from every
    obstacle; ``elbow`` auto takes the branch with the shorter path.
    ``forces``, ``masses`` and ``radii`` are the paper's Q4..Q6, m4..m6 and i4..i6: the generalised
    forces [kg·unit²/s² for q4 and q6, kg·unit/s² for q5], masses [kg] and radii of inertia [unit].
    """

    model: Literal["abi", "urdf"] = "abi"
    urdf: Annotated[str, Strict(), Field(min_length=1, max_length=200)] = "ur5e"
    tip: Annotated[str, Strict(), Field(max_length=100)] | None = None
    axis: Vec3 | None = None
    base: Vec3 = (3.0, -3.0, 0.0)
    a1: Length = 1.0
    a2: Length = 2.0
    a3: Length = 6.0
    a4: Length = 3.0
    a5: Length = 2.5
    elbow: Literal["up", "down", "auto"] = "up"
    avoid: Annotated[bool, Strict()] = True
    clearance: Annotated[Number, Field(ge=0)] = 0.0
    q5: Annotated[Number, Field(ge=0)] = 0.0
    forces: Vec3 = (0.0, 0.0, 0.0)
    masses: Rates = (1.0, 1.0, 1.0)
    radii: Rates = (1.0, 1.0, 1.0)
    dynamics: Literal["corrected", "as_printed"] = "corrected"

    _robot: Robot | None = PrivateAttr(None)

    @model_validator(mode="after")
    def _load(self, info: ValidationInfo) -> Self:
        if self.axis is not None and not any(self.axis):
            raise SceneError("arm.axis", self.axis, "a direction, or none for any")
        if self.model == "urdf":
            meshes = (info.context or {}).get("meshes", MeshSource())
            self._robot = load_robot(self.urdf, meshes)
            joints_to(self._robot, self.tool)
        return self

    @property
    def robot(self) -> Robot:
        """The arm that ``urdf`` names, where that is the model."""
        assert self._robot is not None
        return self._robot

    @property
    def tool(self) -> str:
        """Name of the link whose origin is the tool: ``tip``, or what is usual for the arm."""
        return self.tip or SHIPPED.get(self.urdf) or usual_tip(self.robot)

    @property
    def branches(self) -> tuple[Elbow, ...]:
        """Elbow branches that may be taken, the preferred first."""
        return ("up", "down") if self.elbow == "auto" else (self.elbow,)

    def on(self, elbow: Elbow) -> Self:
        """The same on one branch."""
        return self if self.elbow == elbow else self.model_copy(update={"elbow": elbow})


class Scene(_Settings):
    """Everything a plan depends on."""

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

    @field_validator("obstacles", mode="before")
    @classmethod
    def _can_be_planned(cls, obstacles: object) -> object:
        if isinstance(obstacles, list | tuple) and len(obstacles) > MOST_OBSTACLES:
            expected = f"at most {MOST_OBSTACLES:,} of them, more are not planned in time"
            raise SceneError("obstacles", len(obstacles), expected)
        return obstacles

    @field_validator("obstacles")
    @classmethod
    def _scale_meshes(cls, obstacles: Obstacles, info: ValidationInfo) -> Obstacles:
        scaled = list(obstacles)
        first_of: dict[str, MeshShape] = {}
        for index, shape in enumerate(obstacles):
            if not isinstance(shape, MeshShape):
                continue
            if first_of.setdefault(shape.file, shape).surface != shape.surface:
                expected = "another name, an obstacle before it has this one with other content"
                raise SceneError(f"obstacles[{index}].file", shape.file, expected)
            try:
                scaled[index] = shape.in_unit(info.data.get("unit", "m"))
            except SceneError as error:
                field = f"obstacles[{index}].{error.field}"
                raise SceneError(field, error.value, error.expected) from None
        return tuple(scaled)

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        for name in ("start", "goal"):
            point = getattr(self, name)
            for axis, number, low, high in zip(
                "xyz", point, self.workspace.min, self.workspace.max, strict=True
            ):
                if not low <= number <= high:
                    raise SceneError(name, point, f"{axis} between {low:g} and {high:g}")
        nodes = self.mesh.node_count(self.workspace)
        if nodes > self.mesh.max_nodes:
            coarsest = self.mesh.model_copy(update={"pitch": LARGEST}).node_count(self.workspace)
            if coarsest > self.mesh.max_nodes:
                expected = f"at least {coarsest:,}, the nodes of the coarsest mesh"
                raise SceneError("mesh.max_nodes", self.mesh.max_nodes, expected)
            raise SceneError(
                "mesh.pitch",
                self.mesh.pitch,
                f"at least {self.mesh.finest_pitch(self.workspace):g}: this pitch takes {nodes:,} "
                f"nodes and mesh.max_nodes is {self.mesh.max_nodes:,}",
            )
        return self

    @classmethod
    def from_dict(
        cls, data: object, folder: Path | Mapping[str, bytes] | MeshSource | None = None
    ) -> Self:
        """Check ``data`` (as a scene file holds it) and build the scene.

        Args:
            data: plain data.
            folder: source of its mesh files: the folder of the scene file, outside which nothing is
                opened, or the content of each by its name. None for a scene without.

        Raises:
            SceneError: names the first field that is wrong.
        """
        if not isinstance(data, dict):
            raise SceneError("scene", data, "a mapping with version: 1")
        try:
            return cls.model_validate(data, context={"meshes": MeshSource.of(folder)})
        except ValidationError as error:
            raise first_error(error, cls) from None

    def to_dict(self) -> dict[str, Any]:
        """Plain data that :meth:`from_dict` reads, defaults filled in."""
        plain: dict[str, Any] = json.loads(self.model_dump_json())
        return plain

    @property
    def meshes(self) -> MeshSource:
        """Surfaces of its meshes, and its arm as an archive, by file name."""
        shapes = [shape for shape in self.obstacles if isinstance(shape, MeshShape)]
        files: dict[str, bytes | Surface] = {shape.file: shape.surface for shape in shapes}
        if self.arm.model == "urdf" and self.arm.urdf not in SHIPPED:
            files[self.arm.urdf] = self.arm.robot.archive
        return MeshSource(files)

    def replace(self, files: Mapping[str, bytes | Surface] | None = None, **changes: Any) -> Self:
        """The scene with changed fields; itself where they equal its own.

        Only fields that differ are checked again, and those that belong together: a panel may be
        read at each movement of a hand.

        Args:
            files: content of mesh files by name, for obstacles that name a new one; the scene's
                own meshes need none.
            changes: plain data by field; a dict changes fields of a section, and obstacles may be
                given as they are.

        Raises:
            SceneError: names the field that is wrong.
        """
        data: dict[str, Any] = dict(vars(self))
        for name, change in changes.items():
            data[name] = changed_value(data.get(name), change)
        data["obstacles"] = without_stale_meshes(data["obstacles"], files or {})
        if len(data) == len(type(self).model_fields) and all(
            data[name] is value for name, value in vars(self).items()
        ):
            return self
        return self.from_dict(data, MeshSource({**self.meshes.files, **(files or {})}))

    def pack(self) -> bytes:
        """The scene, its meshes and its arm as one zip archive, which :func:`load_scene` reads.

        Raises:
            SceneError: it is too large to be read again.
        """
        files = self.meshes.files
        surfaces = {name: one for name, one in files.items() if isinstance(one, Surface)}
        arms = {name: one for name, one in files.items() if isinstance(one, bytes)}
        return scene_archive.pack(self.to_dict(), surfaces, arms)

    def save(self, path: str | Path) -> None:
        """Write a scene file, YAML or JSON by its ending; the old file stays whole on failure.

        Raises:
            SceneError: it cannot be written, or :func:`load_scene` would refuse it.
        """
        write(self.to_dict(), Path(path))


def load_scene(name_or_path: str | Path) -> Scene:
    """Load a shipped scene by its name, or a scene file (``.yaml``, ``.yml`` or ``.json``).

    A ``.zip`` holds a scene with its meshes and its arm (:mod:`abi.scene.scene_archive`).

    Raises:
        SceneError: no such scene, not readable, or a field is wrong.
    """
    shipped = scene_names()
    if str(name_or_path) in shipped:
        path = assets.path("scenes", f"{name_or_path}.yaml")
        return Scene.from_dict(parse(path), path.parent)
    path = Path(name_or_path)
    if not path.suffix:
        raise SceneError("scene", str(name_or_path), f"a file or one of {', '.join(shipped)}")
    if path.suffix.lower() == scene_archive.SUFFIX:
        data, files = scene_archive.unpack(read_file(path, scene_archive.MAX_BYTES), path.name)
        return Scene.from_dict(data, files)
    return Scene.from_dict(parse(path), path.parent)


def scene_names() -> tuple[str, ...]:
    """Names of the shipped scenes, ``paper`` first."""
    names = sorted(path.stem for path in assets.path("scenes").glob("*.yaml"))
    return tuple(sorted(names, key=lambda name: name != "paper"))

"""Settings of the arm: which arm, where it stands, what it holds, and what it keeps clear of."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    BeforeValidator,
    Field,
    PrivateAttr,
    Strict,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)

from abi.errors import SceneError
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.pose import UNTURNED, Length, Quaternion, Vec3, rotation
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.attached_object import STANDING, with_object
from abi.robot.gripper import Opening, gripper_at
from abi.robot.urdf.held_joints import (
    held_in_metres,
    planned_joints,
    planned_sentence,
    positions_held,
)
from abi.robot.urdf.joint import Joint
from abi.robot.urdf.robot import Robot, bases_to, joints_to, part_from
from abi.robot.urdf.robot_files import SHIPPED, file_of, load_robot
from abi.robot.urdf.tip_pose import tip_pose
from abi.robot.urdf.urdf_joints import some_of
from abi.robot.urdf.usual_tip import usual_tip
from abi.scene.arm_end import ENDS, ArmEnd
from abi.scene.held_axis import Axis, HeldAxis, check_axis
from abi.scene.section import Settings
from abi.scene.settings import Flag, Number, Rates, as_python

Elbow = Literal["up", "down"]


def _end(value: object) -> object:
    """Parse a list of joint positions as the fields of an end."""
    return {"joints": value} if isinstance(value, list | tuple) else value


def _opening(value: object, check: ValidatorFunctionWrapHandler) -> Any:
    """Keep ``open`` and ``closed`` until the unit of lengths is known."""
    return value if value in ("open", "closed") else check(value)


HeldJoints = Annotated[
    dict[Annotated[str, Strict()], Number], Field(max_length=150), WrapValidator(_opening)
]
"""Positions of joints by name; once a scene is checked, ``open`` and ``closed`` are resolved."""


def _joints_above(robot: Robot, link: str) -> Iterator[Joint]:
    """Joints that carry a link, its own first."""
    above = {joint.child: joint for joint in robot.joints}
    while link in above:
        yield above[link]
        link = above[link].parent


def _contact(value: object) -> object:
    """Parse a contact: a link, and another link or the number of an obstacle.

    Raises:
        SceneError: it is anything else.
    """
    pair = [as_python(one) for one in value] if isinstance(value, list | tuple) else []
    if len(pair) == 2 and isinstance(pair[0], str) and type(pair[1]) in (str, int):
        return (*pair,)
    expected = "two names of links, or a link and the number of an obstacle, the first being 0"
    raise SceneError("arm.allowed", value, expected)


AllowedPair = Annotated[tuple[str, str | int], BeforeValidator(_contact)]


_POINT_ALONE = "a point: joints and orientation can be asked only of an arm from a URDF"


ON_MESH = (
    "auto or joints where joints or poses are asked for, by an end or by a leg that begins in "
    "those in which the one before ended: on the mesh only the tool's place is kept"
)

_SAME_JOINT = 1e-6
"""Difference of a joint's positions that counts as none, [rad] or [m]."""
_OF_URDF = ("urdf", "srdf", "tip", "base_link", "gripper", "allowed", "attached", "grasping")
"""Fields that say nothing of the paper's arm."""

_OF_PAPER_ARM = (
    *("a1", "a2", "a3", "a4", "a5", "elbow", "q5"),
    *("forces", "masses", "radii", "dynamics"),
)
"""Fields that say nothing of a URDF."""


class ArmSettings(Settings):
    """Stage 6. Link lengths and base position in [unit]; ``q5`` is the initial extension, [unit].

    ``model`` is ``abi``, the paper's arm, or ``urdf``. In the latter case ``urdf`` names a shipped
    arm, or a ``.urdf`` or ``.zip`` file, ``srdf`` a file with the robot's disabled pairs of links
    and named states, by default the one beside the URDF, ``tip`` is the link whose origin is the
    tool, ``base_link`` the one that stands at ``base``, by default the root; what does not hang
    from it is left out. ``gripper`` holds joints that are not planned at positions by their names,
    [rad], slides in [unit], or is ``open`` or ``closed``; without it they rest nearest to 0.
    ``allowed`` are pairs of links, or of a link and the number of an obstacle from 0, that may
    touch. ``axis`` is the direction in which the tip's z axis must point, None for any, exactly and
    throughout or as :class:`abi.scene.held_axis.HeldAxis` says, and ``base_wxyz`` the orientation
    of the base link, as a quaternion. All fields not named here but ``base`` belong to the paper's
    arm. With ``avoid`` the plan keeps the whole arm clear, its links
    ``clearance`` [unit] from every obstacle; ``elbow`` auto takes the branch with the shorter path.
    ``forces``, ``masses`` and ``radii`` are the paper's Q4..Q6, m4..m6 and i4..i6: the generalised
    forces [kg·unit²/s² for q4 and q6, kg·unit/s² for q5], masses [kg] and radii of inertia [unit].

    ``attached`` is an object that the tip holds, a shape whose pose is that in the tip's frame.
    While it is taken or set down, with ``grasping``, it counts as 1 mm smaller, so that it may
    stand, and it and the links behind the last joint need not keep ``clearance``, only not touch.
    ``start`` and ``goal`` say more than the places of the tool: the joints there, or the tool's
    orientation, too. ``search`` is where a motion is sought: on the mesh of places of the tool, in
    the space of the joints, or by ``auto`` in that if the mesh has none, or joints are asked for.
    """

    model: Literal["abi", "urdf"] = "abi"
    urdf: Annotated[str, Strict(), Field(min_length=1, max_length=200)] = "ur5e"
    srdf: Annotated[str, Strict(), Field(min_length=1, max_length=200)] | None = None
    tip: Annotated[str, Strict(), Field(max_length=100)] | None = None
    base_link: Annotated[str, Strict(), Field(max_length=100)] | None = None
    gripper: HeldJoints = Field(default_factory=dict)
    allowed: Annotated[tuple[AllowedPair, ...], Field(max_length=10_000)] = ()
    attached: Obstacle | None = None
    grasping: Flag = False
    axis: Axis | None = None
    start: Annotated[ArmEnd | None, BeforeValidator(_end)] = None
    goal: Annotated[ArmEnd | None, BeforeValidator(_end)] = None
    search: Literal["auto", "mesh", "joints"] = "auto"
    base: Vec3 = (3.0, -3.0, 0.0)
    base_wxyz: Quaternion = UNTURNED
    a1: Length = 1.0
    a2: Length = 2.0
    a3: Length = 6.0
    a4: Length = 3.0
    a5: Length = 2.5
    elbow: Literal["up", "down", "auto"] = "up"
    avoid: Flag = True
    clearance: Annotated[Number, Field(ge=0)] = 0.0
    q5: Annotated[Number, Field(ge=0)] = 0.0
    forces: Vec3 = (0.0, 0.0, 0.0)
    masses: Rates = (1.0, 1.0, 1.0)
    radii: Rates = (1.0, 1.0, 1.0)
    dynamics: Literal["corrected", "as_printed"] = "corrected"

    _whole: Robot | None = PrivateAttr(None)
    _robot: Robot | None = PrivateAttr(None)

    @model_validator(mode="after")
    def _load(self, info: ValidationInfo) -> Self:
        if "model" not in self.model_fields_set:  # a default that nobody has chosen
            of_urdf = [name for name in _OF_URDF if name in self.model_fields_set]
            if of_urdf:
                expected = f"urdf, to which arm.{of_urdf[0]} belongs, or abi without it"
                raise SceneError("arm.model", None, expected)
        check_axis("arm.axis", self.axis, self.model, self.search)
        if self.model == "abi" and abs(self.base_wxyz[0]) < math.hypot(*self.base_wxyz):
            expected = "[1, 0, 0, 0]: the paper's arm stands upright, only a URDF may be turned"
            raise SceneError("arm.base_wxyz", self.base_wxyz, expected)
        if self.search == "joints" and self.model != "urdf":
            raise SceneError("arm.search", self.search, "auto or mesh for the paper's arm")
        asked = self.start is not None or self.goal is not None or self.search == "joints"
        if self.exact_axis is not None and asked:
            expected = (
                "{direction: [x, y, z], tolerance: 0.1} where joints or poses are asked for: "
                "a direction alone is held exactly, on the mesh"
            )
            raise SceneError("arm.axis", self.exact_axis, expected)
        if self.search == "mesh" and (self.start is not None or self.goal is not None):
            raise SceneError("arm.search", "mesh", ON_MESH)
        if self.model == "urdf":
            meshes = (info.context or {}).get("meshes", MeshSource())
            self._whole = self._robot = load_robot(self.urdf, meshes, srdf=self.srdf)
            if self.base_link is not None:
                self._robot = self._from_base(self._whole, self.base_link)
            joints_to(self._robot, self.tool)
        return self

    def is_read_anew(self, given: MeshSource, source: MeshSource) -> bool:
        """Check whether its robot is another one by files that are given.

        Args:
            given: the files.
            source: these, and what else it may be read of.
        """
        if self.model != "urdf" or self.urdf in SHIPPED:
            return False
        names = self.urdf, file_of(self.urdf), *([self.srdf] if self.srdf else ())
        if {id(given.given(name)) for name in names} <= {id(None), id(self._whole)}:
            return False
        try:
            return load_robot(self.urdf, source, srdf=self.srdf) != self._whole
        except SceneError:  # to be raised where all is checked
            return True

    def __hash__(self) -> int:
        others = (value for name, value in self if name != "gripper")
        return hash((*others, frozenset(self.gripper.items())))

    def held(
        self, field: str, gripper: Mapping[str, float] | Opening, metres: float
    ) -> dict[str, float]:
        """Positions by name, [rad] or [unit], of a gripper that may be given in one word.

        Args:
            field: of the scene that says so, for errors.
            gripper: ``open``, ``closed``, or positions.
            metres: one [unit] of the scene in metres.

        Raises:
            SceneError: the arm has no gripper.
        """
        if not isinstance(gripper, str):
            return dict(gripper)
        if self.model != "urdf":
            raise SceneError(field, gripper, "positions of joints by name")
        at = gripper_at(field, self.robot, self.tool, gripper)
        return held_in_metres(self.robot, at, 1 / metres)

    def check_gripper(self, metres: float) -> None:
        """Raise a SceneError if ``gripper`` names no joint to hold, or exceeds its limits.

        Neither may a named state at an end have other joints elsewhere than they are held, unless
        ``gripper`` says where: the motion would not begin, or end, in that state.

        Args:
            metres: one [unit] of the scene in metres.
        """
        if self.model != "urdf":
            return
        self._still(metres)
        for name, end, wanted, held in self._held_elsewhere(metres):
            other = {one: at for one, at in wanted.items() if one not in self.gripper}
            if other:
                at = some_of([f"{one}: {place:.6g}" for one, place in other.items()], 6)
                first = next(iter(other))
                expected = (
                    f"{at} in arm.gripper, as that state has it; by default "
                    f"{first} is held at {held[first]:.6g}"
                )
                raise SceneError(f"arm.{name}.state", end.state, expected)

    def _still(self, metres: float) -> dict[str, float]:
        """Positions of the joints that are not planned, by name, [rad] or [m].

        Raises:
            SceneError: ``gripper`` names no joint to hold, or exceeds its limits.
        """
        held = held_in_metres(self.robot, self.gripper, metres)
        return positions_held(self.robot, planned_joints(self.robot, self.tool), held)

    def _held_elsewhere(
        self, metres: float
    ) -> Iterator[tuple[str, ArmEnd, dict[str, float], dict[str, float]]]:
        """Ends that are named states with other positions of held joints than those are held at.

        Args:
            metres: one [unit] of the scene in metres.

        Yields:
            Name of an end, the end, and of the held joints that differ the positions that its state
            has and those at which they are held, by name, [rad] or [unit].
        """
        ends: dict[str, ArmEnd | None] = {name: getattr(self, name) for name in ENDS}
        if not any(end is not None and end.state is not None for end in ends.values()):
            return
        still = self._still(metres)
        free = {one.name for one in self.robot.joints if one.follows is None} & still.keys()
        for name, end in ends.items():
            state = self.robot.states.get(end.state or "", {}) if end is not None else {}
            wanted = {
                one: at
                for one, at in state.items()
                if one in free and abs(at - still[one]) > _SAME_JOINT
            }
            if end is not None and wanted:
                here = {one: still[one] for one in wanted}
                of_state, of_gripper = (
                    held_in_metres(self.robot, at, 1 / metres) for at in (wanted, here)
                )
                yield name, end, of_state, of_gripper

    def check_allowed(self, obstacles: int) -> None:
        """Raise a SceneError if ``allowed`` names no link of the arm, or no obstacle.

        Args:
            obstacles: how many the scene has.
        """
        if self.model != "urdf":
            return
        links = self.robot.links
        for pair in self.allowed:
            for one in pair:
                if isinstance(one, str) and one not in links:
                    raise SceneError("arm.allowed", one, f"a link: {some_of(tuple(links), 6)}")
                if not isinstance(one, str) and not 0 <= one < obstacles:
                    expected = f"the number of an obstacle, below {obstacles}"
                    raise SceneError("arm.allowed", one, expected)

    def joints_at(self, name: Literal["start", "goal"], metres: float) -> dict[str, float] | None:
        """Positions of all planned joints that ``start`` or ``goal`` asks for, [rad] or [m].

        None if it asks for none.

        Args:
            name: of the end.
            metres: one [unit] of the scene in metres.

        Raises:
            SceneError: the arm has no such joints, limits or state.
        """
        end: ArmEnd | None = getattr(self, name)
        if end is None or end.is_pose:
            return None
        return end.positions(f"arm.{name}", self.robot, self.tool, metres)

    def tool_at(self, name: Literal["start", "goal"], metres: float) -> Vec3 | None:
        """Tool position that ``start`` or ``goal`` asks for, [unit], world; None for any.

        Args:
            name: of the end.
            metres: one [unit] of the scene in metres.

        Raises:
            SceneError: the arm has no such joints, limits or state.
        """
        end: ArmEnd | None = getattr(self, name)
        if end is None:
            return None
        if self.model != "urdf":
            raise SceneError(f"arm.{name}", end.model_dump(exclude_none=True), _POINT_ALONE)
        joints = self.joints_at(name, metres)
        if joints is None:
            return end.position
        place = tip_pose(self.robot, self.tool, joints)[:3, 3] / metres
        x, y, z = (rotation(self.base_wxyz) @ place + np.array(self.base)).tolist()
        return (x, y, z)

    def notes(self, metres: float) -> tuple[str, ...]:
        """Sentences on a URDF: which link and joints are planned, and what is left out of it.

        Args:
            metres: one [unit] of the scene in metres.
        """
        if self.model != "urdf":
            return ()
        held = held_in_metres(self.robot, self.gripper, metres)
        return (
            planned_sentence(self.robot, self.tool, held),
            *self.state_notes(metres),
            *self.file_notes,
        )

    def state_notes(self, metres: float) -> tuple[str, ...]:
        """Sentences on ends that are named states but for what ``gripper`` holds elsewhere.

        Args:
            metres: one [unit] of the scene in metres.
        """
        if self.model != "urdf":
            return ()
        names = [{one.name for one in robot.joints} for robot in (self.whole_robot, self.robot)]
        ends = ((name, getattr(self, name)) for name in ENDS)
        left_out = [
            f"The {name} is {end.state} but for {one}, which base_link leaves out."
            for name, end in ends
            if end is not None and end.state is not None and self.base_link is not None
            for one in self.robot.states.get(end.state, {})
            if one in names[0] - names[1]
        ]
        return (
            *left_out,
            *(
                f"The {name} is {end.state} but for {one}, which is held at {at[one]:.6g} "
                f"where that state has it at {place:.6g}."
                for name, end, wanted, at in self._held_elsewhere(metres)
                for one, place in wanted.items()
            ),
        )

    @property
    def file_notes(self) -> tuple[str, ...]:
        """Sentences on what is taken, guessed or left out of a URDF."""
        if self.model != "urdf":
            return ()
        links = self.whole_robot.links.values()
        left_out = [one.name for one in links if one.shapes and one.name not in self.robot.links]
        if not left_out:
            return self.robot.notes
        named = f"{self.base_link} does not carry them: {some_of(left_out)}"
        return (*self.robot.notes, f"Left out, so that nothing keeps clear of them, as {named}.")

    @property
    def unused(self) -> tuple[str, ...]:
        """Names of the fields that say something, but of the other model of arm."""
        others = _OF_URDF if self.model == "abi" else _OF_PAPER_ARM
        fields = type(self).model_fields
        usual = {name: fields[name].get_default(call_default_factory=True) for name in others}
        return tuple(name for name in others if getattr(self, name) != usual[name])

    def _from_base(self, robot: Robot, base: str) -> Robot:
        """The part of a robot that its base link carries, the tip among it."""
        named = self.tip or SHIPPED.get(self.urdf)
        part = part_from(robot, base) if base in robot.links else robot
        tip = named or usual_tip(part)
        bases = bases_to(robot, tip)
        if base not in bases and tip in robot.links:
            names = ", ".join(bases) or "none"
            raise SceneError("arm.base_link", base, f"a link from which joints move {tip}: {names}")
        own = {joint.name for joint in part.joints}
        for joint in _joints_above(robot, base):
            if joint.follows is not None and joint.coordinate in own:
                expected = (
                    f"a link that stands still: {joint.name} above it follows {joint.coordinate}"
                )
                raise SceneError("arm.base_link", base, expected)
        return part

    @property
    def robot(self) -> Robot:
        """The robot that ``urdf`` names, or the part on the base link, if that is the model."""
        assert self._robot is not None
        return self._robot

    @property
    def whole_robot(self) -> Robot:
        """The robot that ``urdf`` names, with what its base link does not carry."""
        assert self._whole is not None
        return self._whole

    def with_attached(self, metres: float) -> Robot:
        """The robot with the object that it holds.

        Args:
            metres: one [unit] of the scene in metres.

        Raises:
            SceneError: the object is a flat mesh.
        """
        if self.attached is None:
            return self.robot
        inset = STANDING if self.grasping else 0.0
        return with_object(self.robot, self.tool, self.attached, metres, inset)

    @property
    def tool(self) -> str:
        """Name of the link whose origin is the tool: ``tip``, or the arm's usual one."""
        return self.tip or SHIPPED.get(self.urdf) or usual_tip(self.robot)

    @property
    def exact_axis(self) -> Vec3 | None:
        """Direction that the tip's z axis is held to exactly and throughout; None for none."""
        return None if isinstance(self.axis, HeldAxis) else self.axis

    @property
    def held_axis(self) -> HeldAxis | None:
        """Direction that it is held to within a tolerance, for a part of the motion."""
        return self.axis if isinstance(self.axis, HeldAxis) else None

    @property
    def branches(self) -> tuple[Elbow, ...]:
        """Elbow branches that may be taken, the preferred first."""
        return ("up", "down") if self.elbow == "auto" else (self.elbow,)

    def on(self, elbow: Elbow) -> Self:
        """A copy of the settings with one elbow branch."""
        return self if self.elbow == elbow else self.model_copy(update={"elbow": elbow})

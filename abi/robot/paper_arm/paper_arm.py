"""Stage 6, the arm: link lengths, joint limits, forward kinematics, URDF.

The paper's manipulator (stage 6, Fig. 9): five revolute joints and one prismatic. It stands at
``base``, z up; q1 turns it about the base axis, q2 and q3 move upper arm and forearm in the plane
through that axis, q5 extends the forearm, q4 and q6 turn forearm and gripper about its own axis
and do not move the tool.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from abi import arguments
from abi.arrays import FloatArray, ShortRepr, flat, read_only
from abi.errors import AbiError, SceneError
from abi.obstacles.pose import METRES, UNTURNED, Quaternion, Vec3
from abi.robot.bodies.urdf_writer import joint, write
from abi.robot.kinematics.chain import Chain
from abi.robot.paper_arm import arm_links
from abi.robot.paper_arm.link_capsules import BODIES, LinkCapsule, link_capsules, steepest_bend
from abi.robot.paper_arm.pose_kernels import ArmTable, place_capsules
from abi.robot.urdf.robot_files import packed, robot_from_archive
from abi.robot.urdf.usual_tip import usual_tip

JOINTS = ("q1", "q2", "q3", "q4", "q5", "q6")
"""Names of the joints, in the order of all arrays of joint positions."""

SLIDES = tuple(name == "q5" for name in JOINTS)
"""Flags of the sliding joints."""

JOINT_AXES = tuple((1.0, 0.0, 0.0) if name in ("q2", "q3") else (0.0, 0.0, 1.0) for name in JOINTS)
"""Axis of each joint in its own frame."""

JOINT_SPEED = np.pi
"""Largest speed of the turning joints, nominal, [rad/s]."""

MOVED = 3
"""Number of joints that the inverse kinematics moves, q1 to q3."""

_UNPAIRED = (
    ("upper_arm", "forearm", "drawn into each other where the arm bends far"),
    ("upper_arm", "rod", "drawn into each other where the arm bends far"),
    ("elbow", "rod", "the rod goes in and out through it"),
)
"""Links that no plan compares, and why."""

STROKE = 0.8
"""Longest extension q5 as a fraction of a4: the rest of the rod stays in its sleeve."""


@dataclass(frozen=True, eq=False, repr=False)
class PaperArm(ShortRepr):
    """Geometry and limits of an arm.

    Attributes:
        base: centre of its foot, shape (3,), [unit], world.
        a1: height of q1 above the base, [unit].
        a2: height of the shoulder above q1, [unit].
        a3: length of the upper arm, [unit].
        a4: length of the forearm, [unit].
        a5: length from the forearm's end to the tool at q5 = 0, [unit].
        limits: lowest and highest position of each joint, shape (6, 2), [rad], q5 [unit]. That of
            q3 keeps forearm and upper arm apart.
        capsules: around the links, those that stand still first.
        unit: the unit of all lengths.
    """

    base: FloatArray
    a1: float
    a2: float
    a3: float
    a4: float
    a5: float
    limits: FloatArray
    capsules: tuple[LinkCapsule, ...]
    unit: Literal["m", "cm", "mm"] = "cm"

    def __post_init__(self) -> None:
        arguments.keep(
            self,
            base=arguments.numbers("base", self.base, (3,)),
            limits=arguments.numbers("limits", self.limits, (6, 2)),
        )

    @classmethod
    def of(cls, base: Vec3, lengths: Sequence[float], unit: Literal["m", "cm", "mm"]) -> Self:
        """The arm with limits and capsules that follow from its lengths.

        Args:
            base: foot of its base on the floor, [unit], world.
            lengths: a1 to a5, as of :class:`PaperArm`, [unit].
            unit: that of all lengths.
        """
        roll = (-2 * math.pi, 2 * math.pi)
        a1, a2, a3, a4, a5 = lengths
        capsules = link_capsules(a1, a2, a3, a4, a5)
        bend = min(2.9, steepest_bend(capsules, a4))
        limits = [roll, (-2.8, 2.8), (-bend, bend), roll, (0.0, STROKE * a4), roll]
        foot = read_only(np.array(base, dtype=float))
        return cls(foot, a1, a2, a3, a4, a5, read_only(np.array(limits)), capsules, unit)

    @property
    def root(self) -> str:
        """Name of the link that stands at its base."""
        return "base_link"

    @property
    def tip(self) -> str:
        """Name of the link whose origin is the tool."""
        return "tool"

    @property
    def wxyz(self) -> Quaternion:
        """Orientation of the base, a quaternion: the arm stands upright."""
        return UNTURNED

    @property
    def shoulder(self) -> FloatArray:
        """Centre of q2, shape (3,), [unit], world; it never moves."""
        return np.asarray(self.base + np.array([0.0, 0.0, self.a1 + self.a2]))

    def table(self, elbow: Literal["up", "down"] = "up", spare: float = 0.0) -> ArmTable:
        """The arm and its capsules in the format of the kernels.

        Args:
            elbow: its branch.
            spare: distance that q2 and q3 keep from their limits, [rad].
        """
        x, y, z = self.base.tolist()
        return ArmTable(
            *(x, y, z),
            shoulder=z + self.a1 + self.a2,
            upper=self.a3,
            forearm=self.a4 + self.a5,
            side=1.0 if elbow == "up" else -1.0,
            least_cosine_q3=math.cos(self.limits[2, 1] - spare),
            least_cosine_q2=math.cos(self.limits[1, 1] - spare),
            capsules=self.capsule_rows,
        )

    @cached_property
    def capsule_links(self) -> tuple[str, ...]:
        """Name of the link of each capsule."""
        return tuple(one.link for one in self.capsules)

    @cached_property
    def radii(self) -> FloatArray:
        """Radius of each capsule, (c,), [unit]."""
        return read_only(np.array([one.radius for one in self.capsules]))

    @cached_property
    def capsule_rows(self) -> FloatArray:
        """Body, ends and radius of each capsule, flat (4 c,), as the kernels take them."""
        rows = [(c.body, c.low, c.high, c.radius) for c in self.capsules]
        return read_only(np.array(rows, dtype=float).ravel())

    @cached_property
    def chain(self) -> Chain:
        """The chain of its URDF as it stands in the scene, in [m].

        Raises:
            AbiError: it is so large that no URDF holds it.
        """
        try:
            robot = robot_from_archive(packed(self.files()))
        except SceneError:
            raise AbiError(
                f"The arm reaches {self.reach * self.metres:.4g} m, and a URDF holds no link over "
                "100 m.",
                "Correct a1 to a5 of arm, or unit of the scene.",
            ) from None
        x, y, z = (self.base * self.metres).tolist()
        return Chain.of(robot, usual_tip(robot), (x, y, z), None, self.wxyz)

    @cached_property
    def scales(self) -> FloatArray:
        """Factors from positions in [rad] or [m] to [rad] or [unit], (6,)."""
        return read_only(np.where(SLIDES, 1 / self.metres, 1.0))

    @property
    def metres(self) -> float:
        """One [unit] in metres."""
        return METRES[self.unit]

    @property
    def reach(self) -> float:
        """Length of the arm stretched out, [unit]."""
        return self.a3 + self.a4 + self.a5

    @property
    def has_elbow(self) -> bool:
        """True: its branches are the two sides of its elbow."""
        return True

    @property
    def has_exact_bodies(self) -> bool:
        """True: its bodies are its links, which are capsules."""
        return True

    @property
    def has_nominal_rates(self) -> bool:
        """True: the paper gives no limits of speeds and accelerations."""
        return True

    def rate_limits(self, acceleration: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Largest speeds, accelerations and torques of its joints, nominal for q1 to q3.

        Args:
            acceleration: largest of these joints, [rad/s²].
        """
        solved = np.arange(len(JOINTS)) < MOVED
        speeds = np.where(solved, JOINT_SPEED, np.inf)
        accelerations = np.where(solved, acceleration, np.inf)
        return speeds, accelerations, np.full(len(JOINTS), np.inf)

    def torques(self, positions: FloatArray, speeds: FloatArray, accelerations: FloatArray) -> None:
        """None, as the paper gives masses for its last three drives only."""

    def tool(self, positions: FloatArray) -> FloatArray:
        """Positions (k, 3) of the tool at joint positions (k, 6), [unit], world."""
        return forward(self, positions)

    def place(self, positions: FloatArray) -> FloatArray:
        """Ends of the capsules' segments at joint positions (k, 6), (k, c, 2, 3), [unit], world."""
        positions = arguments.numbers("positions", positions, (-1, 6))
        ends = np.empty((len(positions), len(self.capsules), 2, 3))
        place_capsules(flat(positions), self.table(), ends.reshape(-1))
        return ends

    def description(self) -> str:
        """URDF of the arm, in metres, standing at the origin of its root link."""
        return urdf(self)

    def files(self) -> dict[str, bytes]:
        """Its URDF, which names no meshes, and an SRDF with the links that are not compared."""
        pairs = "".join(
            f'  <disable_collisions link1="{one}" link2="{other}" reason="{reason}"/>\n'
            for one, other, reason in _UNPAIRED
        )
        srdf = f'<?xml version="1.0"?>\n<robot name="abi">\n{pairs}</robot>\n'
        return {"arm.urdf": self.description().encode(), "arm.srdf": srdf.encode()}

    def proof_data(self) -> dict[str, Any]:
        """What a certificate is about, as plain data: the capsules."""
        return {"capsules": [asdict(one) | {"body": BODIES[one.body]} for one in self.capsules]}

    def forearm(self, extension: ArrayLike) -> FloatArray:
        """Length from elbow to tool, the paper's a6 = a4 + a5 + q5, [unit]."""
        return np.asarray(self.a4 + self.a5 + np.asarray(extension, dtype=float))


def forward(arm: PaperArm, positions: FloatArray) -> FloatArray:
    """Forward kinematics: positions of the tool.

    Paper, stage 6: x6 = sin q1·r, y6 = −cos q1·r, z6 = a1 + a2 + a3·cos q2 + a6·cos(q2 + q3),
    with r = a3·sin q2 + a6·sin(q2 + q3), a6 = a4 + a5 + q5; the base is added.

    Args:
        arm: the arm.
        positions: joint positions, shape (n, 6), [rad], q5 [unit].

    Returns:
        Tool positions, shape (n, 3), [unit], world.
    """
    positions = arguments.numbers("positions", positions, (-1, 6))
    q1, q2, q3, _, q5, _ = positions.T
    a6 = arm.forearm(q5)
    r = arm.a3 * np.sin(q2) + a6 * np.sin(q2 + q3)
    z = arm.a1 + arm.a2 + arm.a3 * np.cos(q2) + a6 * np.cos(q2 + q3)
    return np.asarray(arm.base + np.stack([np.sin(q1) * r, -np.cos(q1) * r, z], axis=1))


def urdf(arm: PaperArm, scale: float | None = None) -> str:
    """The arm as URDF text, standing at the origin of its root link ``base_link``.

    Joints q1 to q6 in that order; the last link is the frame ``tool``. A viewer moves the root link
    to ``arm.base``.

    Args:
        arm: the arm.
        scale: length of one [unit] in the text; ``arm.metres`` when not given, as the format asks.
            1 gives a text for a viewer that draws in the scene's unit.

    Returns:
        The text; equal link lengths give equal text.
    """
    metres = arm.metres if scale is None else scale
    lengths = [float(length * metres) for length in (arm.a1, arm.a2, arm.a3, arm.a4, arm.a5)]
    links = arm_links.links(*lengths)
    heights = arm_links.joint_heights(*lengths)
    pairs = list(itertools.pairwise(links))
    joints = []
    for k, name in enumerate(JOINTS):
        slides = name == "q5"
        low, high = (float(limit) * (metres if slides else 1.0) for limit in arm.limits[k])
        kind: Literal["revolute", "prismatic"] = "prismatic" if slides else "revolute"
        speed = high - low if slides else math.pi
        joints.append(joint(name, kind, pairs[k], heights[k], JOINT_AXES[k], (low, high), speed))
    joints.append(joint("tool_mount", "fixed", pairs[6], heights[6]))
    comment = "Generated by abi.robot.paper_arm. Masses, speeds and efforts are nominal."
    return write("abi", arm_links.COLOURS, links, joints, comment)

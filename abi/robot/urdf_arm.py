"""An arm from a URDF, in the scene's unit, as the stages use it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, Literal

import numpy as np

from abi import arguments
from abi.arrays import BoolArray, FloatArray, IntArray, ShortRepr, flat, read_only
from abi.obstacles.pose import METRES, UNTURNED, Quaternion, Vec3
from abi.robot.bodies.allowed_contacts import AllowedContact, Other, link_pairs
from abi.robot.bodies.capsule_table import Bodies
from abi.robot.bodies.chain_capsules import lever, meeting, place
from abi.robot.bodies.finer_links import fitted_capsules
from abi.robot.bodies.floor_contacts import on_floor
from abi.robot.bodies.link_bodies import Body
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.inverse_dynamics import has_masses, joint_torques
from abi.robot.kinematics.start_poses import first_poses, further_poses
from abi.robot.urdf.couplings import require_followed
from abi.robot.urdf.held_joints import NOT_HELD, held_in_metres
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.urdf_files import description_of, files_of

TRIED = 8
"""Most start poses whose motions are compared."""


@dataclass(frozen=True, eq=False, repr=False)
class UrdfArm(ShortRepr):
    """An arm from a URDF: a robot's chain in a scene.

    Attributes:
        chain: in [m].
        tip: name of the link that is the tool.
        base: where its base link stands, shape (3,), [unit], world.
        wxyz: how its base link is turned, as a quaternion.
        unit: of the scene's lengths.
        limits: lowest and highest position of each joint, shape (n, 2), [rad] or [unit].
        capsules: around the links, those that stand still first.
        held: positions of joints beside the chain that do not rest nearest to 0, [rad] or [m].
        asked: links, each with another or the number of an obstacle, that the scene lets touch.
        grasping: whether an object is taken or set down.
    """

    chain: Chain
    tip: str
    base: FloatArray
    wxyz: Quaternion
    unit: Literal["m", "cm", "mm"]
    limits: FloatArray
    capsules: tuple[Body, ...]
    held: Mapping[str, float]
    asked: tuple[tuple[str, Other], ...] = ()
    grasping: bool = False

    def __post_init__(self) -> None:
        """Check what kernels read.

        Raises:
            ArgumentError: a number makes no sense, or an array has another shape.
        """
        for one in self.capsules:
            arguments.integer("frame", one.frame, -1, len(self.chain.joints) - 1)
            arguments.numbers("ends", one.ends, (2, 3))
            arguments.number("radius", one.radius, 0.0)
            arguments.polyline("points", one.points)
            arguments.number("rounding", one.rounding, 0.0)
        arguments.keep(
            self,
            base=arguments.numbers("base", self.base, (3,)),
            limits=arguments.ranges("limits", self.limits, len(self.chain.names)),
        )

    @property
    def root(self) -> str:
        """Name of the link that stands at its base."""
        return self.chain.robot.root

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the n joints."""
        return self.chain.names

    @property
    def metres(self) -> float:
        """One [unit] in metres."""
        return METRES[self.unit]

    def on_floor(self, floor: float) -> tuple[str, ...]:
        """Names of the links that may touch a floor at that height, [unit]."""
        return on_floor(self.chain, self.capsules, floor * self.metres)

    @property
    def reach(self) -> float:
        """Length of the chain stretched out, [unit]."""
        return self.chain.table.reach / self.metres

    @cached_property
    def scales(self) -> FloatArray:
        """Factors from positions in [rad] or [m] to [rad] or [unit], (n,)."""
        slides = np.array(self.chain.slides)
        return read_only(np.where(slides, 1 / self.metres, 1.0))

    @cached_property
    def capsule_links(self) -> tuple[str, ...]:
        """Name of the link of each capsule."""
        return tuple(one.link for one in self.capsules)

    @cached_property
    def radii(self) -> FloatArray:
        """Radius of each capsule, (c,), [unit]."""
        return read_only(np.array([one.radius for one in self.capsules]) / self.metres)

    @cached_property
    def touchable(self) -> BoolArray:
        """Flags of the capsules that only must not touch obstacles, (c,).

        While an object is taken or set down these are the ones behind the last joint.
        """
        last = self.chain.table.length - 1
        return read_only(np.array([self.grasping and one.frame == last for one in self.capsules]))

    @cached_property
    def levers(self) -> FloatArray:
        """Bound of a capsule's displacement per unit of each coordinate, (c, n), [unit]."""
        return self._levers([one.ends for one in self.capsules])

    def _levers(self, points: Sequence[FloatArray]) -> FloatArray:
        """Bound of the displacement of points in each capsule's frame, (c, n), [unit]."""
        frames = [one.frame for one in self.capsules]
        rows = [lever(self.chain, *one, -1) for one in zip(frames, points, strict=True)]
        return read_only(np.stack(rows) / self.metres / self.scales)

    @cached_property
    def pair_levers(self) -> FloatArray:
        """Bound of the motion of each pair's capsules beside each other, (p, n), [unit]."""
        return self._pair_levers([one.ends for one in self.capsules])

    def _pair_levers(self, points: Sequence[FloatArray]) -> FloatArray:
        """Bound of the relative displacement of points of both capsules of a pair, (p, n)."""
        chain, frames = self.chain, [one.frame for one in self.capsules]

        @cache  # a piece has far more others than joints at which it meets them
        def beside(k: int, common: int) -> FloatArray:
            return lever(chain, frames[k], points[k], common)

        rows = []
        for i, j in self.pairs.tolist():
            common = meeting(chain, frames[i], frames[j])
            rows.append(beside(i, common) + beside(j, common))
        levers = np.array(rows).reshape(len(rows), len(self.joints))
        return read_only(levers / self.metres / self.scales)

    @cached_property
    def pairs(self) -> IntArray:
        """Pairs of capsules (k, 2) that must stay apart."""
        return self._link_pairs[0]

    @property
    def allowed(self) -> tuple[AllowedContact, ...]:
        """Pairs of links that may touch."""
        return self._link_pairs[1]

    @cached_property
    def _link_pairs(self) -> tuple[IntArray, tuple[AllowedContact, ...]]:
        """Pairs that must stay apart, and those that may touch."""
        asked = frozenset(frozenset(pair) for pair in self.asked)
        return link_pairs(self.chain.robot, self.tip, tuple(self.held.items()), asked)

    @cached_property
    def bodies(self) -> Bodies:
        """Capsules in the format of the kernels, for coordinates in [rad] and [m]."""
        frames = np.array([one.frame for one in self.capsules], dtype=np.int32)
        hulls = [one.points for one in self.capsules]
        roundings = np.array([one.rounding for one in self.capsules]) / self.metres
        return Bodies(
            moving=len(self.chain.joints),
            frames=read_only(frames),
            ends=flat(np.stack([one.ends for one in self.capsules])),
            radii=self.radii,
            levers=flat(self.levers * self.scales),
            pairs=read_only(np.ascontiguousarray(self.pairs).reshape(-1)),
            pair_levers=flat(self.pair_levers * self.scales),
            points=flat(np.concatenate(hulls)),
            first=read_only(np.cumsum([0, *map(len, hulls)], dtype=np.int32)),
            roundings=read_only(roundings),
            point_levers=flat(self._levers(hulls) * self.scales),
            point_pair_levers=flat(self._pair_levers(hulls) * self.scales),
            scale=1 / self.metres,
        )

    @cached_property
    def unpaired_bodies(self) -> Bodies:
        """The bodies without pairs that must stay apart."""
        nothing = read_only(np.zeros(0))
        return self.bodies._replace(
            pairs=read_only(np.zeros(0, dtype=np.int32)),
            pair_levers=nothing,
            point_pair_levers=nothing,
        )

    def place(self, positions: FloatArray) -> FloatArray:
        """Ends of the capsules' segments at joint positions (k, n), shape (k, c, 2, 3), [unit]."""
        positions = arguments.numbers("positions", positions, (-1, len(self.scales)))
        return self.placed_at(self.chain.poses(positions / self.scales))

    def placed_at(self, poses: FloatArray) -> FloatArray:
        """Ends (k, c, 2, 3), [unit], of the capsules' segments at frames (k, m + 1, 3, 4), [m]."""
        return place(self.capsules, poses) / self.metres

    def first_corners(self, pose: FloatArray) -> FloatArray:
        """A corner of each body's hull at joint positions (n,), (c, 3), [unit], world."""
        frames = self.chain.poses(pose[None] / self.scales)[0]
        corners = [
            one.points[0] if one.frame < 0 else frames[one.frame] @ np.append(one.points[0], 1.0)
            for one in self.capsules
        ]
        return np.asarray(np.stack(corners) / self.metres)

    def lowest(self, positions: FloatArray, body: int) -> FloatArray:
        """Height of the lowest point of a body that moves, at joint positions (k, n), (k,), [unit],
        world.
        """
        one = self.capsules[body]
        up = self.chain.poses(positions / self.scales)[:, one.frame, 2]
        heights = (up[:, :3] @ one.points.T).min(axis=1) + up[:, 3]
        return np.asarray((heights - one.rounding) / self.metres)

    @property
    def has_elbow(self) -> bool:
        """False: its branches are poses with the tool at the start."""
        return False

    @property
    def has_exact_bodies(self) -> bool:
        """False: its bodies contain its links and are a little larger."""
        return False

    @property
    def has_nominal_rates(self) -> bool:
        """False: its limits are from its URDF and the scene."""
        return False

    def rate_limits(self, acceleration: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Largest speeds, accelerations and torques of its joints, from its URDF, (n,) each.

        Args:
            acceleration: largest of each joint, [rad/s²], of sliding ones [m/s²].
        """
        return self.chain.speeds * self.scales, acceleration * self.scales, self.chain.efforts

    def torques(
        self, positions: FloatArray, speeds: FloatArray, accelerations: FloatArray
    ) -> FloatArray | None:
        """Torques (k, n) of a motion, [N·m] or [N]; None if its URDF has no masses.

        Args:
            positions: of its joints, (k, n), [rad] or [unit].
            speeds: (k, n), [rad/s] or [unit/s].
            accelerations: (k, n), [rad/s²] or [unit/s²].
        """
        if not has_masses(self.chain):
            return None
        moving = (values / self.scales for values in (positions, speeds, accelerations))
        return joint_torques(self.chain, *moving)

    def description(self) -> str:
        """URDF of the arm, in metres, standing at the origin of its root link."""
        return description_of(self.chain.robot)

    def files(self) -> dict[str, bytes]:
        """Its URDF and the meshes that this names, by their paths."""
        return files_of(self.chain.robot)

    def proof_data(self) -> dict[str, Any]:
        """What a certificate is about, as plain data: the capsules, and pairs of them."""
        capsules = [
            {"link": one.link, "joint": one.frame, "radius": radius}
            | dict(zip(("from", "to"), (one.ends / self.metres).tolist(), strict=True))
            | {"points": (one.points / self.metres).tolist()}
            | {"rounding": one.rounding / self.metres}
            for one, radius in zip(self.capsules, self.radii.tolist(), strict=True)
        ]
        return {"capsules": capsules, "pairs": self.pairs.tolist()}

    def tool(self, positions: FloatArray) -> FloatArray:
        """Position of the tip at joint positions (k, n), shape (k, 3), [unit], world."""
        positions = arguments.numbers("positions", positions, (-1, len(self.scales)))
        packed = self.chain.packed_poses(positions / self.scales).reshape(len(positions), -1)
        return np.asarray(packed[:, -3:] / self.metres)

    @property
    def is_redundant(self) -> bool:
        """Whether it has more joints than its task needs."""
        return len(self.joints) > (5 if self.chain.table.aims else 3)

    def aiming(self, direction: Vec3) -> UrdfArm:
        """The arm with the task that its tip's z axis points along a direction, world."""
        unit = np.array(direction) / np.linalg.norm(direction)
        table = self.chain.table._replace(direction=read_only(unit), aims=True)
        return replace(self, chain=replace(self.chain, table=table))

    def first_poses(self, point: FloatArray, most: int = TRIED) -> tuple[FloatArray, ...]:
        """At most ``most`` different joint positions (n,) with the tip at ``point`` (3,).

        They are those of the arm's closed form, if it has one, or else those that are found from
        random poses. Poses in the middle of the joints' limits come first. If none reaches the
        point, the result is one that comes near it. Of a redundant arm further poses follow if so
        many are asked for.
        Equal calls give equal poses, and the latest are remembered.
        """
        x, y, z = (arguments.numbers("point", point, (3,)) * self.metres).tolist()
        found = first_poses(self.chain, (x, y, z))
        if len(found) < most and self.is_redundant:
            found += further_poses(self.chain, (x, y, z))
        return tuple(read_only(positions * self.scales) for positions in found[:most])

    def follow(
        self, start: FloatArray, points: FloatArray, home: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Joint positions that move the tip along points, starting from a pose at the first one.

        Args:
            start: joint positions, (n,), [rad] or [unit].
            points: shape (k, 3), [unit], world.
            home: joint positions that redundant joints drift to, (n,); ``start`` by default.

        Returns:
            Positions (k, n), and the distance by which each point is missed, (k,), [unit]; if the
            tip's direction is off by more, that angle times the arm's reach.
        """
        start = arguments.numbers("start", start, self.scales.shape)
        points = arguments.points("points", points)
        if home is not None:
            home = arguments.numbers("home", home, self.scales.shape)
        positions, errors = self.chain.follow(
            start / self.scales,
            points * self.metres,
            None if home is None else home / self.scales,
        )
        return positions * self.scales, errors * self.reach


def urdf_arm(
    robot: Robot,
    tip: str,
    base: Vec3,
    axis: Vec3 | None = None,
    unit: Literal["m", "cm", "mm"] = "m",
    wxyz: Quaternion = UNTURNED,
    held: Mapping[str, float] = NOT_HELD,
    asked: tuple[tuple[str, Other], ...] = (),
    grasping: bool = False,
) -> UrdfArm:
    """Build the arm of a robot that stands at ``base``, [unit].

    Args:
        robot: the robot.
        tip: name of the link whose origin is the tool.
        base: where its root link stands, [unit], world.
        axis: direction that the tip's z axis is held to, world; None for any.
        unit: of the scene's lengths.
        wxyz: how its root link is turned, as a quaternion.
        held: positions of joints beside the chain, by name, [rad] or [unit].
        asked: links, each with another or the number of an obstacle, that may touch.
        grasping: whether an object is taken or set down.

    Raises:
        SceneError: there is no such tip, no joint moves it, a joint cannot be held there, or links
            move otherwise than they are posed.
    """
    metres = METRES[unit]
    x, y, z = base
    in_metres = held_in_metres(robot, held, metres)
    chain = Chain.of(robot, tip, (x * metres, y * metres, z * metres), axis, wxyz, in_metres)
    require_followed(robot, chain.names, in_metres)
    scales = np.where(np.array(chain.slides), 1 / metres, 1.0)
    return UrdfArm(
        chain=chain,
        tip=tip,
        base=read_only(np.array(base, dtype=float)),
        wxyz=wxyz,
        unit=unit,
        limits=read_only(chain.limits * scales[:, None]),
        capsules=fitted_capsules(chain),
        held=in_metres,
        asked=asked,
        grasping=grasping,
    )

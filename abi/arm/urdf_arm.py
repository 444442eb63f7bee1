"""An arm that a URDF describes, in the scene's unit, as the stages use it."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np

from abi.arm.any_arm import PlacedCapsule
from abi.arm.chain import Chain
from abi.arrays import FloatArray, IntArray, ShortRepr, read_only
from abi.obstacles.pose import METRES, UNTURNED, Quaternion, Vec3
from abi.robot.bounding_capsules import bounding_capsules
from abi.robot.robot import Robot
from abi.robot.urdf_files import description_of, files_of

_STARTS = 48
"""Random poses from which the first pose of a motion is sought."""
TRIED = 8
"""Largest number of start poses whose motions are compared."""
_ALIKE = 0.3
"""Poses nearer to each other than this in every joint are one, [rad] or [m]."""
REACHED = 1e-6
"""Error, as a fraction of the arm's reach, up to which a point counts as reached."""

_SAMPLES = 1500
_NEARLY_ALWAYS = 0.95


class LinkCapsule(NamedTuple):
    """A capsule of a link.

    Attributes:
        link: name of the link.
        frame: number of the joint that moves it, -1 where it stands still.
        ends: ends of its segment in that frame, or in the world where it stands still, shape
            (2, 3), [m].
        radius: [m].
    """

    link: str
    frame: int
    ends: FloatArray
    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class UrdfArm(ShortRepr):
    """An arm that a URDF describes: a robot's chain in a scene.

    Attributes:
        chain: in [m].
        tip: name of the link that is the tool.
        base: where its base link stands, shape (3,), [unit], world.
        wxyz: how its base link is turned, as a quaternion.
        unit: of the scene's lengths.
        limits: lowest and highest position of each joint, shape (n, 2), [rad] or [unit].
        capsules: around the links, those that stand still first.
    """

    chain: Chain
    tip: str
    base: FloatArray
    wxyz: Quaternion
    unit: Literal["m", "cm", "mm"]
    limits: FloatArray
    capsules: tuple[LinkCapsule, ...]

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
    def radii(self) -> FloatArray:
        """Radius of each capsule, (c,), [unit]."""
        return read_only(np.array([one.radius for one in self.capsules]) / self.metres)

    @cached_property
    def levers(self) -> FloatArray:
        """Bound of a capsule's motion per unit of each coordinate, (c, n), [unit]."""
        return read_only(np.stack([self._lever(one, -1) for one in self.capsules]))

    @cached_property
    def pair_levers(self) -> FloatArray:
        """Levers of the second capsule of each pair relative to its first, (p, n)."""
        rows = [self._lever(self.capsules[j], self.capsules[i].frame) for i, j in self.pairs]
        return read_only(np.array(rows).reshape(len(rows), len(self.joints)))

    def _lever(self, capsule: LinkCapsule, behind: int) -> FloatArray:
        """Bound for the joints behind number ``behind``, (n,).

        A point turns about a joint at most at the length of the chain between them; a slide moves
        it as far as itself.
        """
        table, joints = self.chain.table, self.chain.joints
        found = np.zeros(len(self.joints))
        far = float(np.linalg.norm(capsule.ends, axis=1).max())
        for k in range(capsule.frame, behind, -1):
            joint, coordinate = joints[k], int(table.source[k])
            slides = joint.kind == "prismatic"
            found[coordinate] += abs(float(table.factor[k])) * (1.0 if slides else far)
            far += float(np.linalg.norm(table.origins[12 * k + 9 : 12 * k + 12]))
            ends = table.factor[k] * self.chain.limits[coordinate] + table.offset[k]
            far += float(np.abs(ends).max()) if slides else 0.0
        return np.asarray(found / self.metres / self.scales)

    @cached_property
    def pairs(self) -> IntArray:
        """Pairs of capsules (k, 2) that must keep apart."""
        return _pairs(self.chain.robot, self.tip)

    def place(self, positions: FloatArray) -> FloatArray:
        """Ends of the capsules' segments at joint positions (k, n), shape (k, c, 2, 3), [unit]."""
        poses = self.chain.poses(positions / self.scales)
        return _place(self.capsules, poses) / self.metres

    @property
    def has_elbow(self) -> bool:
        """Whether it has an elbow: False, its branches are poses with the tool at the start."""
        return False

    def placed(self, positions: FloatArray) -> list[PlacedCapsule]:
        """Capsules of all links at joint positions (k, n)."""
        ends = self.place(positions).swapaxes(0, 1)
        return [
            PlacedCapsule(one.link, radius, of_one)
            for one, radius, of_one in zip(self.capsules, self.radii.tolist(), ends, strict=True)
        ]

    def description(self) -> str:
        """URDF of the arm, in metres, standing at the origin of its root link."""
        return description_of(self.chain.robot)

    def files(self) -> dict[str, bytes]:
        """The same as a file of its name, and the meshes that it names, by their paths."""
        return files_of(self.chain.robot)

    def proof_data(self) -> dict[str, Any]:
        """Subject of a certificate as plain data: the capsules, and pairs of them."""
        capsules = [
            {"link": one.link, "joint": one.frame, "radius": radius}
            | dict(zip(("from", "to"), (one.ends / self.metres).tolist(), strict=True))
            for one, radius in zip(self.capsules, self.radii.tolist(), strict=True)
        ]
        return {"capsules": capsules, "pairs": self.pairs.tolist()}

    def tool(self, positions: FloatArray) -> FloatArray:
        """Position of the tip at joint positions (k, n), shape (k, 3), [unit], world."""
        return np.asarray(self.chain.poses(positions / self.scales)[:, -1, :, 3] / self.metres)

    @property
    def is_redundant(self) -> bool:
        """Whether it has more joints than its task needs."""
        return len(self.joints) > (5 if self.chain.table.aims else 3)

    def first_poses(self, point: FloatArray, most: int = TRIED) -> tuple[FloatArray, ...]:
        """At most ``most`` different joint positions (n,) with the tip at ``point`` (3,).

        Poses in the middle of the joints' limits come first. If none reaches the point, the result
        is one that comes near it. Equal calls give equal poses.
        """
        random = np.random.default_rng(0)
        low, high = self.chain.usual_range().T
        target = point[None] * self.metres
        starts = [(low + high) / 2, *random.uniform(low, high, (_STARTS, len(low)))]
        solved = [self.chain.follow(start, target) for start in starts]
        found = [(pose[0], float(error[0])) for pose, error in solved]
        reached = [pose for pose, error in found if error <= REACHED]
        if not reached:
            return (read_only(min(found, key=_error)[0] * self.scales),)
        middle, half = (low + high) / 2, np.maximum((high - low) / 2, 1e-9)
        reached.sort(key=lambda pose: float(np.abs((pose - middle) / half).max()))
        kept: list[FloatArray] = []
        for pose in reached:
            if all(np.abs(pose - other).max() > _ALIKE for other in kept):
                kept.append(pose)
        return tuple(read_only(pose * self.scales) for pose in kept[:most])

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
) -> UrdfArm:
    """Build the arm of a robot that stands at ``base``, [unit].

    Args:
        robot: the robot.
        tip: name of the link whose origin is the tool.
        base: where its root link stands, [unit], world.
        axis: direction that the tip's z axis is held to, world; None for any.
        unit: of the scene's lengths.
        wxyz: how its root link is turned, as a quaternion.

    Raises:
        SceneError: there is no such tip, or no joint moves it.
    """
    metres = METRES[unit]
    x, y, z = base
    chain = Chain.of(robot, tip, (x * metres, y * metres, z * metres), axis, wxyz)
    capsules = [
        LinkCapsule(
            carried.link,
            carried.frame,
            read_only(_moved(carried.pose, np.stack([one.low, one.high]))),
            one.radius,
        )
        for carried in chain.carried
        for one in bounding_capsules(robot.links[carried.link])
    ]
    capsules.sort(key=_frame)
    scales = np.where(np.array(chain.slides), 1 / metres, 1.0)
    return UrdfArm(
        chain=chain,
        tip=tip,
        base=read_only(np.array(base, dtype=float)),
        wxyz=wxyz,
        unit=unit,
        limits=read_only(chain.limits * scales[:, None]),
        capsules=tuple(capsules),
    )


def segment_distances(first: FloatArray, second: FloatArray) -> FloatArray:
    """Distances (k,) between segments (k, 2, 3) and (k, 2, 3).

    The least distance is at one of the four ends or where the lines come nearest (Ericson,
    Real-Time Collision Detection, section 5.1.9).
    """
    p, q = first[:, 0], second[:, 0]
    d, e = first[:, 1] - p, second[:, 1] - q
    a, b, c = (np.einsum("ij,ij->i", u, v) for u, v in ((d, d), (d, e), (e, e)))
    f = np.einsum("ij,ij->i", d, p - q)
    g = np.einsum("ij,ij->i", e, p - q)
    tiny = 1e-300
    inner = np.clip((b * g - c * f) / np.maximum(a * c - b * b, tiny), 0, 1)
    best = np.full(len(p), np.inf)
    for s in (inner, np.zeros_like(a), np.ones_like(a), np.clip(-f / np.maximum(a, tiny), 0, 1),
              np.clip((b - f) / np.maximum(a, tiny), 0, 1)):  # fmt: skip
        t = np.clip((b * s + g) / np.maximum(c, tiny), 0, 1)
        away = p + s[:, None] * d - q - t[:, None] * e
        best = np.minimum(best, np.einsum("ij,ij->i", away, away))
    return np.asarray(np.sqrt(best))


@lru_cache(maxsize=16)
def _pairs(robot: Robot, tip: str) -> IntArray:
    """Pairs of capsules of links with a joint between them that do not touch in nearly all poses.

    Those touch because capsules are wider than what they hold. Links that an SRDF lets touch are no
    pair.
    """
    arm = urdf_arm(robot, tip, (0.0, 0.0, 0.0))
    chain, capsules = arm.chain, arm.capsules
    candidates = [
        (i, j)
        for i, j in itertools.combinations(range(len(capsules)), 2)
        if capsules[j].frame - capsules[i].frame > 1
        and frozenset((capsules[i].link, capsules[j].link)) not in robot.may_touch
    ]
    if not candidates:
        return read_only(np.empty((0, 2), dtype=np.int32))
    low, high = chain.usual_range().T
    positions = np.random.default_rng(0).uniform(low, high, (_SAMPLES, len(low)))
    ends = _place(capsules, chain.poses(positions))
    kept = []
    for i, j in candidates:
        gap = segment_distances(ends[:, i], ends[:, j]) - capsules[i].radius - capsules[j].radius
        if (gap < 0).mean() < _NEARLY_ALWAYS:
            kept.append((i, j))
    return read_only(np.array(kept, dtype=np.int32).reshape(-1, 2))


def _place(capsules: Sequence[LinkCapsule], poses: FloatArray) -> FloatArray:
    """Ends (k, c, 2, 3) of capsules in frames with poses (k, m + 1, 3, 4), [m]."""
    ends = np.empty((len(poses), len(capsules), 2, 3))
    for k, capsule in enumerate(capsules):
        if capsule.frame < 0:
            ends[:, k] = capsule.ends
        else:
            turn, origin = poses[:, capsule.frame, :, :3], poses[:, capsule.frame, :, 3]
            ends[:, k] = np.einsum("kij,ej->kei", turn, capsule.ends) + origin[:, None]
    return ends


def _moved(pose: FloatArray, points: FloatArray) -> FloatArray:
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])


def _frame(capsule: LinkCapsule) -> int:
    return capsule.frame


def _error(found: tuple[FloatArray, float]) -> float:
    return found[1]

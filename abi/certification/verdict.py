"""Verdict on a motion: proven clear, touching, or not decided."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from abi.arm_planning.motion.arm_clearance import Contact
from abi.arm_planning.world.collision_world import FLOOR
from abi.arrays import ShortRepr
from abi.certification.clearance_proof import MotionProblem
from abi.certification.joint_limits import LimitsKept
from abi.certification.kept_direction import KeptDirection
from abi.curves.clearance.certificate import Certificate
from abi.length_text import format_proven
from abi.scene.scene import Scene

State = Literal["clear", "touches", "undecided"]

SMALLER = ", the object then a millimetre smaller on each side"
"""End of a sentence where what the gripper takes or sets down may stand on an obstacle."""
_ASSUMED = {
    "linear": "straight in the joints between waypoints, as the file gives positions alone",
    "cubic": "cubic polynomials between waypoints, from their positions and velocities",
    "quintic": "quintic polynomials between waypoints, from their positions, velocities and "
    "accelerations",
}


class TimeStretch(NamedTuple):
    """A part of the motion, from one time to another, [s], and what is known of it."""

    first: float
    last: float
    state: State


class Doubt(NamedTuple):
    """A stretch of the motion on which it is not decided whether a link touches something.

    Attributes:
        first, last: times, [s].
        link: name of the link.
        obstacle: number of an obstacle from 0, name of another link, or ``floor``.
        distance: of the exact shapes in its middle, at most, [unit].
        would_decide: what would decide it, as a sentence.
    """

    first: float
    last: float
    link: str
    obstacle: int | str
    distance: float
    would_decide: str


@dataclass(frozen=True, eq=False, repr=False)
class MotionVerdict(ShortRepr):
    """What is known of a motion.

    Attributes:
        state: ``clear``: proven not to touch anything at any time; ``touches``; or ``undecided``.
        scene: the scene, with the robot.
        problem: the motion, the robot's bodies and what they keep clear of.
        clearance: distance from every obstacle that is proven where it is clear, else the least
            that was found, [unit]; inf without obstacles.
        nearest: link, obstacle and time [s] of the least distance that was found; None without
            obstacles.
        touches: contacts, decided on the exact shapes, the first one first; they end where they do
            to a thousandth of the motion.
        doubts: what is not decided.
        stretches: the whole motion in the order of time.
        limits: limits of the joints.
        direction: whether the tool keeps the direction that the scene asks for; None for none.
        proof: the directions that prove it; None if it is not clear.
    """

    state: State
    scene: Scene
    problem: MotionProblem
    clearance: float
    nearest: tuple[str, int, float] | None
    touches: tuple[Contact, ...]
    doubts: tuple[Doubt, ...]
    stretches: tuple[TimeStretch, ...]
    limits: LimitsKept
    direction: KeptDirection | None
    proof: Certificate | None

    @property
    def assumed(self) -> str:
        """How the joints are taken to move between waypoints, as the end of a sentence."""
        return _ASSUMED[self.problem.motion.motion.interpolation]

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        unit = self.scene.unit
        if self.state == "clear":
            if math.isinf(self.clearance):
                but = ", but for what the notes tell" if self.problem.not_compared else ""
                return (
                    "Proven clear: the robot touches neither itself nor the floor at any time"
                    f"{but}."
                )
            kept = (
                f"its moving links keep {format_proven(self.clearance)} {unit} from every obstacle"
            )
            kept = kept if self.clearance > 0 else "its moving links touch nothing"
            arm = self.scene.arm
            smaller = SMALLER if arm.grasping and arm.attached is not None else ""
            return f"Proven clear: {kept}{smaller}."
        if self.state == "touches":
            one = self.touches[0]
            depth = f", {one.depth:.3g} {unit} deep or more" if one.depth > 0 else ""
            return (
                f"Touches: {one.link} meets {words_for(one.obstacle)} from {self.at(one.first)} on"
                f"{depth}."
            )
        doubt = self.doubts[0]
        return (
            f"Not decided: {doubt.link} is {doubt.distance:.3g} {unit} or less from "
            f"{words_for(doubt.obstacle)} between {self.at(doubt.first)} and "
            f"{self.at(doubt.last)}. {doubt.would_decide}"
        )

    def at(self, time: float) -> str:
        """A time as text."""
        return f"{time:.4g} s" if self.problem.motion.motion.timed else f"waypoint {time + 1:.4g}"

    @property
    def _where(self) -> tuple[str | None, int | str | None, float | None]:
        """Link, obstacle and time of the first contact, the first doubt, or the least distance."""
        if self.touches:
            return self.touches[0].link, self.touches[0].obstacle, self.touches[0].first
        if self.doubts:
            return self.doubts[0].link, self.doubts[0].obstacle, self.doubts[0].first
        return self.nearest or (None, None, None)

    def to_dict(self) -> dict[str, Any]:
        """The verdict as plain data, with all that ``abi verify`` checks."""
        motion, first = self.problem.motion.motion, self.touches[0] if self.touches else None
        link, obstacle, time = self._where
        return {
            "version": 1,
            "verdict": self.state,
            "sentence": self.sentence,
            "clearance": self.clearance if math.isfinite(self.clearance) else None,
            "time": time,
            "link": link,
            "obstacle": obstacle,
            "depth": first.depth if first else None,
            "interpolation": motion.interpolation,
            "touches": [_touch(one) for one in self.touches],
            "undecided": [one._asdict() for one in self.doubts],
            "stretches": [one._asdict() for one in self.stretches],
            "limits": self.limits.to_dict(),
            "direction": None if self.direction is None else self.direction.to_dict(),
            "allowed": [one._asdict() for one in self.problem.allowed],
            "notes": [*self.problem.notes, *self.scene.file_notes],
            "motion": motion.to_dict(),
            "scene": self.scene.to_dict(),
            "certificate": None if self.proof is None else _certificate(self.problem, self.proof),
        }


def _touch(contact: Contact) -> dict[str, Any]:
    """A contact as plain data: when it begins and ends, of what, and where it is deepest."""
    return {
        "time": contact.first,
        "last": contact.last,
        "link": contact.link,
        "obstacle": contact.obstacle,
        "depth": contact.depth,
        "deepest": contact.time,
    }


def words_for(obstacle: int | str) -> str:
    """An obstacle by its number from 1, or the name of a link or of the floor."""
    return f"obstacle {obstacle + 1}" if isinstance(obstacle, int) else str(obstacle)


def _certificate(problem: MotionProblem, proof: Certificate) -> dict[str, Any]:
    """Bodies, pairs that keep apart, and directions."""
    metres, numbers = problem.metres, proof.obstacle.tolist()
    rows = zip(
        proof.pieces.tolist(),
        proof.poses.tolist(),
        proof.capsule.tolist(),
        numbers,
        proof.directions.tolist(),
        strict=True,
    )
    return {
        "margin": proof.margin if len(problem.around.obstacles) else None,
        "bodies": [
            {
                "link": body.link,
                "joint": body.frame,
                "radius": body.rounding / metres,
                "points": (body.points / metres).tolist(),
            }
            for body in problem.bodies
        ],
        "pairs": problem.pairs[0].tolist(),
        "planes": [
            {"t0": t0, "t1": t1, "at": at, "body": body, "direction": direction}
            | ({"other": -2 - other} if other < FLOOR else {})
            | ({"obstacle": problem.named(other)} if other >= FLOOR else {})
            for (t0, t1), at, body, other, direction in rows
        ],
    }

"""Ghosts of the arm: its other poses now, those at start and goal, and the tool's own curve."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import viser
from numpy.typing import NDArray

from abi.arm.arm import Arm
from abi.arm.inverse_kinematics import solve
from abi.arm.urdf_arm import REACHED, UrdfArm
from abi.arrays import FloatArray, read_only
from abi.planner.plan import Plan
from abi.scene.settings import Elbow
from app import style
from app.frame import Frame, Layer, Switch
from app.layers.arm_playback import samples_of
from app.layers.ghost_bodies import GhostBodies, capsule_mesh, places_of
from app.layers.urdf_poses import OtherPoses, first_pose, last_pose, other_courses, other_poses
from app.layout import Layout
from app.lines import NO_SEGMENTS, add_line, dashes, parameters
from app.once_a_plan import once_a_plan

_SAMPLES = 120
_ENDS = ("start", "goal")
"""Names of the ghosts that stand still."""


class ArmGhostsLayer(Layer):
    """The arm's capsules, see-through."""

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch("other_elbow", "other elbow, or other poses (ghosts)", style.FADED, on=False),
        Switch("end_poses", "poses at start and goal (ghosts)", style.POINT, on=False),
        Switch("tool_only", "curve of the tool alone", style.FADED),
    )

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        self._others = GhostBodies(layout.client, "/arm_ghost/now", style.FADED)
        self._stands: tuple[object, ...] | None = None
        self._meshes: dict[str, viser.MeshHandle] = {}
        self._drawn: dict[str, tuple[object, ...]] = {}
        self._line = add_line(self._scene, "/tool_only", style.FADED, 4.0)
        self._curve: object = None

    def draw(self, frame: Frame) -> None:
        """Draw what is switched on."""
        plan = frame.plan
        for name in _ENDS:
            seen = "end_poses" in frame.shown and self._pose(name, frame)
            if name in self._meshes:
                self._meshes[name].visible = seen
        self._draw_others(frame)
        if plan.tool_only is not self._curve:
            self._curve = plan.tool_only
            self._line.points = NO_SEGMENTS
            if plan.tool_only is not None:
                curve = plan.tool_only.curve
                points = curve(parameters(curve.interval, _SAMPLES))
                self._line.points = dashes(points, 0.03 * max(plan.scene.workspace.size))
        self._line.visible = "tool_only" in frame.shown

    def _draw_others(self, frame: Frame) -> None:
        """Draw the other poses: at the frame's time, or for the page to move while it plays."""
        plan = frame.plan
        arm = plan.arm
        positions = np.empty((0, 0))
        playing = frame.playing and plan.motion is not None
        if "other_elbow" in frame.shown and arm is not None:
            positions = (
                np.array([one.positions[0] for one in _courses(plan)])
                if playing
                else _poses_of("now", frame)
            )
        state = (plan if playing else arm, playing, *np.round(positions, 9).ravel().tolist())
        if state == self._stands:
            return
        self._stands = state
        if arm is None or not len(positions):
            self._others.hide()
            return
        placed = arm.placed(positions)
        ends = np.stack([capsule.ends for capsule in placed], axis=1).reshape(-1, 2, 3)
        radii = np.tile([capsule.radius for capsule in placed], len(positions))
        if playing:
            self._others.follow(ends, radii, _places(plan))
        else:
            self._others.stand(ends, radii)

    def _pose(self, name: str, frame: Frame) -> bool:
        """Draw a ghost that stands still; whether there is any."""
        arm = frame.plan.arm
        positions = _poses_of(name, frame)
        if arm is None or not len(positions):
            return False
        state = (arm, *np.round(positions, 9).ravel().tolist())
        if self._drawn.get(name) == state:
            return True
        self._drawn[name] = state
        capsules = arm.placed(positions)
        vertices, faces = _capsule_meshes(
            np.concatenate([capsule.ends for capsule in capsules]),
            np.repeat([capsule.radius for capsule in capsules], len(positions)),
        )
        self._meshes[name] = self._scene.add_mesh_simple(
            f"/arm_ghost/{name}",
            vertices,
            faces,
            color=style.POINT,
            opacity=style.GHOST_OPACITY,
            cast_shadow=False,
        )
        return True


def _poses_of(name: str, frame: Frame) -> FloatArray:
    """Joint positions (k, n) of a ghost, [rad] or [unit]."""
    plan = frame.plan
    arm = plan.arm
    if isinstance(arm, Arm):
        return _paper_pose(name, frame, arm)[None]
    if not isinstance(arm, UrdfArm):
        return np.empty((0, 0))
    if name == "now":
        return other_poses(plan, arm, frame.time)
    pose = first_pose(plan, arm) if name == "start" else last_pose(plan, arm)
    return np.empty((0, 0)) if pose is None else pose[None]


def _paper_pose(name: str, frame: Frame, arm: Arm) -> FloatArray:
    """Joint positions (6,) of a ghost of the paper's arm, which has one other elbow."""
    tool, elbow = _place_of(name, frame)
    q5 = np.array([frame.plan.scene.arm.q5])
    found = solve(arm, tool[None], q5, elbow, np.zeros((1, 3)))
    return np.array([found.q1[0], found.q2[0], found.q3[0], 0.0, q5[0], 0.0])


def _place_of(name: str, frame: Frame) -> tuple[FloatArray, Elbow]:
    """Place of a ghost's tool, (3,), [unit], world, and its branch."""
    plan, elbow = frame.plan, elbow_of(frame.plan)
    if name == "now":
        return _tool_at(plan, frame.time), _other(elbow)
    return np.array(plan.scene.start if name == "start" else plan.scene.goal), elbow


def elbow_of(plan: Plan) -> Elbow:
    """Branch of the plan's arm."""
    return plan.scene.arm.branches[0] if plan.motion is None else plan.motion.elbow


def _other(elbow: Elbow) -> Elbow:
    return "down" if elbow == "up" else "up"


def _tool_at(plan: Plan, time: float) -> FloatArray:
    """Place of the tool at a time, (3,), [unit], world."""
    motion = plan.motion
    if motion is None:
        return np.array(plan.scene.start)
    return np.array([np.interp(time, motion.time, column) for column in motion.tool.T])


@once_a_plan
def _places(plan: Plan) -> FloatArray:
    """Places of the capsules of all other poses at the page's samples of the motion, (k, b, 7)."""
    arm, motion = plan.arm, plan.motion
    assert arm is not None
    assert motion is not None
    found = []
    for other in _courses(plan):
        ends = np.stack([capsule.ends for capsule in arm.placed(other.positions)], axis=1)
        places = places_of(ends)
        places[other.missed > REACHED * arm.reach] = np.nan
        found.append(places)
    return read_only(np.concatenate(found, axis=1)) if found else np.empty((0, 0, 7))


def _courses(plan: Plan) -> tuple[OtherPoses, ...]:
    """Courses of the other poses, at the page's samples of the motion."""
    arm, motion = plan.arm, plan.motion
    if not isinstance(arm, Arm):
        return other_courses(plan)
    assert motion is not None
    rows = samples_of(motion)
    q5 = np.full(len(rows), plan.scene.arm.q5)
    tool = motion.tool[rows]
    found = solve(arm, tool, q5, _other(elbow_of(plan)), np.zeros_like(tool))
    still = np.zeros_like(q5)
    positions = np.column_stack([found.q1, found.q2, found.q3, still, q5, still])
    return (OtherPoses(motion.time[rows], positions, still),)


def _capsule_meshes(
    ends: FloatArray, radii: FloatArray
) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Vertices and faces of capsules with ends (c, 2, 3) and radii (c,), [unit], as one mesh."""
    meshes = [capsule_mesh(*one) for one in zip(ends, radii.tolist(), strict=True)]
    first = np.cumsum([0, *(len(vertices) for vertices, _ in meshes[:-1])], dtype=np.uint32)
    faces = [own + begin for (_, own), begin in zip(meshes, first, strict=True)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)

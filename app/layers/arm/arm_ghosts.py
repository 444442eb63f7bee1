"""Ghosts of the arm: its other poses now, those at start and goal, and the tool's own curve."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from abi.arm_planning.branch.followed import Followed
from abi.arrays import FloatArray, read_only
from abi.planner.plan import Plan
from abi.robot.kinematics.start_poses import REACHED
from app.drawing.lines import NO_SEGMENTS, add_line, dashes, parameters
from app.layers.arm.ghost_bodies import GhostBodies, places_of
from app.layers.arm.kinds import kind_of
from app.shared.computed_once import once_a_plan
from app.state.frame import Frame, Layer, Switch
from app.ui import style
from app.ui.layout import Layout

_SAMPLES = 120
_ENDS = ("start", "goal")
"""Names of the ghosts that stand still."""


class ArmGhostsLayer(Layer):
    """The arm's capsules, see-through."""

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch(
            "other_elbow",
            "other elbow, or other poses (ghosts)",
            style.FADED,
            on=False,
            hint="Another way for the arm to hold the tool tip where it is now.",
        ),
        Switch("end_poses", "poses at start and goal (ghosts)", style.POINT, on=False),
        Switch(
            "tool_only",
            "curve of the tool tip alone",
            style.FADED,
            hint="Where the curve would go if the links were no matter; drawn if they are.",
        ),
    )

    def __init__(self, layout: Layout) -> None:
        client = layout.client
        self._bodies = {
            name: GhostBodies(client, f"/arm_ghost/{name}", colour)
            for name, colour in (("now", style.FADED), *((end, style.POINT) for end in _ENDS))
        }
        self._drawn: dict[str, tuple[object, ...]] = {}
        self._line = add_line(client.scene, "/tool_only", style.FADED, 4.0)
        self._curve: object = None

    def draw(self, frame: Frame) -> None:
        """Draw what is switched on."""
        plan = frame.plan
        for name, bodies in self._bodies.items():
            self._draw_bodies(name, bodies, frame)
        if plan.tool_only is not self._curve:
            self._curve = plan.tool_only
            self._line.points = NO_SEGMENTS
            if plan.tool_only is not None:
                curve = plan.tool_only.curve
                points = curve(parameters(curve.interval, _SAMPLES))
                self._line.points = dashes(points, 0.03 * max(plan.scene.workspace.size))
        self._line.visible = "tool_only" in frame.shown

    def _draw_bodies(self, name: str, bodies: GhostBodies, frame: Frame) -> None:
        """Draw a ghost's poses; the others for the page to move while the motion plays."""
        plan, arm = frame.plan, frame.plan.arm
        playing = name == "now" and frame.playing and plan.motion is not None
        positions = np.empty((0, 0))
        if arm is not None and ("other_elbow" if name == "now" else "end_poses") in frame.shown:
            positions = (
                np.array([one.joints[0] for one in _joint_paths(plan)])
                if playing
                else _poses_of(name, frame)
            )
        state = (plan if playing else arm, playing, *np.round(positions, 9).ravel().tolist())
        if state == self._drawn.get(name):
            return
        self._drawn[name] = state
        if arm is None or not len(positions):
            bodies.hide()
            return
        ends = arm.place(positions).reshape(-1, 2, 3)
        radii = np.tile(arm.radii, len(positions))
        if playing:
            bodies.follow(ends, radii, _places(plan))
        else:
            bodies.stand(ends, radii)


def _poses_of(name: str, frame: Frame) -> FloatArray:
    """Joint positions (k, n) of a ghost, [rad] or [unit]."""
    plan, arm = frame.plan, frame.plan.arm
    if arm is None:
        return np.empty((0, 0))
    kind = kind_of(arm)
    if name == "now":
        return kind.other_poses(plan, arm, frame.time)
    pose = kind.end_pose(plan, arm, name)
    return np.empty((0, 0)) if pose is None else pose[None]


@once_a_plan
def _places(plan: Plan) -> FloatArray:
    """Poses of the capsules of all other poses at the page's samples of the motion, (k, b, 7)."""
    arm, motion = plan.arm, plan.motion
    assert arm is not None
    assert motion is not None
    found = []
    for other in _joint_paths(plan):
        places = places_of(arm.place(other.joints))
        places[other.missed > REACHED * arm.reach] = np.nan
        found.append(places)
    return read_only(np.concatenate(found, axis=1)) if found else np.empty((0, 0, 7))


def _joint_paths(plan: Plan) -> tuple[Followed, ...]:
    """Joint paths of the other poses, at the page's samples of the motion."""
    assert plan.arm is not None
    return kind_of(plan.arm).other_joint_paths(plan, plan.arm)

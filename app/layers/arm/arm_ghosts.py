"""Ghosts of the arm: its other poses now, those at start and goal, and the tool's own curve."""

from __future__ import annotations

import numpy as np

from abi.arm_planning.branch.followed import Followed
from abi.arrays import FloatArray, read_only
from abi.planner.plan import Plan
from abi.planner.stage_results import AnyFit
from abi.robot.kinematics.start_poses import REACHED
from app.drawing.lines import NO_SEGMENTS, add_line, dashes, parameters
from app.layers.arm.ghost_bodies import Pose, ghost, places_of
from app.layers.arm.kinds import kind_of
from app.shared.computed_once import once_a_plan
from app.state.frame import Draw, Frame
from app.ui import style
from app.ui.layout import Layout

_SAMPLES = 120
_ENDS = ("start", "goal")
"""Names of the ghosts that stand still."""


def arm_ghosts_layer(layout: Layout) -> Draw:
    """The arm's capsules, see-through, and the curve of the tool alone."""
    client = layout.client
    ghosts = {
        name: ghost(client, f"/arm_ghost/{name}", colour)
        for name, colour in (("now", style.FADED), *((end, style.POINT) for end in _ENDS))
    }
    line = add_line(client.scene, "/tool_only", style.FADED, 4.0)
    drawn: dict[str, tuple[object, ...]] = {}
    lined: AnyFit | None = None

    def draw(frame: Frame) -> None:
        nonlocal lined
        plan = frame.plan
        for name, pose in ghosts.items():
            drawn[name] = _draw_ghost(name, pose, frame, drawn.get(name))
        if plan.tool_only is not lined:
            lined = plan.tool_only
            line.points = NO_SEGMENTS
            if lined is not None:
                points = lined.curve(parameters(lined.curve.interval, _SAMPLES))
                line.points = dashes(points, 0.03 * max(plan.scene.workspace.size))
        line.visible = "tool_only" in frame.shown

    return draw


def _draw_ghost(
    name: str, pose: Pose, frame: Frame, drawn: tuple[object, ...] | None
) -> tuple[object, ...]:
    """Draw a ghost's poses; the others for the page to move while the motion plays.

    Returns:
        What was drawn; where that is what was ``drawn`` before, nothing is.
    """
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
    if state == drawn:
        return state
    if arm is None or not len(positions):
        pose(np.empty((0, 2, 3)), np.empty(0), None)
        return state
    ends = arm.place(positions).reshape(-1, 2, 3)
    pose(ends, np.tile(arm.radii, len(positions)), _places(plan) if playing else None)
    return state


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

"""Repair of a motion: what is not proven clear is planned anew, in the space of the joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.joint_search.search_joints import search_joints
from abi.arm_planning.world.arm_worlds import chain_world
from abi.arrays import FloatArray
from abi.certification.certify_motion import certify_motion
from abi.certification.motion import Motion
from abi.certification.verdict import MotionVerdict
from abi.errors import AbiError
from abi.planner.joint_space_motion import THOROUGH
from abi.robot.urdf_arm import urdf_arm

_WIDER = (0, 1, 3)
"""Waypoints beyond the last and before the next proven one from which a way is sought, in turn."""
_PEAK = {"linear": 1.0, "cubic": 1.5, "quintic": 1.875}
"""Largest speed of a motion from rest to rest, over its mean."""


def repair(verdict: MotionVerdict, acceleration: float | None = None) -> tuple[MotionVerdict, str]:
    """Plan anew what is not proven clear, from the last proven waypoint to the next.

    The new part goes as fast as the motion did on average, or as the joints' limits allow.

    Args:
        verdict: on a motion that is not clear, of the joints of the scene's arm.
        acceleration: largest of each joint, [rad/s²], of sliding ones [m/s²]; None for no limit.

    Returns:
        The verdict on the new motion, which is clear, and a sentence on how it differs.

    Raises:
        AbiError: there is no such waypoint, or no way was found.
    """
    motion = verdict.problem.motion.motion
    space = _space(verdict)
    for wider in _WIDER:
        gaps = _gaps(verdict, wider)
        ways = [_way(space, verdict, gap) for gap in gaps]
        new = _with_ways(space, motion, gaps, ways)
        proven = certify_motion(new, verdict.scene, acceleration=acceleration)
        if proven.state == "clear":
            return proven, _difference(space, verdict, new, gaps)
    raise AbiError("The other ways that were found could not be proven clear, either.")


def _difference(
    space: JointSpace, verdict: MotionVerdict, new: Motion, gaps: list[tuple[int, int]]
) -> str:
    """Sentence on where a motion goes another way, and how much longer and farther it is."""
    old = verdict.problem.motion.motion
    where = ", ".join(" to ".join(verdict.at(float(old.times[k])) for k in gap) for gap in gaps)
    before, after = (_length(space, one) for one in (old, new))
    farther = f"{100 * (after / before - 1 if before > 0 else 0.0):+.0f} % of way in the joints"
    longer = f"{np.ptp(new.times) - np.ptp(old.times):+.2f} s, " if new.timed else ""
    return f"Repaired from {where}: {longer}{farther}."


def _space(verdict: MotionVerdict) -> JointSpace:
    """The space of the joints of the scene's arm."""
    scene = verdict.scene
    settings = scene.arm
    stands = settings.base, settings.exact_axis, scene.unit, settings.base_wxyz
    arm = urdf_arm(settings.robot, settings.tool, *stands, settings.gripper, settings.allowed)
    names = verdict.problem.motion.chain.names
    if others := [name for name in names if name not in arm.joints]:
        raise AbiError(
            f"Only motions of the arm's own joints can be repaired; this one moves {others[0]}."
        )
    lowest = min(settings.base[2], scene.workspace.min[2])
    around = chain_world(arm, verdict.problem.around.obstacles, lowest)
    return JointSpace(arm, around, settings.clearance)


def _gaps(verdict: MotionVerdict, wider: int) -> list[tuple[int, int]]:
    """Numbers of the proven waypoints before and behind each part that is not proven."""
    times = verdict.problem.motion.motion.times
    open_ = [one for one in verdict.stretches if one.state != "clear"]
    gaps = list[tuple[int, int]]()
    for one in open_:
        if one.first <= times[0] or one.last >= times[-1]:
            end = "begins" if one.first <= times[0] else "ends"
            raise AbiError(
                f"The motion {end} where it is not proven clear, so there is no waypoint to plan "
                f"{'from' if end == 'begins' else 'to'}."
            )
        before = max(int(np.searchsorted(times, one.first, side="right")) - 1 - wider, 0)
        behind = min(int(np.searchsorted(times, one.last)) + wider, len(times) - 1)
        if gaps and before <= gaps[-1][1]:
            gaps[-1] = gaps[-1][0], max(behind, gaps[-1][1])
        else:
            gaps.append((before, behind))
    return gaps


def _positions(space: JointSpace, motion: Motion) -> FloatArray:
    """Positions (m, n) of the arm's joints at the waypoints, [rad] or [unit]."""
    columns = [motion.joints.index(name) for name in space.arm.joints]
    return np.asarray(motion.positions[:, columns] * space.arm.scales)


def _way(space: JointSpace, verdict: MotionVerdict, gap: tuple[int, int]) -> FloatArray:
    """Another way between two waypoints, (k, n), [rad] or [unit]."""
    motion = verdict.problem.motion.motion
    ends = _positions(space, motion)[list(gap)]
    first, last = (verdict.at(float(motion.times[k])) for k in gap)
    if not space.is_within(ends):
        raise AbiError(
            f"The motion passes the joints' limits at {first} or {last}, where the new way would "
            "begin and end."
        )
    found = search_joints(space, ends[:1], ends[1:], THOROUGH)
    if found.path is None:
        raise AbiError(
            f"No other way was found between {first} and {last}, in {found.samples:,} samples."
        )
    return found.path


def _length(space: JointSpace, motion: Motion) -> float:
    """Length of the way through a motion's waypoints, [rad], slides over the arm's reach."""
    return space.distance(_positions(space, motion))


def _with_ways(
    space: JointSpace, motion: Motion, gaps: list[tuple[int, int]], ways: list[FloatArray]
) -> Motion:
    """The motion with other ways (k, n), [rad] or [unit], between pairs of its waypoints.

    Where speeds are given, the joints rest at the waypoints of a new way, and so go straight.
    """
    order = [space.arm.joints.index(name) for name in motion.joints]
    pace = max(_length(space, motion), 1e-9) / float(np.ptp(motion.times))
    fastest = space.arm.chain.speeds * space.arm.scales
    peak = _PEAK[motion.interpolation]
    spans, positions = np.diff(motion.times), motion.positions
    rates = [motion.velocities, motion.accelerations]
    # from the last to the first, so that the numbers of earlier waypoints stay
    for (before, behind), way in reversed([*zip(gaps, ways, strict=True)]):
        edges = np.abs(np.diff(way, axis=0))
        lengths = np.linalg.norm(edges * space.weights, axis=1)
        taken = np.maximum(lengths / pace, peak * (edges / fastest).max(axis=1))
        inner = (way / space.arm.scales)[1:-1, order]
        spans = np.concatenate([spans[:before], taken, spans[behind:]])
        positions = np.concatenate([positions[: before + 1], inner, positions[behind:]])
        resting = np.zeros((len(inner) + 2, len(order)))
        rates = [
            None if one is None else np.concatenate([one[:before], resting, one[behind + 1 :]])
            for one in rates
        ]
    times = motion.times[0] + np.concatenate([[0.0], np.cumsum(spans)])
    if not motion.timed:
        times = np.arange(float(len(positions)))
    return replace(
        motion, times=times, positions=positions, velocities=rates[0], accelerations=rates[1]
    )

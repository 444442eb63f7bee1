"""MotionBenchMaker's problems for the Panda, from the given joints to the given joints.

    pip download --no-deps --no-binary vamp-planner vamp-planner
    python -m benchmarks.motion_bench vamp_planner-0.6.4.tar.gz --each 100

The object to grasp stays among the obstacles and the fingers are open. Every edge of a path is
proven; the motion along it is proven as a whole again. With coal installed, every motion is tested
at many of its poses with the exact meshes; with OMPL, its RRTConnect with simplification solves the
same problems with the same bodies, tested at samples, and lengths are compared; with RoboPlan, its
RRT-Connect with shortcuts does so with the exact meshes.
"""

from __future__ import annotations

import argparse
import time
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np

import abi
from abi.arm_planning.joint_search.joint_motion import passage_of, proven_motion
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.joint_search.joint_spline import spline_near
from abi.arm_planning.joint_search.search_joints import JointSearchEffort, search_joints
from abi.arm_planning.motion_law import motion_law
from abi.arm_planning.world.arm_worlds import chain_world
from abi.arrays import FloatArray
from abi.robot.urdf_arm import UrdfArm
from abi.scene.settings import MotionSettings
from benchmarks.motion_bench_set import MotionProblem, panda, problems

_LAW = MotionSettings(speed=0.5, acceleration=1.0, deceleration=1.0, law="slowed")
_SAMPLES = 401
_FLOOR = -1e3
"""The set has no floor, [m]."""


class Attempt(NamedTuple):
    """What came of a problem.

    Attributes:
        environment: its name.
        ends: which of start and goal are not proven clear within the limits; empty if both are.
        ms: processor time of surroundings, search and shortening, [ms].
        motion_ms: of the smooth motion and its certificate, [ms].
        length: of the path in the space of the joints, [rad]; inf without one.
        certified: whether the motion is proven.
        hits: poses of the motion at which the exact meshes touch; -1 if that was not tested.
        ompl: length of OMPL's path, [rad]; inf without one, nan if it was not asked.
        roboplan_ms: processor time of RoboPlan's search and shortcuts, [ms].
        roboplan: length of RoboPlan's path, [rad]; inf without one, nan if it was not asked.
    """

    environment: str
    ends: str
    ms: float
    motion_ms: float
    length: float
    certified: bool
    hits: int
    ompl: float
    roboplan_ms: float = np.nan
    roboplan: float = np.nan


def attempt(arm: UrdfArm, problem: MotionProblem, effort: JointSearchEffort) -> Attempt:
    """Solve one problem, and let OMPL do so."""
    begin = time.thread_time()
    surroundings = chain_world(arm, problem.obstacles, _FLOOR)
    space = JointSpace(arm, surroundings, 0.0)
    ends = {"start": problem.start, "goal": problem.goal}
    blocked = [
        name
        for name, pose in ends.items()
        if not (space.is_within(pose[None]) and space.clear(np.stack([pose, pose])))
    ]
    if blocked:
        return Attempt(problem.environment, " and ".join(blocked), 0, 0, np.inf, False, -1, np.nan)
    found = search_joints(space, problem.start[None], problem.goal[None], effort)
    took = 1e3 * (time.thread_time() - begin)
    ompl = _ompl(space, problem) if find_spec("ompl") else np.nan
    if found.path is None:
        return Attempt(problem.environment, "", took, 0, np.inf, False, -1, ompl)
    begin = time.thread_time()
    certified, positions = False, found.path
    spline = spline_near(space, found.path)
    if spline is not None:
        passage = passage_of(spline, arm)
        profile, around = motion_law(passage, _LAW), (surroundings, 0.0)
        motion, clearance = proven_motion(passage, profile, _SAMPLES, *around)
        certified, positions = clearance.certified, motion.positions
    motion_ms = 1e3 * (time.thread_time() - begin)
    hits = _hits(arm, problem, positions) if find_spec("coal") else -1
    return Attempt(problem.environment, "", took, motion_ms, found.length, certified, hits, ompl)


def _hits(arm: UrdfArm, problem: MotionProblem, positions: FloatArray) -> int:
    from benchmarks.motion_bench_oracles import poses_touching

    return poses_touching(arm, problem.obstacles, positions)


def _ompl(space: JointSpace, problem: MotionProblem) -> float:
    from benchmarks.motion_bench_oracles import ompl_length

    return ompl_length(space, problem.start, problem.goal)


def table(attempts: list[Attempt]) -> str:
    """Rows by environment, and one for all."""
    lines = [
        "| environment | problems | ends clear | solved | proven | ms, median | ms, 95 % | "
        "motion ms | touching |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, rows in _by_environment(attempts):
        clear = [one for one in rows if not one.ends]
        solved = [one for one in clear if np.isfinite(one.length)]
        times = [one.ms for one in clear] or [np.nan]
        tested = [one.hits for one in solved if one.hits >= 0]
        touching = str(sum(hits > 0 for hits in tested)) if tested else "–"
        motion = [one.motion_ms for one in solved] or [np.nan]
        lines.append(
            f"| {name} | {len(rows)} | {len(clear)} | {len(solved)} | "
            f"{sum(one.certified for one in solved)} | {np.median(times):.0f} | "
            f"{np.quantile(times, 0.95):.0f} | {np.median(motion):.0f} | {touching} |"
        )
    return "\n".join(lines)


def rivals_table(attempts: list[Attempt]) -> str:
    """What OMPL and RoboPlan solve of the problems with clear ends, and lengths over theirs."""
    lines = [
        "| environment | tried | solved | OMPL | RoboPlan | RoboPlan ms, median | ms, 95 % | "
        "length / OMPL's | length / RoboPlan's |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, rows in _by_environment([one for one in attempts if not one.ends]):
        ours, ompl, roboplan = (
            np.array([(one.length, one.ompl, one.roboplan) for one in rows]).reshape(-1, 3).T
        )
        times = [one.roboplan_ms for one in rows]
        lines.append(
            f"| {name} | {len(rows)} | {np.isfinite(ours).sum()} | {np.isfinite(ompl).sum()} | "
            f"{np.isfinite(roboplan).sum()} | {np.median(times):.0f} | "
            f"{np.quantile(times, 0.95):.0f} | {_ratio(ours, ompl)} | {_ratio(ours, roboplan)} |"
        )
    return "\n".join(lines)


def _by_environment(attempts: list[Attempt]) -> list[tuple[str, list[Attempt]]]:
    """The attempts of each environment, and all of them."""
    names = dict.fromkeys(one.environment for one in attempts)
    parts = [(name, [one for one in attempts if one.environment == name]) for name in names]
    return [*parts, ("all", attempts)]


def _ratio(ours: FloatArray, theirs: FloatArray) -> str:
    """Median ratio of the lengths of the paths that both found."""
    both = np.isfinite(ours) & np.isfinite(theirs)
    return f"{np.median(ours[both] / theirs[both]):.2f}" if both.any() else "–"


def main() -> None:
    """Solve the problems and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("archive", type=Path, help="VAMP's source distribution")
    parser.add_argument("--each", type=int, default=100, help="problems of each environment")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    abi.compile()
    arm, effort = panda(given.archive), JointSearchEffort(seed=given.seed)
    chosen = list(problems(given.archive, given.each))
    attempts = [attempt(arm, one, effort) for one in chosen]
    if find_spec("roboplan"):
        attempts = _beside_roboplan(attempts, chosen, given)
    print(table(attempts), rivals_table(attempts), sep="\n\n")


def _beside_roboplan(
    attempts: list[Attempt], chosen: list[MotionProblem], given: argparse.Namespace
) -> list[Attempt]:
    """The attempts with what RoboPlan answers to the same problems."""
    from benchmarks.motion_bench_roboplan import RoboPlanArm

    arm, answered = RoboPlanArm(given.archive), []
    for one, problem in zip(attempts, chosen, strict=True):
        answer = arm.answer(problem, given.seed)
        answered.append(one._replace(roboplan_ms=answer.ms, roboplan=answer.length))
    return answered


if __name__ == "__main__":
    main()

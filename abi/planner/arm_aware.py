"""Plans for the whole arm: path and curves on the elbow branch where they are shortest.

The tool's own plan comes first; only where its arm is not clear, or not proven so, this one is
made. Each branch has its own graph, without the nodes at which the arm would be out of reach, past
a limit or too near; the branches meet only where the arm is stretched, so they are searched one by
one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np

from abi.arm import trajectory
from abi.arm.arm import Arm
from abi.arm.arm_certificate import ArmRefutation
from abi.arm.arm_clearance import arm_clearance, named
from abi.arm.arm_sight import ArmSight
from abi.arm.liquid import largest_tilt
from abi.arm.motion_law import JointPath, motion_law
from abi.arm.surroundings import Surroundings
from abi.arm.wrist_drives import wrist_positions
from abi.curves import fit_quadratic, speed_profile
from abi.curves.curve import ArcLength, Curve, arc_length
from abi.curves.timed_profile import PathProfile
from abi.errors import ArmNotClear, NoPath
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.arm_exclusion import ArmExclusionCache
from abi.planner.arm_path import ArmGraphPath, fit_clear, pull_clear, search_clear
from abi.scene.scene import Elbow, Scene
from abi.search.graph import Graph
from abi.search.graph import build as build_graph
from abi.search.search import SEARCHES, SearchResult
from abi.tet_mesh.exclusion import FreeMesh

Weight = Literal["length", "hops"]

_LONGER = 1.5
"""Longest path, as a multiple of the straight line, whose time bounds the slide beforehand."""


@dataclass(frozen=True, eq=False)
class ArmTask:
    """A scene's arm and what its plan begins with.

    Attributes:
        scene: the scene.
        arm: its arm.
        obstacles: its obstacles.
        around: these, the floor and the column.
        free: the mesh that the tool may use.
        margin: distance that edges keep from the obstacles, [unit].
        samples: of the motion.
    """

    scene: Scene
    arm: Arm
    obstacles: ObstacleSet
    around: Surroundings
    free: FreeMesh
    margin: float
    samples: int

    def sight(self, elbow: Elbow) -> ArmSight:
        """The arm on one branch."""
        scene = self.scene
        slack = self.margin - scene.spline.clearance
        clearance = scene.arm.clearance
        return ArmSight(self.arm, elbow, self.around, _extensions(scene), clearance, slack)


@dataclass(frozen=True, eq=False)
class _Branch:
    """A path on one branch."""

    sight: ArmSight
    free: FreeMesh
    found: ArmGraphPath


class ArmAware:
    """Plans for the whole arm, with the memory of what it excludes from the mesh."""

    def __init__(self) -> None:
        self._exclude = {"up": ArmExclusionCache(), "down": ArmExclusionCache()}

    def __call__(self, task: ArmTask, names: list[str]) -> dict[str, Any]:
        """Results of the stages from the free mesh on, for a motion whose arm is proven clear.

        Args:
            task: the scene and its arm.
            names: searches to run; the scene's own goes on.

        Raises:
            ArmNotClear: neither branch has one; tells why.
        """
        scene = task.scene
        faults: dict[Elbow, ArmNotClear] = {}
        branches: list[_Branch] = []
        for elbow in scene.arm.branches:
            try:
                branches.append(self._branch(task, elbow))
            except ArmNotClear as fault:
                faults[elbow] = fault
        for branch in sorted(branches, key=_cost):
            try:
                return _finish(task, branch, names)
            except ArmNotClear as fault:
                faults[branch.sight.elbow] = fault
        found = list(faults.values())
        raise found[0] if len(found) == 1 else ArmNotClear.of_both(found)

    def _branch(self, task: ArmTask, elbow: Elbow) -> _Branch:
        """The path on one branch."""
        scene, sight = task.scene, task.sight(elbow)
        for which, point in (("start", scene.start), ("goal", scene.goal)):
            fault = sight.leg_refutation(np.array([point]))
            if fault is not None:
                raise ArmNotClear(elbow, which, *_named(fault, task.arm))
        lowest = scene.workspace.min[2]
        free = self._exclude[elbow](task.free, sight, task.obstacles, lowest)
        search = partial(_search, scene.search.algorithm, scene.search.weight)
        try:
            graph = build_graph(
                free, task.obstacles, task.margin, scene.start, scene.goal, scene.spline.clearance
            )
            found = search_clear(graph, sight, search)
        except NoPath:
            raise ArmNotClear(elbow, "path") from None
        if found is None:
            raise ArmNotClear(elbow, "path")
        return _Branch(sight, free, found)


def _finish(task: ArmTask, branch: _Branch, names: list[str]) -> dict[str, Any]:
    """Curves and motion along a branch's path."""
    scene, obstacles, sight = task.scene, task.obstacles, branch.sight
    clearance, chosen = scene.spline.clearance, scene.search
    graph, path = branch.found.graph, branch.found.path
    others = (name for name in names if name != chosen.algorithm)
    searches = {name: _search(name, chosen.weight, graph) for name in others}
    searches[chosen.algorithm] = path
    results: dict[str, Any] = {
        "free": branch.free,
        "graph": graph,
        "searches": tuple(searches[name] for name in names),
        "path": path,
        "path_clearance": obstacles.polyline_clearance(path.points),
    }
    vertices = path.points
    if chosen.taut:
        results["taut"] = taut = pull_clear(graph, obstacles, task.margin, path, sight)
        vertices = taut.points
    bspline = fit_clear(vertices, scene.spline.degree, obstacles, clearance, sight)
    if bspline is None:
        raise ArmNotClear(sight.elbow, "curve")
    results["bspline"] = bspline
    results["bspline_arc"] = arc = arc_length(bspline.curve)
    quadratic = fit_quadratic.fit(bspline, arc, obstacles, clearance, scene.quadratic.mode)
    fault = sight.refutation(quadratic.curve) if quadratic.holds else None
    if fault is not None:
        quadratic = replace(quadratic, note=_note(fault, task.arm))
    results["quadratic"] = quadratic
    results["quadratic_arc"] = quadratic_arc = arc_length(quadratic.curve)
    followed = scene.motion.curve
    if followed == "auto":
        followed = "quadratic" if quadratic.holds and fault is None else "bspline"
    results["followed"] = followed
    by_quadratic = followed == "quadratic"
    curve: Curve = quadratic.curve if by_quadratic else bspline.curve
    results |= _motion(task, sight.elbow, curve, quadratic_arc if by_quadratic else arc)
    return results


def _motion(task: ArmTask, elbow: Elbow, curve: Curve, arc: ArcLength) -> dict[str, Any]:
    """The motion along a curve, if its arm is proven clear."""
    settings, arm = task.scene.arm.on(elbow), task.arm
    asked = task.scene.motion
    profile: PathProfile
    if asked.law == "three_phase":
        profile = speed_profile.three_phase(
            arc.length, asked.speed, asked.acceleration, asked.deceleration
        )
    else:
        profile = motion_law(JointPath(curve, arc, arm, settings), asked)
    motion = trajectory.follow(curve, arc, profile, arm, settings, task.samples)
    clearance = arm_clearance(motion, arm, task.obstacles, task.around, settings.clearance)
    if not (motion.reachable and motion.within_limits and clearance.certified):
        raise ArmNotClear(elbow, "curve")
    return {
        "profile": profile,
        "liquid_tilt": largest_tilt(curve, arc, profile, task.scene.unit),
        "motion": motion,
        "arm_clearance": clearance,
    }


def _search(algorithm: str, weight: Weight, graph: Graph) -> SearchResult:
    return SEARCHES[algorithm](graph, weight)


def _cost(branch: _Branch) -> float:
    return branch.found.path.cost


def _named(fault: ArmRefutation, arm: Arm) -> tuple[str, int | str | None]:
    """Link and obstacle of a fault; the obstacle is None where the place is out of reach."""
    if fault.capsule < 0:
        return "", None
    return arm.capsules[fault.capsule].link, named(fault.obstacle, arm)


def _note(fault: ArmRefutation, arm: Arm) -> str:
    link, obstacle = _named(fault, arm)
    if obstacle is None:
        return "Along it the arm is out of reach or past a limit; the B-spline is followed."
    name = f"obstacle {obstacle + 1}" if isinstance(obstacle, int) else f"the {obstacle}"
    return f"Along it the {link.replace('_', ' ')} may touch {name}; the B-spline is followed."


def _extensions(scene: Scene) -> tuple[float, float]:
    """Least and greatest q5 in the time that a rather long path takes, [unit]."""
    settings, asked = scene.arm, scene.motion
    if settings.forces[1] == 0:
        return settings.q5, settings.q5
    straight = float(np.linalg.norm(np.subtract(scene.goal, scene.start)))
    longest = speed_profile.three_phase(
        _LONGER * straight, asked.speed, asked.acceleration, asked.deceleration
    )
    end = float(wrist_positions(settings, [longest.duration])[0, 1])
    return min(settings.q5, end), max(settings.q5, end)

"""Plans for the whole arm: path and curves on the branch where they are shortest.

They are made only if the arm is not proven clear along the tool's own plan. Each branch has its own
graph, without the nodes at which the arm would be out of reach, past a limit or too near. The
branches of the paper's arm are the two sides of its elbow, which meet only where the arm is
stretched; those of another arm are its start poses. They are searched one by one. If none of them
leads to a motion, an arm with redundant joints has further ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from abi.arm_planning.arm_model import ArmModel, OtherSights, Sight, SightTask, Unreached
from abi.arm_planning.branch.arm_exclusion import ArmExclusionCache
from abi.arm_planning.branch.arm_path import ArmGraphPath, fit_clear, pull_clear, search_clear
from abi.arm_planning.certificates.arm_certificate import ArmRefutation
from abi.arm_planning.motion.arm_clearance import is_clear, named
from abi.arm_planning.motion_law import motion_law
from abi.arm_planning.world.surroundings import Surroundings
from abi.curves import fit_quadratic
from abi.curves.bspline import BSpline
from abi.curves.curve import ArcLength, Curve, arc_length
from abi.curves.fit import Fit
from abi.errors import ArmNotClear, NoPath
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.any_arm import AnyArm
from abi.scene.scene import Scene
from abi.search.build_graph import build_graph
from abi.search.search import search
from abi.search.taut.taut_path import TautPath
from abi.tet_mesh.exclusion import FreeMesh

_PATIENCE = 20
"""Times as many tries to prove a leg clear where there is no path else."""
_ROOMS = (1.0, 4.0, 16.0)
"""Multiples of the slack with which a path is pulled taut, until there is a curve near it."""


@dataclass(frozen=True, eq=False)
class ArmTask:
    """Input of a plan for the whole arm.

    Attributes:
        scene: the scene.
        model: its arm.
        obstacles: its obstacles.
        surroundings: everything around the arm.
        free: the mesh that the tool may use.
        taut: the path of the tool alone pulled taut; None if the scene does not ask for that.
        margin: distance that edges keep from the obstacles, [unit].
        samples: number of samples of the motion.
    """

    scene: Scene
    model: ArmModel
    obstacles: ObstacleSet
    surroundings: Surroundings
    free: FreeMesh
    taut: TautPath | None
    margin: float
    samples: int

    @property
    def sights(self) -> Sequence[Sight]:
        """The arm on each of its branches."""
        return self.model.sights(self._of_sights)

    @property
    def other_sights(self) -> OtherSights:
        """The arm on further branches, to try if those lead to no motion."""
        return self.model.other_sights(self._of_sights)

    @property
    def _of_sights(self) -> SightTask:
        slack = self.margin - self.scene.spline.clearance
        return SightTask(self.scene, self.obstacles, self.surroundings, self.free.mesh, slack)


@dataclass(frozen=True, eq=False)
class _Branch:
    """A path on one branch."""

    sight: Sight
    free: FreeMesh
    found: ArmGraphPath


class ArmAware:
    """Planner for the whole arm, which remembers what the arm excludes from the mesh."""

    def __init__(self) -> None:
        self._exclude: dict[str, ArmExclusionCache] = {}

    def __call__(self, task: ArmTask, names: list[str]) -> dict[str, Any]:
        """Results of the stages from the free mesh on, for a motion whose arm is proven clear.

        Args:
            task: the scene and its arm.
            names: searches to run; the scene's own goes on.

        Raises:
            ArmNotClear: no branch has one; tells why.
        """
        faults: dict[str, ArmNotClear] = {}
        branches = self._branches(task, task.sights, faults)
        if not branches:  # near the base axis, and along an obstacle, a proof may take more
            shut = [s for s in task.sights if faults[s.branch].where == "path"]
            branches = self._branches(task, [s.scaled(tries=_PATIENCE) for s in shut], faults)
        for branch in sorted(branches, key=_cost):
            try:
                return _finish(task, branch, names)
            except ArmNotClear as fault:
                faults[branch.sight.branch] = fault
        return self._otherwise(task, names, [*faults.values()])

    def _otherwise(
        self, task: ArmTask, names: list[str], faults: Sequence[ArmNotClear]
    ) -> dict[str, Any]:
        """Results of the first of the further branches that leads to a motion.

        Raises:
            ArmNotClear: there is none.
        """
        others = task.other_sights
        found = []
        for number, sight in enumerate(others.sights):
            try:
                return _finish(task, self._branch(task, sight, f"other {number}"), names)
            except ArmNotClear as fault:
                found.append(fault)
        raise ArmNotClear.of_all(faults, found, others.note)

    def _branches(
        self, task: ArmTask, sights: Sequence[Sight], faults: dict[str, ArmNotClear]
    ) -> list[_Branch]:
        """The branches that have a path; ``faults`` gets why the others have none."""
        branches = []
        for sight in sights:
            try:
                branches.append(self._branch(task, sight, sight.branch))
            except ArmNotClear as fault:
                faults[sight.branch] = fault
        return branches

    def _branch(self, task: ArmTask, sight: Sight, memory: str) -> _Branch:
        """The path on one branch; what it excludes is kept in a ``memory`` of that name."""
        scene = task.scene
        for which, point in (("start", scene.start), ("goal", scene.goal)):
            fault = sight.leg_refutation(np.array([point]))
            if fault is not None:
                link, obstacle = _named(fault, task.model.arm)
                unreached = sight.unreached(np.array(point)) if obstacle is None else None
                raise _not_clear(task, sight, which, link, obstacle, unreached)
        exclude = self._exclude.setdefault(memory, ArmExclusionCache())
        free = exclude(task.free, sight, task.obstacles)
        find = partial(search, scene.search.algorithm, weight=scene.search.weight)
        try:
            graph = build_graph(
                free, task.obstacles, task.margin, scene.start, scene.goal, scene.spline.clearance
            )
            found = search_clear(graph, sight, find)
        except NoPath:
            raise _not_clear(task, sight, "path") from None
        if found is None:
            raise _not_clear(task, sight, "path")
        return _Branch(sight, free, found)


def _finish(task: ArmTask, branch: _Branch, names: list[str]) -> dict[str, Any]:
    """Curves and motion along a branch's path; ``Planner._run`` makes those of the tool alone."""
    scene, obstacles, sight = task.scene, task.obstacles, branch.sight
    clearance, chosen = scene.spline.clearance, scene.search
    graph, path = branch.found.graph, branch.found.path
    others = (name for name in names if name != chosen.algorithm)
    searches = {name: search(name, graph, chosen.weight) for name in others}
    searches[chosen.algorithm] = path
    results: dict[str, Any] = {
        "free": branch.free,
        "graph": graph,
        "searches": tuple(searches[name] for name in names),
        "path": path,
        "path_clearance": obstacles.polyline_clearance(path.points),
    }
    results |= _fitted(task, branch, results["path_clearance"])
    bspline: Fit[BSpline] = results["bspline"]
    results["bspline_arc"] = arc = arc_length(bspline.curve)
    refutation = lru_cache(sight.refutation)  # the curve taken has been asked about already
    quadratic = fit_quadratic.fit(
        *(bspline, arc, obstacles, clearance, scene.quadratic.mode),
        lambda curve: refutation(curve) is None,
    )
    fault = refutation(quadratic.curve) if quadratic.holds else None
    if fault is not None:
        quadratic = replace(quadratic, note=_note(fault, task.model.arm))
    results["quadratic"] = quadratic
    results["quadratic_arc"] = arc_length(quadratic.curve)
    followed = scene.motion.curve
    if followed == "auto":
        followed = "quadratic" if quadratic.holds and fault is None else "bspline"
    results["followed"] = followed
    return results | _motion(task, sight, results[followed].curve, results[f"{followed}_arc"])


def _fitted(task: ArmTask, branch: _Branch, path_clearance: float) -> dict[str, Any]:
    """The path pulled taut, if asked for, and a B-spline near it.

    Where no curve near the taut path is proven clear, it is pulled with more room to round its
    corners, which makes it a little longer.
    """
    obstacles, path, wanted = task.obstacles, branch.found.path, task.scene.spline
    for times in _ROOMS if task.taut is not None else _ROOMS[:1]:
        found: dict[str, Any] = {}
        vertices, away = path.points, path_clearance
        if task.taut is not None:
            roomy = branch.sight.scaled(slack=times)
            found["taut"] = pulled = pull_clear(task.taut, obstacles, task.margin, path, roomy)
            vertices, away = pulled.points, pulled.clearance
        bspline = fit_clear(
            vertices, wanted.degree, obstacles, wanted.clearance, away, branch.sight
        )
        if bspline is not None:
            return found | {"bspline": bspline}
    raise _not_clear(task, branch.sight, "curve")


def _motion(task: ArmTask, sight: Sight, curve: Curve, arc: ArcLength) -> dict[str, Any]:
    """The motion along a curve, if its arm is proven clear."""
    scene = task.scene
    course = sight.course(curve, arc)
    profile = motion_law(course, scene.motion)
    motion = course.motion(profile, task.samples)
    clearance = course.clearance(motion, task.obstacles, task.surroundings, scene.arm.clearance)
    found = {"profile": profile, "motion": motion, "arm_clearance": clearance}
    if not is_clear(motion, clearance):
        raise _not_clear(task, sight, "curve")
    return found


def _not_clear(
    task: ArmTask,
    sight: Sight,
    where: str,
    link: str = "",
    obstacle: int | str | None = None,
    unreached: Unreached | None = None,
) -> ArmNotClear:
    has_elbow = task.model.arm.has_elbow
    if unreached is None:
        return ArmNotClear(sight.branch, where, link, obstacle, has_elbow=has_elbow)
    return ArmNotClear(sight.branch, where, has_elbow=has_elbow, why=unreached.words)


def _cost(branch: _Branch) -> float:
    return branch.found.path.cost


def _named(fault: ArmRefutation, arm: AnyArm) -> tuple[str, int | str | None]:
    """Link and obstacle of a fault; the obstacle is None where the place is out of reach."""
    if fault.capsule < 0:
        return "", None
    return arm.capsules[fault.capsule].link, named(fault.obstacle, arm)


def _note(fault: ArmRefutation, arm: AnyArm) -> str:
    link, obstacle = _named(fault, arm)
    if obstacle is None:
        why = "the arm would pass its reach or a joint limit"
        return f"On this curve {why}, so it follows the B-spline."
    name = f"obstacle {obstacle + 1}" if isinstance(obstacle, int) else f"the {obstacle}"
    why = f"the {link.replace('_', ' ')} may touch {name}"
    return f"On this curve {why}, so the arm follows the B-spline."

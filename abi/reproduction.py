"""The paper's figures beside ours: what can be reproduced, and where its print is wrong.

Everything is computed anew from the shipped scene ``paper`` and from seeded random ones.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from abi import bspline, graph, ik, mesh, net, printed, quadratic, timing
from abi.arm import Arm, forward
from abi.arrays import FloatArray
from abi.clearance import measure_polyline
from abi.curve import measure
from abi.drives import driven
from abi.errors import StageError
from abi.plan import Plan, plan
from abi.scene import Scene, load_scene
from abi.search import a_star

Verdict = Literal["holds", "depends on the mesh", "does not hold"]

_NAMES = {"dijkstra": "Dijkstra", "bellman_ford": "Bellman-Ford", "a_star": "A*"}

_POSES = 10_000
_MESHES = 9
_SCENES = 100


@dataclass(frozen=True)
class Comparison:
    """One statement of the paper beside what we find.

    Attributes:
        where: the part of the paper.
        what: the statement's subject.
        printed: what the paper says.
        ours: what the method gives.
        verdict: whether what is printed holds. The mesh is not printed: of figures that depend on
            it only order and size can be compared.
    """

    where: str
    what: str
    printed: str
    ours: str
    verdict: Verdict


def compare() -> tuple[Comparison, ...]:
    """All comparisons, in the order of the paper."""
    scene = load_scene("paper")
    by_length = plan(scene)
    by_hops = plan(scene.replace(search={"weight": "hops"}))
    return (
        *_mesh(scene),
        *_table_one(by_length, by_hops),
        *_spline(scene, by_length),
        *_quadratic(scene, by_length),
        *_motion(by_length),
        *_kinematics(),
        *_drives(scene),
    )


def _mesh(scene: Scene) -> Iterator[Comparison]:
    where = "stage 1, mesh"
    through, tested = zip(
        *((_enters_by_nodes(one), _enters(one)) for one in _random_scenes(scene)), strict=True
    )
    yield Comparison(
        where,
        "excluding the nodes in the obstacles",
        "is enough",
        f"{sum(through)} of {_SCENES} random scenes have a path through an obstacle; with edges "
        f"tested, too, {sum(tested)}",
        "does not hold",
    )
    factors = [_detour(scene, pitch) for pitch in (1.0, 0.5, 0.25)]
    yield Comparison(
        where,
        "reducing the pitch",
        "increases the accuracy",
        "a path without obstacles is "
        + ", ".join(f"{100 * (factor - 1):.1f} %" for factor in factors)
        + " too long at pitch 1, ½, ¼ (Kuhn)",
        "does not hold",
    )


def _table_one(by_length: Plan, by_hops: Plan) -> Iterator[Comparison]:
    where = "Table I"
    lengths = {result.algorithm: result.length for result in by_length.searches}
    hops = {result.algorithm: result for result in by_hops.searches}
    for name, length in printed.LENGTHS.items():
        yield Comparison(
            where,
            f"{_NAMES[name]}, length of the path",
            f"{length:.3f}",
            f"{lengths[name]:.3f} by length, {hops[name].length:.3f} by hops",
            "depends on the mesh",
        )
    yield Comparison(
        where,
        "vertices of the paths",
        f"{printed.VERTICES}, all three",
        ", ".join(str(result.hops + 1) for result in hops.values()) + " by hops",
        "depends on the mesh",
    )
    spread = max(lengths.values()) - min(lengths.values())
    yield Comparison(
        where,
        "the three lengths on one graph",
        "differ by up to 0.400",
        f"differ by {spread:.0e}: by length all three are exact" if spread else "are the same",
        "does not hold",
    )


def _spline(scene: Scene, made: Plan) -> Iterator[Comparison]:
    where = "stage 4, B-spline"
    assert made.path is not None
    assert made.bspline is not None
    assert made.bspline.holds
    assert made.bspline_arc is not None
    share = made.bspline_arc.length / made.path.length
    yield Comparison(
        where,
        "length of degree 4",
        f"{printed.BSPLINE_LENGTH:.2f}, {printed.BSPLINE_LENGTH / printed.LENGTHS['a_star']:.3f}"
        " of A*'s path",
        f"{made.bspline_arc.length:.2f}, {share:.3f} of A*'s path; proven clear by "
        f"{made.bspline.clearance.distance:.3f}",
        "depends on the mesh",
    )
    splines, squares = zip(*_as_printed(scene), strict=True)
    yield Comparison(
        where,
        "with the path's vertices as control points",
        "does not enter the obstacle",
        _entered(splines),
        "does not hold" if min(splines) < 0 else "holds",
    )
    yield Comparison(
        "stage 5, quadratic",
        "fitted to the spline by least squares",
        "bypasses the obstacle",
        _entered(squares),
        "does not hold" if min(squares) < 0 else "holds",
    )


def _quadratic(scene: Scene, made: Plan) -> Iterator[Comparison]:
    where = "stage 5, quadratic"
    assert made.path is not None
    assert made.quadratic is not None
    assert made.quadratic_arc is not None
    length, path = made.quadratic_arc.length, made.path.length
    yield Comparison(
        where,
        "length",
        f"{printed.QUADRATIC_LENGTH:.3f}, "
        f"{printed.QUADRATIC_LENGTH / printed.LENGTHS['a_star']:.3f} of A*'s path",
        f"{length:.3f}, {length / path:.3f} of A*'s path",
        "depends on the mesh",
    )
    yield Comparison(
        where,
        "length of the printed polynomials",
        f"{printed.QUADRATIC_LENGTH:.3f}",
        f"{measure(printed.QUADRATIC).length:.4f}",
        "holds",
    )
    yield Comparison(
        where,
        "ends of the printed polynomials",
        "exact",
        " to ".join(str(tuple(printed.QUADRATIC(t).round(9).tolist())) for t in (0, 1)),
        "holds",
    )
    room = {side: _room_beside(scene, side) for side in (2.0, 2.5, 3.0)}
    yield Comparison(
        where,
        "the printed polynomials and the cube",
        "bypass it; its side is not printed",
        "clearance " + ", ".join(f"{room[side]:+.3f} for side {side:g}" for side in room),
        "holds",
    )
    speeds = np.linalg.norm(printed.QUADRATIC([0.0, 0.5, 1.0], 1), axis=1)
    yield Comparison(
        where,
        "speed along the printed polynomials",
        "rises, stays, falls",
        " → ".join(f"{speed:.2f}" for speed in speeds) + " at t = 0, ½, 1",
        "does not hold",
    )


def _motion(made: Plan) -> Iterator[Comparison]:
    assert made.quadratic_arc is not None
    profile = timing.three_phase(made.quadratic_arc.length, 4.0, 6.0, 3.0)
    yield Comparison(
        "Theorem 1",
        "t1 = t3·|a3 / a1|, for a1 = 6, a3 = 3",
        "proven",
        f"{profile.t1:.4f} s = {profile.t3 * abs(-3.0 / 6.0):.4f} s",
        "holds",
    )


def _kinematics() -> Iterator[Comparison]:
    where = "stage 6, arm"
    arm = Arm.from_settings(Scene(version=1).arm.model_copy(update={"base": (0.0, 0.0, 0.0)}))
    poses, tool = _facing_poses(arm)
    solved = np.zeros_like(poses)
    found = ik.solve(arm, tool, np.zeros(_POSES), "up", np.zeros_like(tool))
    solved[:, :3] = np.stack([found.q1, found.q2, found.q3], axis=1)
    miss = float(np.abs(forward(arm, solved) - tool).max())
    r = arm.a3 * np.sin(poses[:, 1]) + (arm.a4 + arm.a5) * np.sin(poses[:, 1] + poses[:, 2])
    right = {
        "y = cos q1·r": (np.cos(poses[:, 0]) * r, tool[:, 1]),
        "y = −cos q1·r": (-np.cos(poses[:, 0]) * r, tool[:, 1]),
        "q1 by arccos": (printed.q1(tool), poses[:, 0]),
        "q1 = atan2(x, −y)": (np.arctan2(tool[:, 0], -tool[:, 1]), poses[:, 0]),
        "q2 with a3²·Pza": (printed.cos_q2(arm, tool, "printed"), np.cos(poses[:, 1])),
        "q2 with a3³·Pza": (printed.cos_q2(arm, tool, "corrected"), np.cos(poses[:, 1])),
    }
    shares = {name: _share(*sides) for name, sides in right.items()}
    for wrong, corrected in zip(list(shares)[::2], list(shares)[1::2], strict=True):
        yield Comparison(
            where,
            wrong,
            "the solution",
            f"right in {shares[wrong]:.0f} % of {_POSES:,} poses; {corrected}: "
            f"{shares[corrected]:.0f} %",
            "does not hold",
        )
    yield Comparison(
        where,
        "forward after inverse kinematics",
        "the tool's place",
        f"within {miss:.0e} in {_POSES:,} poses",
        "holds",
    )


def _drives(scene: Scene) -> Iterator[Comparison]:
    still = scene.arm.model_copy(update={"forces": (1.0, 1.0, 1.0), "q5": 0.0})
    inertia = sum(mass * i**2 for mass, i in zip(still.masses, still.radii, strict=True))
    time = np.linspace(0, 1, 1001)
    forces = {}
    for dynamics in ("as_printed", "corrected"):
        q4 = driven(still.model_copy(update={"dynamics": dynamics}), time)[:, 0]
        forces[dynamics] = inertia * float(np.diff(q4, 2).mean()) / time[1] ** 2
    yield Comparison(
        "stage 6, drives",
        "q4 = t²·Q / I under the force Q",
        "the solution",
        f"it takes {forces['as_printed']:.3f} Q; t²·Q / (2·I) takes {forces['corrected']:.3f} Q",
        "does not hold",
    )


def _random_scenes(scene: Scene) -> Iterator[Scene]:
    """Scenes with one to four boxes, some of them thin, which leave start and goal free."""
    rng = np.random.default_rng(0)
    made = 0
    while made < _SCENES:
        boxes = [
            {
                "shape": "box",
                "size": rng.uniform(0.3, 3, 3).tolist(),
                "position": rng.uniform(1, 5, 3).tolist(),
                "wxyz": rng.normal(size=4).tolist(),
            }
            for _ in range(rng.integers(1, 5))
        ]
        one = scene.replace(obstacles=boxes, spline={"clearance": 0.0})
        ends = np.array([one.start, one.goal])
        if min(body.signed_distance(ends).min() for body in one.obstacles) > 0:
            made += 1
            yield one


def _enters(scene: Scene) -> bool:
    """Whether our path is through an obstacle."""
    ends = scene.start, scene.goal
    whole = mesh.tetrahedralise(scene.workspace, scene.mesh)
    try:
        free = mesh.exclude(whole, scene.obstacles, 0.0)
        path = a_star(graph.build(free, scene.obstacles, 0.0, *ends, 0.0), "length")
    except StageError:
        return False
    return measure_polyline(path.points, scene.obstacles) < 0


def _enters_by_nodes(scene: Scene) -> bool:
    """Whether the shortest path is through an obstacle where only nodes in it are excluded."""
    whole = mesh.tetrahedralise(scene.workspace, scene.mesh)
    inside = np.zeros(len(whole.points), dtype=bool)
    for body in scene.obstacles:
        inside |= body.signed_distance(whole.points) < 0
    kept = ~inside[whole.edges].any(axis=1)
    indptr, indices, lengths = net.rows(whole.edges[kept], whole.lengths[kept], len(whole.points))
    rows = scipy.sparse.csr_array((lengths, indices, indptr), shape=(len(whole.points),) * 2)
    first, last = (
        int(((whole.points - end) ** 2).sum(axis=1).argmin()) for end in (scene.start, scene.goal)
    )
    _, before = scipy.sparse.csgraph.dijkstra(rows, indices=first, return_predecessors=True)
    way = [last]
    while way[-1] != first:
        if before[way[-1]] < 0:
            return False
        way.append(int(before[way[-1]]))
    return measure_polyline(whole.points[way], scene.obstacles) < 0


def _detour(scene: Scene, pitch: float) -> float:
    """A* without obstacles from one lower corner to the opposite upper one, over the straight line:
    from the corner from which Kuhn's diagonals lead away."""
    made = plan(
        scene.replace(
            obstacles=[],
            start=[6.0, 0.0, 0.0],
            goal=[0.0, 6.0, 6.0],
            mesh={"lattice": "kuhn", "pitch": pitch},
        )
    )
    assert made.path is not None
    return made.path.length / made.lower_bound


def _as_printed(scene: Scene) -> Iterator[tuple[float, float]]:
    """Clearance of spline and quadratic, [unit], made as printed on irregular meshes: with nothing
    to hold them off the obstacle."""
    for seed in range(_MESHES):
        made = plan(
            scene.replace(
                mesh={"lattice": "delaunay", "pitch": 1.0, "seed": seed},
                spline={"clearance": 0.0},
            )
        )
        assert made.path is not None
        spline = bspline.clamped(made.path.points, scene.spline.degree)
        square = quadratic.fit(spline, measure(spline), scene.obstacles, 0.0)
        points = np.linspace(0, 1, 4001)
        yield (
            measure_polyline(spline(points), scene.obstacles),
            measure_polyline(square(points), scene.obstacles),
        )


def _entered(clearances: tuple[float, ...]) -> str:
    inside = [one for one in clearances if one < 0]
    deepest = f", by up to {-min(inside):.2f}" if inside else ""
    return f"enters it in {len(inside)} of {len(clearances)} meshes{deepest}"


def _room_beside(scene: Scene, side: float) -> float:
    """Clearance of the printed quadratic from the cube with such a side, [unit]."""
    cube = scene.replace(
        obstacles=[{"shape": "box", "size": 3 * [side], "position": [3, 3, 3]}]
    ).obstacles
    return measure_polyline(printed.QUADRATIC(np.linspace(0, 1, 4001)), cube)


def _facing_poses(arm: Arm) -> tuple[FloatArray, FloatArray]:
    """Random poses (n, 6) in which the tool is in front of the arm, and where it is (n, 3)."""
    poses = np.zeros((_POSES, 6))
    rng = np.random.default_rng(0)
    poses[:, :3] = rng.uniform(-np.pi, np.pi, (_POSES, 3))
    r = arm.a3 * np.sin(poses[:, 1]) + (arm.a4 + arm.a5) * np.sin(poses[:, 1] + poses[:, 2])
    # the same pose with the arm turned round
    poses[:, 0] = np.where(r < 0, np.angle(-np.exp(1j * poses[:, 0])), poses[:, 0])
    poses[:, 1:3] *= np.where(r < 0, -1, 1)[:, None]
    return poses, forward(arm, poses)


def _share(found: FloatArray, wanted: FloatArray) -> float:
    """In how many of a hundred poses one of the values found is the one wanted."""
    return 100 * float((np.abs(found - wanted) < 1e-6).reshape(-1, len(wanted)).any(axis=0).mean())

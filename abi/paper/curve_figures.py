"""What the paper says of its curves and their motion, stages 4 and 5, beside what we find."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from abi.curves import speed_profile as timing
from abi.curves.bspline import clamped
from abi.curves.curve import arc_length
from abi.curves.quadratic import least_squares
from abi.obstacles.obstacle_set import ObstacleSet
from abi.paper import printed
from abi.paper.comparison import Comparison
from abi.planner.plan import Plan
from abi.planner.planner import plan
from abi.scene.scene import Scene

_MESHES = 9


def of_splines(scene: Scene, made: Plan) -> Iterator[Comparison]:
    """The spline's length, and spline and quadratic with nothing to hold them off."""
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
    splines, quadratics = zip(*_as_printed(scene), strict=True)
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
        _entered(quadratics),
        "does not hold" if min(quadratics) < 0 else "holds",
    )


def of_quadratic(scene: Scene, made: Plan) -> Iterator[Comparison]:
    """The quadratic's length, and what the printed polynomials are like."""
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
        f"{arc_length(printed.QUADRATIC).length:.4f}",
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


def of_motion(made: Plan) -> Iterator[Comparison]:
    """Theorem 1."""
    assert made.quadratic_arc is not None
    profile = timing.three_phase(made.quadratic_arc.length, 4.0, 6.0, 3.0)
    yield Comparison(
        "Theorem 1",
        "t1 = t3·|a3 / a1|, for a1 = 6, a3 = 3",
        "proven",
        f"{profile.t1:.4f} s = {profile.t3 * abs(-3.0 / 6.0):.4f} s",
        "holds",
    )


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
        spline = clamped(made.path.points, scene.spline.degree)
        quadratic = least_squares(spline, arc_length(spline))
        obstacles = ObstacleSet(scene.obstacles)
        points = np.linspace(0, 1, 4001)
        yield (
            obstacles.polyline_clearance(spline(points)),
            obstacles.polyline_clearance(quadratic(points)),
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
    return ObstacleSet(cube).polyline_clearance(printed.QUADRATIC(np.linspace(0, 1, 4001)))

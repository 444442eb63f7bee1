"""The paper's statements on curves and motion, stages 4 and 5, beside our figures."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from abi.curves.bspline import clamped
from abi.curves.curve import arc_length
from abi.curves.quadratic import least_squares
from abi.curves.three_phase_profile import three_phase
from abi.explain.paper import printed
from abi.explain.paper.comparison import PaperComparison
from abi.length_text import format_lower_bound
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.plan import Plan
from abi.planner.planner import plan
from abi.scene.scene import Scene

_MESHES = 9


def of_splines(scene: Scene, result: Plan) -> Iterator[PaperComparison]:
    """Length of the spline, and spline and quadratic when nothing keeps them clear."""
    section = "stage 4, B-spline"
    assert result.path is not None
    assert result.bspline is not None
    assert result.bspline.holds
    assert result.bspline_arc is not None
    share = result.bspline_arc.length / result.path.length
    yield PaperComparison(
        section,
        "length of the B-spline, degree 4",
        f"{printed.BSPLINE_LENGTH:.2f}, {printed.BSPLINE_LENGTH / printed.LENGTHS['a_star']:.3f}"
        " of A*'s path",
        f"{result.bspline_arc.length:.2f}, {share:.3f} of A*'s path; proven clear by "
        f"{format_lower_bound(result.bspline.clearance.distance)}",
        "depends on the mesh",
    )
    splines, quadratics = zip(*_clearances_as_printed(scene), strict=True)
    yield PaperComparison(
        section,
        "B-spline on the path's vertices",
        "does not enter the obstacle",
        _entered(splines),
        "does not hold" if min(splines) < 0 else "holds",
    )
    yield PaperComparison(
        "stage 5, quadratic",
        "quadratic fitted by least squares",
        "bypasses the obstacle",
        _entered(quadratics),
        "does not hold" if min(quadratics) < 0 else "holds",
    )


def of_quadratic(scene: Scene, result: Plan) -> Iterator[PaperComparison]:
    """Length of the quadratic, and the printed polynomials' length, ends, clearance and speed."""
    section = "stage 5, quadratic"
    assert result.path is not None
    assert result.quadratic is not None
    assert result.quadratic_arc is not None
    length, path = result.quadratic_arc.length, result.path.length
    yield PaperComparison(
        section,
        "length of the quadratic",
        f"{printed.QUADRATIC_LENGTH:.3f}, "
        f"{printed.QUADRATIC_LENGTH / printed.LENGTHS['a_star']:.3f} of A*'s path",
        f"{length:.3f}, {length / path:.3f} of A*'s path",
        "depends on the mesh",
    )
    yield PaperComparison(
        section,
        "length of the printed polynomials",
        f"{printed.QUADRATIC_LENGTH:.3f}",
        f"{arc_length(printed.QUADRATIC).length:.4f}",
        "holds",
    )
    yield PaperComparison(
        section,
        "ends of the printed polynomials",
        "exact",
        " to ".join(str(tuple(printed.QUADRATIC(t).round(9).tolist())) for t in (0, 1)),
        "holds",
    )
    clearances = {side: _clearance_beside(scene, side) for side in (2.0, 2.5, 3.0)}
    yield PaperComparison(
        section,
        "the printed polynomials and the cube",
        "bypass it; its side is not printed",
        "clearance "
        + ", ".join(
            f"{clearance:+.3f} for side {side:g}" for side, clearance in clearances.items()
        ),
        "holds",
    )
    speeds = np.linalg.norm(printed.QUADRATIC([0.0, 0.5, 1.0], 1), axis=1)
    yield PaperComparison(
        section,
        "speed along the printed polynomials",
        "rises, stays, falls",
        " → ".join(f"{speed:.2f}" for speed in speeds) + " at t = 0, ½, 1",
        "does not hold",
    )


def of_motion(result: Plan) -> Iterator[PaperComparison]:
    """Theorem 1, on the times of speeding up and braking."""
    assert result.quadratic_arc is not None
    profile = three_phase(result.quadratic_arc.length, 4.0, 6.0, 3.0)
    yield PaperComparison(
        "Theorem 1",
        "t1 = t3·|a3 / a1|, for a1 = 6, a3 = 3",
        "proven",
        f"{profile.t1:.4f} s = {profile.t3 * abs(-3.0 / 6.0):.4f} s",
        "holds",
    )


def _clearances_as_printed(scene: Scene) -> Iterator[tuple[float, float]]:
    """Clearances of spline and quadratic, [unit], on irregular meshes, fitted as printed: without
    regard to the obstacle."""
    for seed in range(_MESHES):
        result = plan(
            scene.replace(
                mesh={"lattice": "delaunay", "pitch": 1.0, "seed": seed},
                spline={"clearance": 0.0},
            )
        )
        assert result.path is not None
        spline = clamped(result.path.points, scene.spline.degree)
        quadratic = least_squares(spline, arc_length(spline))
        obstacles = ObstacleSet(scene.obstacles)
        points = np.linspace(0, 1, 4001)
        yield (
            obstacles.polyline_clearance(spline(points)),
            obstacles.polyline_clearance(quadratic(points)),
        )


def _entered(clearances: tuple[float, ...]) -> str:
    inside = [clearance for clearance in clearances if clearance < 0]
    deepest = f", by up to {-min(inside):.2f}" if inside else ""
    return f"enters it in {len(inside)} of {len(clearances)} meshes{deepest}"


def _clearance_beside(scene: Scene, side: float) -> float:
    """Clearance of the printed quadratic from a cube of that side, [unit]."""
    cube = scene.replace(
        obstacles=[{"shape": "box", "size": 3 * [side], "position": [3, 3, 3]}]
    ).obstacles
    return ObstacleSet(cube).polyline_clearance(printed.QUADRATIC(np.linspace(0, 1, 4001)))

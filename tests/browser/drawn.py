"""Expected contents of the page for a plan, without the application's drawing code."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abi.curves.bspline import BSpline
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.planner.plan import Plan
from tests.browser.page import Page

Points = NDArray[np.float64]

SINGLE = 2e-5  # [unit]; points travel in single precision
TOOL = "/arm/links/turret/upper_arm/elbow/forearm/rod/gripper/tool"


def chain(lines: Points) -> Points:
    """Points of a polyline from its segments (n, 2, 3), which must hang together."""
    np.testing.assert_array_equal(lines[:-1, 1], lines[1:, 0])
    return np.concatenate((lines[:1, 0], lines[:, 1]))


def is_nothing(lines: Points) -> bool:
    """Check whether segments (n, 2, 3) have no length at all."""
    return bool((lines[:, 0] == lines[:, 1]).all())


def shows_curve(page: Page, name: str, fit: Fit[BSpline] | Fit[Quadratic] | None) -> bool:
    """Check whether the line ``/curve/<name>`` in the page runs along the fitted curve."""
    lines = page.points(f"/curve/{name}")
    if fit is None:
        return is_nothing(lines)
    points = chain(lines)
    expected = fit.curve(np.linspace(*fit.curve.interval, len(points)))
    return len(points) > 50 and bool(np.allclose(points, expected, rtol=0, atol=SINGLE))


def shows_path(page: Page, plan: Plan) -> bool:
    """Check whether A*'s line in the page is the plan's path, vertex by vertex."""
    lines = page.points("/path/a_star")
    if not plan.searches:
        return is_nothing(lines)
    path = next(result for result in plan.searches if result.algorithm == "a_star").points
    points = chain(lines)
    return len(points) == len(path) and bool(np.allclose(points, path, rtol=0, atol=SINGLE))


def shows(page: Page, plan: Plan | None) -> bool:
    """Check whether path and curves in the page are those of ``plan``; not before it has any."""
    assert plan is not None
    return (
        {"/path/a_star", "/curve/bspline", "/curve/quadratic"} <= page.names()
        and shows_path(page, plan)
        and shows_curve(page, "bspline", plan.bspline)
        and shows_curve(page, "quadratic", plan.quadratic)
    )


def same(a: Plan, b: Plan) -> bool:
    """Check whether two complete plans have the same path, curves and motion, number by number.

    But for rounding, in which kernels differ from what runs until they are compiled.
    """
    pairs = zip(_numbers(a), _numbers(b), strict=True)
    return all(x.shape == y.shape and np.allclose(x, y, rtol=0, atol=1e-9) for x, y in pairs)


def _numbers(plan: Plan) -> tuple[Points, ...]:
    assert plan.path is not None
    assert plan.bspline is not None
    assert plan.quadratic is not None
    assert plan.motion is not None
    return (
        plan.path.points,
        plan.bspline.curve(np.linspace(0, 1, 40)),
        plan.quadratic.curve(np.linspace(0, 1, 40)),
        plan.motion.tool,
        plan.motion.positions,
    )


def tool_at(plan: Plan, time: float) -> Points:
    """Place of the tool of ``plan`` at ``time`` [s], (3,) [unit]."""
    assert plan.motion is not None
    return np.array([np.interp(time, plan.motion.time, axis) for axis in plan.motion.tool.T])


def distance(points: Points, polyline: Points) -> Points:
    """Distance of each of ``points`` (n, 3) to ``polyline`` (k, 3)."""
    a, b = polyline[:-1], polyline[1:]
    along = np.einsum("nkj,kj->nk", points[:, None] - a, b - a) / ((b - a) ** 2).sum(axis=1)
    foot = a + np.clip(along, 0, 1)[..., None] * (b - a)
    nearest: Points = np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1)
    return nearest


def obstacles(page: Page) -> list[str]:
    """Names of the obstacles' gizmos, in the order in which they were added."""
    names = (n for n in page.names() if n.startswith("/obstacle_") and n.count("/") == 1)
    return sorted(names, key=lambda name: int(name.removeprefix("/obstacle_")))

"""Bending changes a B-spline near the points moved, and what it keeps is told of the bent one."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import abi
from abi.obstacles.obstacle_set import ObstacleSet
from abi.scene.scene import load_scene
from app.state.bent_curve import bend, changed_share, moved_points

_PLAN = abi.plan(load_scene("paper"))
_place = st.tuples(*[st.floats(0, 6).map(lambda number: round(number, 2))] * 3)


@given(st.dictionaries(st.integers(1, 7), _place, min_size=1, max_size=3))
def test_a_bent_curve_is_the_plans_but_near_the_points_moved(
    places: dict[int, tuple[float, float, float]],
) -> None:
    assert _PLAN.bspline is not None
    spline, bent = _PLAN.bspline.curve, bend(_PLAN, places)
    parameters = np.linspace(0, 1, 101)
    away = np.linalg.norm(bent.curve(parameters) - spline(parameters), axis=1)
    knots, degree = spline.knots, spline.degree
    near = [(parameters > knots[k]) & (parameters < knots[k + degree + 1]) for k in places]
    assert away[~np.any(near, axis=0)].max(initial=0.0) < 1e-12
    asked = {k: at for k, at in places.items() if at != tuple(spline.control_points[k])}
    assert np.flatnonzero(moved_points(_PLAN, bent.curve)).tolist() == sorted(asked)
    depends = np.any([near[list(places).index(k)] for k in asked], axis=0)
    assert abs(changed_share(_PLAN, bent.curve) - depends.mean()) < 0.03
    obstacles = ObstacleSet(_PLAN.scene.obstacles)
    sampled = obstacles.signed_distance(bent.curve(parameters)).min()
    assert bent.clearance.nearest <= sampled + 1e-6
    assert not (bent.holds and sampled < bent.required)

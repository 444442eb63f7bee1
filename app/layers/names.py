"""Names beside path and curves in the scene, and the distance to the nearest obstacle as a line."""

from __future__ import annotations

from typing import Literal

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import Vec3
from abi.planner.plan import Plan
from app.camera.framing import axes
from app.drawing.lines import add_line, parameters, points_at, segments
from app.shared.computed_once import once_a_plan
from app.state.frame import Draw, Frame
from app.ui import style
from app.ui.arm_size import oversize
from app.ui.layout import Layout
from app.ui.numbers import distance_to_show, format_lower_bound

_ANCHORS: dict[str, Literal["bottom-center", "top-center"]] = {
    "path": "bottom-center",
    "bspline": "bottom-center",
    "quadratic": "top-center",
    **dict.fromkeys(style.ALGORITHMS, "bottom-center"),
}
"""Of the path used, the curves, and the searches whose path is not used."""
_CURVES = frozenset({"bspline", "quadratic"})
"""Beside these, only the path used has a name: three more words would hide them."""
_PLACES = {
    "path": np.linspace(0.15, 0.35, 7),
    "bspline": np.linspace(0.62, 0.85, 7),
    "quadratic": np.linspace(0.3, 0.7, 13),
    **dict.fromkeys(style.ALGORITHMS, np.linspace(0.3, 0.85, 12)),
}
"""Parts of a line's length at which its name may stand."""


_NARROW = 480
"""Width of a picture, [px], in which the names of more than one curve would lie on the curves."""
_WIDE = 3.0
"""Width of a label over its height."""
_UPRIGHT = 1e-3
"""Slope below which a camera that looks down is taken for one that leans a little."""

_View = tuple[Vec3, Vec3]
"""Position and target of a camera, [unit], world."""


def names_layer(layout: Layout) -> Draw:
    """A label on each line, away from the other labels, and a dimension line.

    Names move along their lines only while the input rests.
    """
    scene, camera = layout.client.scene, layout.client.camera
    # one below its line, the others above
    labels = {
        name: scene.add_label(f"/name/{name}", "", anchor=anchor, visible=False)
        for name, anchor in _ANCHORS.items()
    }
    distance = scene.add_label("/name/distance", "", anchor="bottom-center", visible=False)
    line = add_line(scene, "/name/line", style.POINT, 2.0)
    drawn: tuple[object, ...] = ()
    places: dict[str, float] = {}

    def draw(frame: Frame) -> None:
        nonlocal drawn, places
        plan = frame.plan
        eye, target = _rounded(camera.position), _rounded(camera.look_at)
        state = (plan, True) if frame.interactive else (plan, False, eye, target)
        if state != drawn:
            drawn = state
            _draw_distance(distance, line, plan)
            lines = _lines(plan)
            if not frame.interactive or set(lines) != set(places):
                places = _apart(plan, (eye, target))
            for name, points in lines.items():
                labels[name].text = _title(plan, name)
                labels[name].position = points_at(points, np.array([places[name]]))[0]
        narrow = 0 < camera.image_width < _NARROW
        named = _named(frame, narrow) & places.keys()
        for name, label in labels.items():
            label.font_screen_scale = frame.label_scale
            label.visible = name in named and _switch(plan, name) in frame.shown
        distance.font_screen_scale = frame.label_scale
        line.visible = distance.visible = _tells_distance(frame)

    return draw


def _draw_distance(label: viser.LabelHandle, line: viser.LineSegmentsHandle, plan: Plan) -> None:
    nearest = _nearest(plan)
    if nearest is None:
        return
    assert plan.followed_curve is not None
    line.points = segments(nearest)
    distance = format_lower_bound(distance_to_show(plan.followed_curve.clearance))
    label.text = f"{distance} {plan.scene.unit}"
    label.position = nearest.mean(axis=0)


def _named(frame: Frame, narrow: bool) -> set[str]:
    """Lines that have a name in a frame while they are shown; fewer in a narrow picture."""
    plan, search = frame.plan, frame.plan.joint_search
    if "names" not in frame.shown:
        return set()
    if narrow and plan.followed in frame.shown:
        return {plan.followed}
    if oversize(plan.scene):
        return set()  # beside such an arm all of the scene is as small as one name
    named = {"path", *_CURVES} if _CURVES & frame.shown else set(_ANCHORS)
    if search is not None and search.path is not None:
        named &= {"path", *style.ALGORITHMS}  # the joints follow none of the curves
    return named


def _tells_distance(frame: Frame) -> bool:
    """Whether to show the curve's distance to the obstacles; not where it would be the answer."""
    shown = "names" in frame.shown and frame.plan.followed in frame.shown and not frame.asks
    return shown and not oversize(frame.plan.scene) and _nearest(frame.plan) is not None


def _switch(plan: Plan, name: str) -> str:
    """Switch of the line that a name stands on."""
    return plan.path.algorithm if name == "path" and plan.path is not None else name


@once_a_plan
def _lines(plan: Plan) -> dict[str, FloatArray]:
    """Points (n, 3) of the lines to name, [unit], world."""
    lines: dict[str, FloatArray] = {}
    if plan.path is not None:
        lines["path"] = plan.path.points
    for name, fit in plan.curves.items():
        if fit is not None:
            lines[name] = fit.curve(parameters(fit.curve.interval, 60))
    for result in plan.searches:
        if plan.path is not None and result.algorithm != plan.path.algorithm:
            lines[result.algorithm] = result.points
    return {name: points for name, points in lines.items() if len(points) > 1}


def _title(plan: Plan, name: str) -> str:
    if name == "path":
        assert plan.path is not None
        return style.ALGORITHMS[plan.path.algorithm][0]
    if name in style.ALGORITHMS:
        return style.ALGORITHMS[name][0]
    return style.CURVES[name][0] + (" ▸" if name == plan.followed else "")


@once_a_plan
def _nearest(plan: Plan) -> FloatArray | None:
    """Nearest point of the followed curve and of the obstacle to each other, (2, 3); or None."""
    fit = plan.followed_curve
    if fit is None or fit.clearance.obstacle < 0 or fit.clearance.nearest <= 0:
        return None
    here = fit.curve(np.array([fit.clearance.at]))
    obstacle = ObstacleSet((plan.scene.obstacles[fit.clearance.obstacle],))
    distance, gradient = obstacle.signed_distance_gradient(here)
    return np.concatenate([here, here - distance[:, None] * gradient])


@once_a_plan
def _apart(plan: Plan, view: _View) -> dict[str, float]:
    """Part of each line's length at which its name is farthest from the other labels, as seen."""
    nearest = _nearest(plan)
    others = [np.array(plan.scene.start), np.array(plan.scene.goal)]
    others += [] if nearest is None else list(nearest)
    places = {}
    for name, points in _lines(plan).items():
        candidates = points_at(points, _PLACES[name])
        away = pictured(candidates, *view)[:, None] - pictured(np.array(others), *view)
        room = np.linalg.norm(away, axis=2).min(axis=1)
        best = int(np.argmax(room))
        places[name] = float(_PLACES[name][best])
        others.append(candidates[best])
    return places


def pictured(points: FloatArray, eye: Vec3, target: Vec3) -> FloatArray:
    """Places (n, 2) of points as seen, with what is above each other farther apart, as words are.

    Args:
        points: (n, 3), [unit], world.
        eye, target: of the camera, [unit], world.
    """
    away = np.subtract(eye, target)
    if not np.hypot(away[0], away[1]) > _UPRIGHT * abs(away[2]):
        away[1] -= max(_UPRIGHT * abs(away[2]), _UPRIGHT)
    right, up, forward = axes(away)
    seen = points - np.array(eye)
    depth = np.maximum(seen @ forward, _UPRIGHT)
    picture: FloatArray = np.stack([seen @ right, _WIDE * (seen @ up)], axis=1) / depth[:, None]
    return picture


def _rounded(place: FloatArray) -> Vec3:
    x, y, z = np.round(place, 3).tolist()
    return x, y, z

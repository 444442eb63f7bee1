"""Control points of the B-spline as balls to drag, and the curve that follows them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.curves.bspline import BSpline
from abi.curves.fit import Fit
from abi.obstacles.pose import Vec3
from abi.planner.plan import Plan
from app.drawing.lines import NO_SEGMENTS, add_line, dashes, parameters, segments
from app.panels.widgets import Wake
from app.state.bent_curve import bend
from app.state.frame import Frame
from app.ui import style
from app.ui.numbers import distance_to_show, format_length, format_lower_bound, format_setting

_RADIUS = 0.02
"""Of a ball, as a part of the workspace's size."""
_DASH = 0.035
"""Length of a dash of the bent curve, likewise."""
_MOST = 150
"""Control points that are given balls; where there are more, a hand could not tell them apart."""
_SAMPLES = 160


class ControlHandles:
    """Balls on the inner control points; what they are moved to is the tab's alone.

    The plan and its proofs stay as they are: the bent curve is drawn beside the plan's, and says
    what it keeps itself. It lasts until there is another B-spline, or its switch is turned off.
    """

    def __init__(self, client: viser.ClientHandle, wake: Wake) -> None:
        self._scene, self._wake = client.scene, wake
        self._root = self._scene.add_frame("/bend", show_axes=False, visible=False)
        self._line = add_line(self._scene, "/bend/curve", style.BSPLINE, 5.0)
        self._polygon = add_line(self._scene, "/bend/polygon", style.BSPLINE, 1.0)
        self._label = self._scene.add_label(
            "/bend/label", "", anchor="bottom-center", visible=False
        )
        self._balls: dict[int, viser.IcosphereHandle] = {}
        self._curve: BSpline | None = None
        self._places: dict[int, Vec3] = {}
        self._grips: dict[int, FloatArray] = {}
        self._bounds = np.zeros(3), np.zeros(3)
        self._bent: Fit[BSpline] | None = None
        self._bent_places: dict[int, Vec3] = {}
        self._drawn: Fit[BSpline] | None = None

    def bent(self, frame: Frame) -> Fit[BSpline] | None:
        """The curve as it is bent now; None while no point of the frame's is moved."""
        fit = frame.plan.bspline
        curve = None if fit is None else fit.curve
        if curve is not self._curve or "bent" not in frame.shown:
            self._curve, self._places = curve, {}
        places = dict(self._places)
        if places != self._bent_places:
            self._bent_places = places
            self._bent = bend(frame.plan, places) if places else None
        return self._bent

    def move(self, displacements: Mapping[int, Vec3]) -> None:
        """Move control points of the curve that is shown by (3,), [unit], as a hand would."""
        points = np.zeros((0, 3)) if self._curve is None else self._curve.control_points
        for number, displacement in displacements.items():
            if 0 < number < len(points) - 1:
                self._places[number] = _vector(points[number] + displacement)

    def draw(self, frame: Frame) -> None:
        """Draw balls and bent curve, while they are switched on."""
        on = "bent" in frame.shown and self._curve is not None
        self._root.visible = on
        if not on:
            return
        self._place_balls(frame)
        self._label.font_screen_scale = frame.label_scale
        if frame.bent is not self._drawn:
            self._drawn = frame.bent
            self._draw_bent(frame.plan, frame.bent)

    def _place_balls(self, frame: Frame) -> None:
        """Have a ball on each inner control point."""
        assert self._curve is not None
        points, workspace = self._curve.control_points, frame.plan.scene.workspace
        self._bounds = np.array(workspace.min), np.array(workspace.max)
        count = len(points) if len(points) <= _MOST else 0
        for number in [number for number in self._balls if number >= count - 1]:
            self._balls.pop(number).remove()
        for number in range(1, count - 1):
            place = np.array(self._places.get(number, points[number]))
            if number not in self._balls:
                self._balls[number] = self._new_ball(number)
            if not np.array_equal(self._balls[number].position, place):
                self._balls[number].position = place
            self._balls[number].radius = _RADIUS * max(workspace.size)

    def _new_ball(self, number: int) -> viser.IcosphereHandle:
        ball = self._scene.add_icosphere(f"/bend/{number}", radius=1.0, color=style.BSPLINE)
        ball.on_drag(partial(self._drag, number))
        return ball

    def _drag(self, number: int, event: viser.SceneNodeDragEvent[Any]) -> None:
        """Move a point with the hand, in the plane that faces the camera, within the workspace."""
        ball = self._balls.get(number)
        if ball is None:
            return
        grip = self._grips.setdefault(number, np.subtract(ball.position, event.start_position))
        place = np.add(event.end_position, grip)
        if np.isfinite(place).all():
            self._places[number] = _vector(np.clip(place, *self._bounds))
        if event.phase == "end":
            self._grips.pop(number, None)
        self._wake(event)

    def _draw_bent(self, plan: Plan, bent: Fit[BSpline] | None) -> None:
        self._label.visible = bent is not None
        if bent is None:
            self._line.points = self._polygon.points = NO_SEGMENTS
            return
        curve, size = bent.curve, max(plan.scene.workspace.size)
        line = curve(parameters(curve.interval, _SAMPLES))
        self._line.points = dashes(line, _DASH * size)
        colour = style.BSPLINE if bent.holds else style.VIOLATION
        self._line.colors = np.array(colour, np.uint8)
        self._polygon.points = segments(curve.control_points)
        last = next(reversed(self._places))
        self._label.position = curve.control_points[last] + (0.0, 0.0, 0.04 * size)
        self._label.text = _told(plan, bent)


def _vector(place: FloatArray) -> Vec3:
    x, y, z = place.tolist()
    return x, y, z


def _told(plan: Plan, bent: Fit[BSpline]) -> str:
    """Length of a bent curve and what it keeps, in a few words."""
    unit = plan.scene.unit
    length = f"bent: {format_length(bent.arc.length)} {unit}"
    if math.isinf(bent.clearance.distance):
        return length
    distance = format_lower_bound(distance_to_show(bent.clearance))
    if bent.holds:
        return f"{length}, keeps {distance} {unit} ✓"
    if bent.clearance.nearest > 0:
        return f"{length}, too close: {distance}, wanted {format_setting(bent.required)} {unit} ✗"
    number = bent.clearance.obstacle + 1
    return f"{length}, cuts {distance.removeprefix('−')} {unit} into obstacle {number} ✗"

"""Camera that shows workspace and arm as large as possible, until the user moves it."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np
import viser
from viser.transforms import SO3

from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.camera.extent import extent
from app.camera.framing import Window, holds, lift, stand, widest
from app.camera.prospect import USUAL, best_direction
from app.camera.view import View
from app.drawing.box import box_corners
from app.ui.arm_size import oversize
from app.ui.page_area import PageArea

_ASPECT = 0.8
"""Aspect ratio of the picture below which the camera steps back."""
_MAX_DISTANCE_FACTOR = 2.5
_MOST_COVERED = 0.4
"""Largest part of the picture's height that text at one edge is taken to cover."""
_SAME_SHAPE = 0.1
"""Relative difference of aspect ratios that counts as none, as both are rounded."""
_HEADLINE = 0.11
"""Least part of the picture's height that the headline covers."""
_ARROWS = 0.36
"""Reach of the axes' arrows and letters beyond the workspace, as a part of its longest side."""
_FOOT = 0.07
"""Radius of the arm's foot, as a part of the scene's size."""
_TOLERANCE = 1e-3
"""Difference between the page's camera and ours, over the scene's size, that counts as unmoved."""
_REMEMBERED = 8
"""Number of our latest cameras that the page may still report."""


class Viewpoint:
    """Camera that follows the scene and the picture's size until the user moves it."""

    def __init__(self, camera: viser.CameraHandle, scene: Scene) -> None:
        self._camera = camera
        self._distance_factor = 1.0
        self._direction: FloatArray = USUAL
        self._points: FloatArray | None = None
        self._wide = False
        self._extent: FloatArray | None = None
        self._headline = _HEADLINE
        self._told: float | None = None  # shape of the picture in which the text above has counted
        self._window = Window(camera.fov, _ASPECT)
        self._places: deque[FloatArray] = deque(maxlen=_REMEMBERED)
        # where the page opened, of which it may tell again before it hears of another place
        self._opened: list[FloatArray] = [np.array(camera.position)]
        self._fitted: tuple[object, ...] = ()  # what the camera was put in its place for
        self._shown = False
        self.show(scene)

    def show(self, scene: Scene) -> None:
        """Put the camera in front of ``scene``."""
        self._scene, self._direction, self._shown = scene, USUAL, True
        self._extent, self._headline = None, _HEADLINE
        self._place()

    def take(self, view: View) -> None:
        """Look from a given place, as if the user had moved the camera there.

        What the page tells of our places before may come later, and moves it no more.
        """
        if self._away(list(self._places), np.array(view.position)):
            self._places.clear()
            self._opened.clear()
        view.show(self._camera)

    def face(self, plan: Plan) -> None:
        """Turn around the scene to the side that shows most of a plan with a B-spline.

        It steps back where the arm would be cut off in its motion, or be behind the headline. Not
        where the user has moved the camera.
        """
        if self._is_moved():
            return
        _, target, size = _view(self._scene, self._distance_factor, self._direction)
        x, y, z = target.tolist()
        self._direction = best_direction(plan, (x, y, z), self._distance_factor * size)
        self._extent = np.vstack([extent(plan), _axes_tips(plan.scene)])
        self._place()

    def surround(self, points: FloatArray | None, wide: bool = False) -> None:
        """Keep all points (n, 3), [unit], in the uncovered part of the picture; None ends that.

        The camera moves at the begin, at the end, and with a new scene, unless the user moved it:
        what a hand drags is not to move under it. :meth:`follow` is for when the hand has let go.

        Args:
            points: to keep in the picture.
            wide: whether to look at them from where they look wide.
        """
        if points is None and self._points is None:
            self._shown = False
            return
        begins = (points is None) != (self._points is None) or wide != self._wide
        moved = self._is_moved()
        self._points, self._wide = points, wide
        if points is None:
            self._window = replace(self._window, above=0.0, below=0.0)
        if not moved and (begins or (self._shown and points is not None)):
            self._place()
        self._shown = False

    def follow(self) -> None:
        """Step back until all points are in view again, unless the user moved the camera."""
        if self._points is None or self._is_moved():
            return
        camera = self._camera
        if not holds(self._points, camera.position, camera.look_at, self._window):
            self._place()

    def look_from(self, direction: tuple[float, float, float]) -> None:
        """Look at the whole scene from a direction, which need not be of length 1."""
        length = np.linalg.norm(USUAL) / np.linalg.norm(direction)
        self._direction = length * np.array(direction)
        self._camera.up_direction = np.array([0.0, 0.0, 1.0])
        self._place()

    def mirror(self, scene: Scene, view: View | None) -> None:
        """Show another tab's ``scene`` from that tab's camera; one already there is left alone."""
        shown = self._scene.workspace, self._scene.arm.base
        if shown != (scene.workspace, scene.arm.base):
            self.show(scene)
        self._scene = scene
        if view is not None and view != View.of_camera(self._camera):
            self.take(view)

    def fit(self, area: PageArea | None, arrives: bool = False) -> None:
        """Adapt to the picture's shape and to what covers it, unless the user moved the camera.

        In a picture of another shape, for which the camera moves anyway, the text above counts. A
        camera that the page tells to be in an earlier place of ours is sent to the last one again.

        Args:
            area: of the page; None while that is not known.
            arrives: whether the scene has just come, so that the text about it counts, too.
        """
        if not self._camera.image_height * self._camera.image_width:
            return  # wholly covered for the moment, as by a phone's sheet
        factor = min(max(_ASPECT / aspect(self._camera), 1.0), _MAX_DISTANCE_FACTOR)
        window, headline = self._free(area), self._headline
        reshaped = self._told is not None and not _same(self._told, window.aspect)
        if self._told is None:
            self._told = window.aspect
        if area is not None and (arrives or (reshaped and _same(area.aspect, window.aspect))):
            least = _HEADLINE if reshaped else headline
            headline, self._told = max(least, min(area.above, _MOST_COVERED)), window.aspect
        self._distance_factor, self._window, self._headline = factor, window, headline
        position = self._camera.position
        due = self._fitted != self._fit_for() or self._away(list(self._places)[-1:], position)
        if due and not self._is_moved():
            self._place()

    def _fit_for(self) -> tuple[object, ...]:
        """What decides the camera's place, beside scene and direction."""
        return self._distance_factor, self._window, self._headline

    def _free(self, area: PageArea | None) -> Window:
        """Uncovered part of the picture; while its shape stays, temporary text counts as covering.

        The text above counts only where all points are to be surrounded: it changes with each plan,
        at which the scene is not to move.
        """
        now = Window(self._camera.fov, aspect(self._camera))
        # of another shape it is of before the picture took this one, as with its panels still open
        if area is not None and _same(area.aspect, now.aspect):
            above, below = min(area.above, _MOST_COVERED), min(area.below, _MOST_COVERED)
            if self._points is None:
                above = 0.0
            if now.aspect == self._window.aspect:
                above, below = max(above, self._window.above), max(below, self._window.below)
            now = replace(now, above=above, below=below)
        return now

    def _place(self) -> None:
        """Move the camera to its place, unless the user moved it."""
        if self._points is None:
            position, target, size = _view(self._scene, self._distance_factor, self._direction)
            self._camera.near, self._camera.far = _depths(size)
            position, target = lift(_outline(self._scene), position, target, self._window)
            window = replace(self._window, above=max(self._window.above, self._headline))
            if self._extent is not None and not holds(self._extent, position, target, window):
                position, target = stand(self._extent, self._direction, window)
        else:
            direction = self._direction
            if self._wide:
                direction = widest(self._points, direction, self._window)
            position, target = stand(self._points, direction, self._window)
        # at once: a place on the way there, told by the page, would be none of ours
        self._camera.position, self._camera.look_at = position, target
        # not what the camera says now, which may be the page's word from before
        self._places.append(position)
        self._fitted = self._fit_for()

    def _is_moved(self) -> bool:
        """Check whether the user has moved the camera.

        What the page tells may be older than our last word: a place before that is ours as well.
        """
        return self._away([*self._opened, *self._places], self._camera.position)

    def _away(self, places: list[FloatArray], position: FloatArray) -> bool:
        """Check whether a camera's position (3,), [unit], world, is none of these places."""
        if not places:
            return True
        size = _view(self._scene, self._distance_factor)[2]
        away = np.linalg.norm(position - np.array(places), axis=1)
        return bool(away.min() >= _TOLERANCE * size)


def _same(one: float, other: float) -> bool:
    """Check whether two aspect ratios are those of one shape."""
    return abs(one / other - 1) < _SAME_SHAPE


def aspect(camera: viser.CameraHandle) -> float:
    """Aspect ratio of a page's picture, between 0.1 and 10, also for a page without area."""
    return min(max(camera.image_width / max(camera.image_height, 1), 0.1), 10.0)


def look_at(
    camera: viser.CameraHandle | viser.InitialCameraConfig,
    scene: Scene,
    distance_factor: float = 1.0,
    direction: FloatArray = USUAL,
) -> None:
    """Turn ``camera`` to workspace and arm, ``distance_factor`` times as far away as just fits."""
    camera.position, camera.look_at, size = _view(scene, distance_factor, direction)
    camera.near, camera.far = _depths(size)


def _depths(size: float) -> tuple[float, float]:
    """Distances, [unit], between which a scene of such a size, [unit], is drawn."""
    return size / 500, size * 50


def _outline(scene: Scene) -> FloatArray:
    """Corners of the workspace and points around the arm's foot (n, 3), [unit], world."""
    corners = box_corners(scene.workspace.min, scene.workspace.max)
    radius = _FOOT * _view(scene, 1.0)[2]
    rim = radius * np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)])
    return np.vstack([corners, np.array(scene.arm.base) + rim])


def _axes_tips(scene: Scene) -> FloatArray:
    """Tips (n, 3), [unit], world, of the axes' arrows beside the workspace's corner."""
    workspace = scene.workspace
    corner = np.array([workspace.max[0], workspace.min[1], workspace.min[2]])
    size = max(workspace.size)
    return np.asarray(corner + size * np.array([(_ARROWS, 0, 0), (0, -_ARROWS, 0)]))


def _around_oversize(scene: Scene) -> FloatArray:
    """Corners (n, 3), [unit], world, around an arm that is far too large; otherwise none."""
    length = oversize(scene)
    if not length:
        return np.zeros((0, 3))
    corners = length * np.array([(-0.3, -0.3, 0.0), (0.3, 0.3, 0.6)])
    turned = SO3(np.array(scene.arm.base_wxyz)).apply(corners)
    return np.asarray(scene.arm.base + turned, dtype=np.float64)


def _view(
    scene: Scene, distance_factor: float, direction: FloatArray = USUAL
) -> tuple[FloatArray, FloatArray, float]:
    """Camera position (3,) and target (3,), [unit], world, and the scene's size, [unit]."""
    low, high = np.array(scene.workspace.min), np.array(scene.workspace.max)
    corners = np.vstack([low, high, scene.arm.base, _around_oversize(scene)])
    low, high = corners.min(axis=0), corners.max(axis=0)
    centre = (low + high) / 2
    size = float(np.linalg.norm(high - low))
    return centre + distance_factor * size * direction, centre, size

"""Camera position until the user moves it: workspace and arm fill the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.scene.scene import Scene

_ASPECT = 0.8
"""Width over height of the picture; from a narrower one the camera steps back."""
_MAX_DISTANCE_FACTOR = 2.5
_TOLERANCE = 1e-3
"""Part of the scene's size by which the page's camera, unmoved, may differ from ours."""


@dataclass(frozen=True)
class View:
    """Camera of a tab, rounded: position and target, [unit], and the upward direction, world."""

    position: tuple[float, ...]
    target: tuple[float, ...]
    up: tuple[float, ...]

    @classmethod
    def of(cls, numbers: object) -> View | None:
        """The view of nine finite numbers; None for anything else."""
        try:
            position, target, up = np.asarray(numbers, dtype=float).reshape(3, 3)
        except (ValueError, TypeError):
            return None
        if not np.isfinite([position, target, up]).all():
            return None
        if not (position - target).any() or not up.any():
            return None
        return cls(_rounded(position), _rounded(target), _rounded(up))

    def to_list(self) -> list[float]:
        """The nine numbers."""
        return [*self.position, *self.target, *self.up]


class Viewpoint:
    """Camera position that follows scene and picture as long as the user leaves it alone."""

    def __init__(self, camera: viser.CameraHandle, scene: Scene) -> None:
        self._camera = camera
        self._distance_factor = 1.0
        self.show(scene)

    def show(self, scene: Scene) -> None:
        """Put the camera in front of ``scene``."""
        self._scene = scene
        look_at(self._camera, scene, self._distance_factor)

    def now(self) -> View | None:
        """The page's camera; None where it reports none."""
        camera = self._camera
        return View.of([camera.position, camera.look_at, camera.up_direction])

    def restore(self, view: View) -> None:
        """Put the camera where it was."""
        self._camera.up_direction = np.array(view.up)
        self._camera.position = np.array(view.position)
        self._camera.look_at = np.array(view.target)

    def fit(self) -> None:
        """Step back, or nearer, with the picture's aspect, unless the user moved the camera."""
        factor = min(max(_ASPECT / self._camera.aspect, 1.0), _MAX_DISTANCE_FACTOR)
        if factor == self._distance_factor:
            return
        position, _, size = _view(self._scene, self._distance_factor)
        self._distance_factor = factor
        if np.linalg.norm(self._camera.position - position) < _TOLERANCE * size:
            look_at(self._camera, self._scene, factor)


def look_at(
    camera: viser.CameraHandle | viser.InitialCameraConfig,
    scene: Scene,
    distance_factor: float = 1.0,
) -> None:
    """Turn ``camera`` to workspace and arm, ``distance_factor`` times as far as fills a picture."""
    camera.position, camera.look_at, size = _view(scene, distance_factor)
    camera.near, camera.far = size / 500, size * 50


def _rounded(vector: FloatArray) -> tuple[float, ...]:
    return tuple(float(f"{number:.6g}") for number in vector)


def _view(scene: Scene, distance_factor: float) -> tuple[FloatArray, FloatArray, float]:
    """Camera position (3,) and target (3,), [unit], world, and the scene's size, [unit]."""
    low, high = np.array(scene.workspace.min), np.array(scene.workspace.max)
    corners = np.array([low, high, scene.arm.base])
    low, high = corners.min(axis=0), corners.max(axis=0)
    centre = (low + high) / 2
    size = float(np.linalg.norm(high - low))
    return centre + distance_factor * size * np.array([0.82, -0.42, 0.38]), centre, size

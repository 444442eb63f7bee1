"""Where the camera stands until the hand moves it: workspace and arm in the picture."""

from __future__ import annotations

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.scene.scene import Scene

_ASPECT = 0.8
"""Of the picture between the panels: what is narrower is seen from farther away."""
_FARTHEST = 2.5
_STILL = 1e-3  # part of what is seen: how far the page's numbers may be from ours


class Viewpoint:
    """Holds how far away the camera was put, to know whether it still stands there."""

    def __init__(self, camera: viser.CameraHandle, scene: Scene) -> None:
        self._camera = camera
        self._away = 1.0
        self.show(scene)

    def show(self, scene: Scene) -> None:
        """Put the camera in front of ``scene``."""
        self._scene = scene
        look_at(self._camera, scene, self._away)

    def fit(self) -> None:
        """Step back, or nearer, when the picture's shape has changed, if the hand has not."""
        away = min(max(_ASPECT / self._camera.aspect, 1.0), _FARTHEST)
        if away == self._away:
            return
        position, _, size = _view(self._scene, self._away)
        self._away = away
        if np.linalg.norm(self._camera.position - position) < _STILL * size:
            look_at(self._camera, self._scene, away)


def look_at(
    camera: viser.CameraHandle | viser.InitialCameraConfig, scene: Scene, away: float = 1.0
) -> None:
    """Place ``camera`` so that workspace and arm are in the picture, ``away`` times as far."""
    camera.position, camera.look_at, size = _view(scene, away)
    camera.near, camera.far = size / 500, size * 50


def _view(scene: Scene, away: float) -> tuple[FloatArray, FloatArray, float]:
    """Where to stand (3,) and to look (3,), [unit], world, and how large the scene is, [unit]."""
    low, high = np.array(scene.workspace.min), np.array(scene.workspace.max)
    corners = np.array([low, high, scene.arm.base])
    low, high = corners.min(axis=0), corners.max(axis=0)
    centre = (low + high) / 2
    size = float(np.linalg.norm(high - low))
    return centre + away * size * np.array([0.82, -0.42, 0.38]), centre, size

"""Demonstration in a new tab: the first obstacle moves by itself until the user does something."""

from __future__ import annotations

import math
import time

import numpy as np

from abi.arrays import FloatArray
from abi.scene.scene import Scene
from app.panels.obstacles.obstacle_gizmos import ObstacleGizmos

FRAME = 0.07
"""Seconds between two positions."""
_PERIOD = 6.0
_DURATION = 2 * _PERIOD
_REACH = (0.0, 0.16, 0.1)
"""Amplitude along x, y and z, over the workspace's size."""


class Demo:
    """Movement of the first obstacle.

    Attributes:
        wanted: whether it is still to come.
        running: whether it is under way.
        interrupted: whether the last input found it under way: the scene is where it was left.
    """

    def __init__(self, obstacles: ObstacleGizmos) -> None:
        self._obstacles = obstacles
        self.wanted = self.running = self.interrupted = False
        self._origin: FloatArray = np.zeros(3)
        self._size: FloatArray = np.zeros(3)
        self._begun = 0.0

    def begin(self, scene: Scene) -> None:
        """Begin, if the scene has an obstacle that the user has not moved."""
        self.wanted = False
        if not self._obstacles.shown or self._obstacles.dragged:
            return
        self.running = True
        self._begun = time.monotonic()
        self._size = np.array(scene.workspace.size)
        self._origin = np.array(self._obstacles.shown[0].gizmo.position)

    def step(self) -> None:
        """Move the obstacle to its present position; back to its original one at the end."""
        elapsed = time.monotonic() - self._begun
        if elapsed >= _DURATION:
            self.end()
            return
        # slowly into it, and out of it
        weight = min(1.0, elapsed, _DURATION - elapsed)
        phase = 2 * math.pi * elapsed / _PERIOD
        shift = np.array(_REACH) * (0.0, math.sin(phase), math.sin(2 * phase))
        self._obstacles.place(0, self._origin + weight * shift * self._size)

    def interrupt(self) -> None:
        """End it, as the user has done something."""
        self.interrupted = self.running
        self.end()

    def end(self) -> None:
        """Put the obstacle back unless the user holds it, or cancel what has not begun."""
        self.wanted = False
        if not self.running:
            return
        self.running = False
        if self._obstacles.shown:
            self._obstacles.place(0, self._origin)

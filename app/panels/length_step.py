"""Step of the number boxes for lengths: what one press of their arrows adds."""

from __future__ import annotations

import math

from abi.scene.scene import Scene

_PARTS = 60
"""Presses for the workspace's longest side, at least."""
_FINE = 2 * _PARTS
_ROUND = (5.0, 2.0, 1.0)


def length_step(scene: Scene) -> float:
    """Step for sizes, places and speeds, [unit] or [unit/s]: a power of 10, or 2 or 5 times one."""
    return _round_part(scene, _PARTS)


def fine_step(scene: Scene) -> float:
    """Step for distances to be kept, [unit]."""
    return _round_part(scene, _FINE)


def _round_part(scene: Scene, parts: int) -> float:
    """The largest round number of which so many, at least, make the longest side."""
    most = max(scene.workspace.size) / parts
    power = math.floor(math.log10(most) + 1e-9)
    digit = next(digit for digit in _ROUND if digit * 10.0**power <= most * (1 + 1e-9))
    return float(f"{digit:.0f}e{power}")

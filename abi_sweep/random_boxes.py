"""Random scenes of boxes, each the same for the same seed."""

from __future__ import annotations

from typing import Any

import numpy as np

from abi.scene.scene import Scene

CLEARANCE = 0.2
"""Clearance of the scenes, [cm]."""
_ROOM, _MARGIN = 6.0, 0.35


def random_boxes(seed: int, count: int = 8) -> Scene:
    """Boxes at random in a workspace of 6 × 6 × 6 cm, start and goal in opposite corners.

    Boxes may overlap, but keep clear of start and goal.
    """
    random = np.random.default_rng(seed)
    boxes: list[dict[str, Any]] = []
    while len(boxes) < count:
        size = random.uniform(0.9, 2.2, 3)
        low = random.uniform(_MARGIN, _ROOM - _MARGIN - size)
        beside_start = (low >= 0.1 + CLEARANCE).all()
        if beside_start and (low + size <= _ROOM - 0.1 - CLEARANCE).all():
            position = (low + size / 2).tolist()
            boxes.append({"shape": "box", "size": size.tolist(), "position": position})
    return Scene.from_dict(
        {"version": 1, "obstacles": boxes, "spline": {"clearance": CLEARANCE}},
    )

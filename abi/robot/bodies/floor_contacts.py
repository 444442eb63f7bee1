"""Links that may touch the floor: those that stand on it, or that no motion brings nearer to it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.chain_kernels import POSE

_UPRIGHT = 1e-6
"""Tilt of an axis that counts as none, [rad]: of a link of 20 m a fiftieth of a millimetre."""
_POSES = 64


class FloorPiece(NamedTuple):
    """A piece of a link: all points within ``rounding`` of the hull of ``points``.

    Attributes:
        link: name of the link.
        frame: number of the joint that moves it, -1 where it stands still.
        points: in that frame, shape (k, 3), [m].
        rounding: [m].
    """

    link: str
    frame: int
    points: FloatArray
    rounding: float


def on_floor(chain: Chain, pieces: Iterable[FloorPiece], floor: float) -> tuple[str, ...]:
    """Names of the links that may touch the floor.

    Those that stand still may, and those that the first joint moves where it turns about an upright
    axis, or slides level, which changes no height. Where it does, those may that touch the floor
    wherever it takes them, as at the foot of an arm that stands beside a wall.

    Args:
        chain: the chain.
        pieces: of its links.
        floor: height of the floor, [m].
    """
    still: dict[str, None] = {}
    first: dict[str, list[FloorPiece]] = {}
    for piece in pieces:
        if piece.frame < 0:
            still[piece.link] = None
        elif piece.frame == 0:
            first.setdefault(piece.link, []).append(piece)
    if not first or _keeps_heights(chain):
        return (*still, *first)
    coordinate = int(chain.table.source[0])
    low, high = chain.usual_range().T
    positions = np.tile(np.clip(0.0, low, high), (_POSES, 1))
    positions[:, coordinate] = np.linspace(low[coordinate], high[coordinate], _POSES)
    up = chain.poses(positions)[:, 0, 2]
    found = []
    for link, of_link in first.items():
        lowest = [(up[:, :3] @ one.points.T).min(axis=1) - one.rounding for one in of_link]
        if (np.min(lowest, axis=0) + up[:, 3] <= floor).all():
            found.append(link)
    return (*still, *found)


def _keeps_heights(chain: Chain) -> bool:
    """Check whether the first joint changes the height of no point."""
    turn = chain.table.origins[: POSE - 3].reshape(3, 3)
    x, y, z = (turn @ chain.joints[0].axis).tolist()
    return bool(abs(z) <= _UPRIGHT if chain.table.slides[0] else np.hypot(x, y) <= _UPRIGHT)

"""Convex part of a link, in the frame of the joint that moves it."""

from __future__ import annotations

from typing import NamedTuple

from abi.arrays import FloatArray


class ConvexBody(NamedTuple):
    """A part of a link: all points within ``radius`` of the convex hull of ``points``.

    Attributes:
        link: name of the link.
        frame: number of the joint that moves it, -1 where it stands still.
        points: in that frame, or in the world where it stands still, shape (k, 3), [m].
        radius: [m].
    """

    link: str
    frame: int
    points: FloatArray
    radius: float

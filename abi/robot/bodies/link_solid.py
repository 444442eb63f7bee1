"""Solids that a link is drawn with, and points whose convex hull contains them."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.pose import Vec3

_SIDES = 48
"""Corners of the regular polygon around a cylinder's circle."""


@dataclass(frozen=True)
class LinkSolid:
    """A box or a cylinder of a link.

    Attributes:
        shape: ``box`` with ``size`` = edge lengths, or ``cylinder`` with ``size`` = (radius,
            radius, height) and its axis along its own z, [m].
        material: name of its colour.
        xyz: centre in the link's frame, [m].
        rpy: roll, pitch and yaw in the link's frame, [rad].
        body: True if it has mass and can collide; False if it is trim that is only drawn.
    """

    shape: Literal["box", "cylinder"]
    size: Vec3
    material: str
    xyz: Vec3 = (0.0, 0.0, 0.0)
    rpy: Vec3 = (0.0, 0.0, 0.0)
    body: bool = True


def corners(solid: LinkSolid) -> FloatArray:
    """Points (n, 3) in the link's frame whose convex hull contains the solid, [m].

    For a cylinder they are the corners of a prism around it, 0.2 % wider.
    """
    if solid.shape == "box":
        signs = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
        own = signs * solid.size
    else:
        radius, _, height = solid.size
        angles = 2 * math.pi * np.arange(_SIDES) / _SIDES
        rim = radius / math.cos(math.pi / _SIDES) * np.stack([np.cos(angles), np.sin(angles)], 1)
        own = np.concatenate(
            [np.column_stack([rim, np.full(_SIDES, end)]) for end in (-height / 2, height / 2)]
        )
    return np.asarray(own @ rotation_of(solid.rpy).T + solid.xyz)


def rotation_of(rpy: Vec3) -> FloatArray:
    """Rz(yaw)·Ry(pitch)·Rx(roll), URDF's order, shape (3, 3)."""
    (a, b, c), (u, v, w) = np.cos(rpy), np.sin(rpy)
    about_x = np.array([[1, 0, 0], [0, a, -u], [0, u, a]])
    about_y = np.array([[b, 0, v], [0, 1, 0], [-v, 0, b]])
    about_z = np.array([[c, -w, 0], [w, c, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)

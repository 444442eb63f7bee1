"""Masses and inertias of a URDF's links, which are needed for torques only."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.errors import SceneError
from abi.robot.urdf.strict_xml import XmlElement

_ROUNDING = 1e-9
"""Negative moment of inertia that counts as 0, over 1 kg·m²."""


Masses = tuple[float, FloatArray, FloatArray]
"""Mass of a link, or of several that move as one, [kg]; its centre in a frame, (3,), [m]; and the
inertia about that, along the axes of the frame, (3, 3), [kg·m²]."""

WEIGHTLESS: Masses = 0.0, read_only(np.zeros(3)), read_only(np.zeros((3, 3)))


def read_inertial(link: XmlElement) -> Masses:
    """Read the mass and inertia of a link; none if the file has none.

    Raises:
        SceneError: one of the numbers makes no sense, or is missing.
    """
    inertial = link.child("inertial")
    if inertial is None:
        return WEIGHTLESS
    mass = inertial.needed("mass").number("value", None, 0, 1e5)
    if mass == 0:
        return WEIGHTLESS
    pose = inertial.origin()
    turn = pose[:3, :3]
    inertia = turn @ _tensor(inertial) @ turn.T
    return mass, read_only(pose[:3, 3].copy()), read_only(inertia)


def has_sense(link: XmlElement) -> bool:
    """Check whether a link's masses are valid."""
    try:
        read_inertial(link)
    except SceneError:
        return False
    return True


def _tensor(inertial: XmlElement) -> FloatArray:
    part = inertial.needed("inertia")
    xx, yy, zz = (
        max(part.number(name, None, -_ROUNDING, 1e6), 0.0) for name in ("ixx", "iyy", "izz")
    )
    xy, xz, yz = (part.number(name, 0.0, -1e6, 1e6) for name in ("ixy", "ixz", "iyz"))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

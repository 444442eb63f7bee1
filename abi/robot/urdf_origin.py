"""Pose of an element of a URDF relative to its parent."""

from __future__ import annotations

import numpy as np
import scipy

from abi.arrays import FloatArray, read_only
from abi.obstacles.pose import Vec3
from abi.robot.strict_xml import Element

_ZERO: Vec3 = (0.0, 0.0, 0.0)


def origin_of(element: Element) -> FloatArray:
    """Pose (4, 4), [m], parent from element, that ``<origin>`` gives; without it the identity."""
    pose = np.eye(4)
    origin = element.child("origin")
    if origin is not None:
        pose[:3, 3] = origin.vector("xyz", _ZERO)
        # about the fixed axes x, y and z in that order
        turn = scipy.spatial.transform.Rotation.from_euler("xyz", origin.vector("rpy", _ZERO))
        pose[:3, :3] = turn.as_matrix()
    return read_only(pose)

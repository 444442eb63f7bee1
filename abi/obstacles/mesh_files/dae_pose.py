"""Poses of the nodes of a DAE file."""

from __future__ import annotations

import numpy as np
import scipy
from lxml import etree

from abi.arrays import FloatArray
from abi.obstacles.mesh_files.xml_document import affine, floats, name_of, where

_COUNTS = {"matrix": 16, "translate": 3, "rotate": 4, "scale": 3, "lookat": 9, "skew": 7}
_TINY = 1e-12


def node_pose(node: etree._Element) -> FloatArray:
    """Pose (4, 4) of a node in its parent: the product of its transforms, in their order.

    Raises:
        ValueError: one of them has the wrong numbers.
    """
    pose = np.eye(4)
    for element in node:
        kind = name_of(element)
        if kind not in _COUNTS:
            continue
        numbers = affine(floats(element), where(element))
        if len(numbers) != _COUNTS[kind]:
            raise ValueError(f"{_COUNTS[kind]} numbers in {where(element)}")
        pose = pose @ _transform(kind, numbers, where(element))
    return affine(pose, where(node))


def _transform(kind: str, numbers: FloatArray, name: str) -> FloatArray:
    pose = np.eye(4)
    if kind == "matrix":
        pose = numbers.reshape(4, 4)
        if (pose[3] != (0, 0, 0, 1)).any():
            raise ValueError(f"a matrix whose last row is 0 0 0 1, that of {name} is not")
    elif kind == "translate":
        pose[:3, 3] = numbers
    elif kind == "scale":
        pose[:3, :3] = np.diag(numbers)
    elif kind == "rotate":
        axis, angle = _unit(numbers[:3], name), np.radians(numbers[3])
        pose[:3, :3] = scipy.spatial.transform.Rotation.from_rotvec(angle * axis).as_matrix()
    elif kind == "lookat":
        eye, target, up = numbers.reshape(3, 3)
        back = _unit(eye - target, name)
        right = _unit(np.cross(up, back), name)
        pose[:3] = np.stack([right, np.cross(back, right), back, eye], axis=1)
    else:
        pose[:3, :3] = _skew(numbers, name)
    return pose


def _skew(numbers: FloatArray, name: str) -> FloatArray:
    """Shear (3, 3) along an axis by an angle from another, as RenderMan defines it."""
    angle = np.radians(numbers[0])
    turned, along = _unit(numbers[1:4], name), _unit(numbers[4:7], name)
    across = turned - (turned @ along) * along
    if np.linalg.norm(across) < 1e-9 or abs(np.cos(angle)) < 1e-9:
        raise ValueError(f"a skew of two directions, {name} has one")
    across /= np.linalg.norm(across)
    first, second = turned @ across, turned @ along
    x = first * np.cos(angle) - second * np.sin(angle)
    if x <= 0:
        raise ValueError(f"a skew by less than the angle of its directions, {name} is by more")
    y = first * np.sin(angle) + second * np.cos(angle)
    return np.asarray(np.eye(3) + (y / x - second / first) * np.outer(along, across))


def _unit(vector: FloatArray, name: str) -> FloatArray:
    length = float(np.linalg.norm(vector))
    if length < _TINY:
        raise ValueError(f"directions that are not zero in {name}")
    return vector / length

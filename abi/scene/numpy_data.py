"""Conversion of numpy and trimesh objects to fields of a scene: poses, points and meshes."""

from __future__ import annotations

from collections.abc import Mapping, MappingView, Set
from typing import Any

import numpy as np
from pydantic import BaseModel

from abi.arrays import FloatArray
from abi.errors import ArgumentError, Described, SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh.repair import clean

_RIGID = 1e-6
"""Largest deviation of a pose's rotation times its transpose from the identity."""

_NO_FIELDS = "cmM"
"""Kinds of numpy's types whose numbers no field has: complex ones, durations and dates."""

_BITS = 10_000
"""Most bits of a whole number: no field takes as large a one, and Python writes few larger ones."""


def plain(field: str, value: object) -> object:
    """Plain data of a scene's field that may contain numpy or trimesh objects.

    Arrays become lists, of shape (4, 4) a position and a quaternion; a triangle mesh of trimesh
    becomes a mesh shape where it stands. All else stays as it is.

    Args:
        field: name of the field, for errors.
        value: what was given for it.

    Raises:
        SceneError: an array (4, 4) is no pose, one is not of real numbers, a mesh is none, there is
            a set, or a whole number has thousands of digits.
    """
    if isinstance(value, BaseModel | str | bytes) or value is None:
        return value
    if isinstance(value, int) and value.bit_length() > _BITS:
        raise SceneError(field, value, "a number of fewer digits")
    if isinstance(value, np.generic):
        value = np.asarray(value)
    if isinstance(value, np.ndarray):
        if value.dtype.kind in _NO_FIELDS or np.ma.is_masked(value):
            given = Described(f"of numpy's type {value.dtype}")
            raise SceneError(field, given, "real numbers, none of them masked")
        return _pose(field, value) if value.shape == (4, 4) else value.tolist()
    if isinstance(value, Mapping):
        return _with_pose(field, value)
    if isinstance(value, list | tuple):
        items = [plain(f"{field}[{k}]", one) for k, one in enumerate(value)]
        return items if isinstance(value, list) else tuple(items)
    if isinstance(value, Set | MappingView):
        raise SceneError(field, Described("a set"), "a list, since a set has no order of its own")
    if hasattr(value, "vertices") and hasattr(value, "faces"):
        return _mesh(field, value)
    return value


def plain_fields(data: Mapping[str, Any], field: str = "") -> dict[str, Any]:
    """Fields with plain values.

    Args:
        data: values by the fields' names.
        field: name of the field that they belong to; empty for those of the scene.

    Raises:
        SceneError: a name is no text, or as in :func:`plain`.
    """
    for name in data:
        if not isinstance(name, str):
            raise SceneError(f"{field}.[key]".lstrip("."), name, "names of fields as text")
    return {name: plain(f"{field}.{name}".lstrip("."), one) for name, one in data.items()}


def _with_pose(field: str, data: Mapping[str, Any]) -> dict[str, Any]:
    """Plain fields, in place of an array as ``pose`` a position and a quaternion.

    In files there is no such field, and it is refused as any other that is not known.
    """
    found = plain_fields(data, field)
    pose = data.get("pose")
    if not isinstance(pose, np.ndarray) or pose.shape != (4, 4):
        return found
    if twice := {"position", "wxyz"} & data.keys():
        raise SceneError(f"{field}.pose", pose.tolist(), f"no {min(twice)} beside a pose")
    standing = found.pop("pose")
    assert isinstance(standing, dict)
    return found | standing


def _pose(field: str, matrix: FloatArray) -> dict[str, Any]:
    """Position and quaternion of a pose (4, 4), ``world_from_body``."""
    from scipy.spatial.transform import Rotation  # here, since it takes long to import

    if matrix.dtype.kind not in "fiu":
        raise SceneError(field, matrix.tolist(), "real numbers")
    pose = np.asarray(matrix, dtype=np.float64)
    turn = pose[:3, :3]
    off = np.abs(turn.T @ turn - np.eye(3)).max() if np.isfinite(pose).all() else np.inf
    if not off <= _RIGID or np.linalg.det(turn) < 0 or pose[3].tolist() != [0, 0, 0, 1]:
        expected = "a rotation and a position, and [0, 0, 0, 1] as the last row"
        raise SceneError(field, pose.tolist(), expected)
    x, y, z, w = Rotation.from_matrix(turn).as_quat().tolist()
    return {"position": pose[:3, 3].tolist(), "wxyz": [w, x, y, z]}


def _mesh(field: str, mesh: Any) -> MeshShape:
    """A trimesh mesh as an obstacle, in its own units or else in the scene's."""
    try:
        surface = clean(mesh.vertices, mesh.faces, field)
        units = getattr(mesh, "units", None)
        if units is not None:
            from trimesh.units import unit_conversion

            surface = surface.of_file(float(unit_conversion(units, "meters")), ())
    except SceneError:
        raise
    except ArgumentError as error:
        part = error.field.removeprefix("one of ")
        raise SceneError(f"{field}.{part}", error.value, error.expected) from None
    except (KeyError, TypeError, ValueError):
        raise SceneError(field, mesh, "a triangle mesh in a unit that trimesh knows") from None
    return MeshShape.of(surface, f"mesh-{surface.digest[:12]}.ply")

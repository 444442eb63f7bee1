"""The obstacles as a MoveIt scene file, which RViz imports under Scene Objects.

The text form of ``planning_scene::PlanningScene::saveGeometryToStream`` of MoveIt 1 and 2 with an
object's own pose, which is that of the scene in the frame of the robot's root: the file names no
frame, and MoveIt takes the root of the robot's URDF. Lengths in [m], quaternions x y z w.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from abi.errors import AbiError
from abi.export.solids import Solid, solids
from abi.obstacles.pose import METRES, Quaternion, Vec3, rotation
from abi.planner.plan import Plan

_NO_COLOUR = "0 0 0 0"


def write(plan: Plan, name: str) -> bytes:
    """Write every obstacle as an object; a capsule is one object of three shapes.

    Raises:
        AbiError: there are no obstacles; MoveIt refuses such a file.
    """
    scene = plan.scene
    if not scene.obstacles:
        raise AbiError("The scene has no obstacles, and MoveIt reads no scene without.")
    w, x, y, z = scene.arm.base_wxyz
    from_root = rotation(scene.arm.base_wxyz).T
    origin = -METRES[scene.unit] * from_root @ np.array(scene.arm.base) + 0.0  # no -0.0
    place = _pose((origin[0], origin[1], origin[2]), (w, 0.0 - x, 0.0 - y, 0.0 - z))
    lines = ["abi"]
    for number, parts in enumerate(solids(scene.obstacles, scene.unit)):
        lines += [f"* obstacle_{number + 1}", *place]
        lines.append(str(len(parts)))
        for solid in parts:
            lines += [*_shape(solid), *_pose(solid.position, solid.wxyz), _NO_COLOUR]
        lines.append("0")  # subframes
    return "\n".join([*lines, ".", ""]).encode()


def _shape(solid: Solid) -> Iterator[str]:
    yield solid.kind
    width, _, height = solid.size
    if solid.kind == "box":
        yield _numbers(solid.size)
    elif solid.kind == "sphere":
        yield _numbers((width / 2,))
    elif solid.kind == "cylinder":
        yield _numbers((width / 2, height))
    else:
        corners, faces = np.unique(solid.triangles.reshape(-1, 3), axis=0, return_inverse=True)
        triangles = faces.reshape(-1, 3)
        yield f"{len(corners)} {len(triangles)}"
        yield from (_numbers(tuple(corner)) for corner in corners.tolist())
        yield from (f"{a} {b} {c}" for a, b, c in triangles.tolist())


def _pose(position: Vec3, wxyz: Quaternion) -> tuple[str, str]:
    w, x, y, z = wxyz
    return _numbers(position), _numbers((x, y, z, w))


def _numbers(numbers: tuple[float, ...]) -> str:
    return " ".join(repr(float(number)) for number in numbers)

"""The arm as URDF, in metres: alone, or packed with its meshes."""

from __future__ import annotations

from pathlib import PurePosixPath

from abi.errors import AbiError
from abi.obstacles.triangle_mesh.mesh_reader import SUFFIXES
from abi.planner.plan import Plan
from abi.robot.any_arm import AnyArm
from abi.robot.urdf.robot_files import packed


def write(plan: Plan, name: str) -> bytes:
    """Write the arm, with its root link at the origin: the paper's arm, or the URDF it came from.

    Raises:
        AbiError: the plan has no arm, or one that has meshes.
    """
    arm = _arm_of(plan)
    if any(PurePosixPath(file).suffix.lower() in SUFFIXES for file in arm.files()):
        raise AbiError(
            "This arm's URDF needs its meshes: export it as a .zip, which holds them, too."
        )
    return arm.description().encode()


def write_archive(plan: Plan, name: str) -> bytes:
    """Write the arm's URDF with its meshes, as a zip that can be uploaded as an arm.

    Raises:
        AbiError: the plan has no arm.
    """
    return packed(_arm_of(plan).files())


def _arm_of(plan: Plan) -> AnyArm:
    if plan.arm is None:
        raise AbiError("There is no arm to export: the scene was not planned.")
    return plan.arm

"""Statements of a plan or a verdict that no check of this package reads."""

from __future__ import annotations

from typing import Any

_OF_PLANS = (
    *("mesh", "graph", "searches", "path", "taut", "optimum"),
    *("bspline.length", "bspline.inserted", "bspline.moved"),
    *("quadratic.length", "quadratic.mode", "quadratic.note"),
    *("timing.theorem_residual", "timing.liquid_tilt", "joint_search", "error", "notes"),
    *("arm.clearances", "arm.clearance_time", "arm.clearance_obstacle", "arm.nearest"),
    *("arm.contacts", "arm.limits_passed", "arm.capsules"),
    *("arm.torques", "arm.peak_joint_torque", "arm.joint_torque_limits"),
    *("arm.axis.angle", "arm.axis.bound", "arm.state"),
)
_PHASES = ("timing.t1", "timing.t2", "timing.t3", "timing.peak_speed")
"""Read where a force moves the slide of the paper's arm."""
_OF_URDF_PLANS = ("timing.curve", "arm.elbow")
_OF_PAPER_PLANS = (
    *("arm.within_limits", "arm.joint_speed_limits"),
    *("arm.peak_joint_acceleration", "arm.joint_acceleration_limits"),
)
_OF_DIRECTION = tuple(f"direction.{name}" for name in ("angle", "stretches", "time", "why"))
_OF_MOTIONS = ("limits", *_OF_DIRECTION, "time", "link", "obstacle", "notes")
"""Unchecked fields, the most telling ones of each section; computing times are left out."""


def unchecked(data: object) -> tuple[str, ...]:
    """Fields that a plan, a sequence of tasks or a verdict states and :func:`verify` does not read.

    Args:
        data: what is verified.
    """
    if not isinstance(data, dict):
        return ()
    if isinstance(legs := data.get("legs"), list):
        return tuple(dict.fromkeys(name for leg in legs for name in unchecked(leg)))
    arm = _arm_of(data.get("scene"))
    of_arm: tuple[str, ...]
    of_arm = _OF_URDF_PLANS if arm.get("model") == "urdf" else _OF_PAPER_PLANS
    if arm.get("model") == "urdf" or arm.get("forces", [0, 0, 0])[1:2] == [0]:
        of_arm += _PHASES
    names = _OF_MOTIONS if "verdict" in data else (*_OF_PLANS, *of_arm)
    return tuple(name for name in names if _is_stated(data, name))


def _arm_of(scene: object) -> dict[str, Any]:
    arm = scene.get("arm") if isinstance(scene, dict) else None
    return arm if isinstance(arm, dict) else {}


def _is_stated(data: dict[str, Any], name: str) -> bool:
    value: object = data
    for field in name.split("."):
        value = value.get(field) if isinstance(value, dict) else None
    return value is not None and value != []

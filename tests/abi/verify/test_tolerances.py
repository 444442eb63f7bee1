"""Tolerances of the verifier: what it lets pass is let pass, and a little more is not."""

from __future__ import annotations

import copy
import importlib
import json
import math
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest

from abi import load_scene, plan
from abi.arm_planning.certificates.separate_chain_kernels import separate_chain
from abi.planner.planner import Planner
from abi.scene.held_axis import HeldAxis
from abi.verify import held_direction, tool_path
from abi.verify.arm_capsules import capsules_of
from abi.verify.exact.paper_arm import ExactArm
from abi.verify.exact.robot_chain import exact_chain
from abi.verify.exact.solids import exact_spline, vector
from abi.verify.fault import Fault
from tests.abi.verify.verdicts import NEAR, verdict_on

Data = dict[str, Any]

_PAPER = load_scene("paper").replace(goal=[1.5, 2.0, 2.0], motion={"samples": 25})
"""A short way, as exact numbers take long."""


@cache
def _of_paper() -> Data:
    data: Data = json.loads(json.dumps(plan(_PAPER).to_dict()))
    return data


@cache
def _of_urdf() -> Data:
    """A plan past an obstacle so far away that the wrist is proven clear however it is turned."""
    separate_chain.compile()
    planned = Planner()(NEAR.replace(obstacles=load_scene("kitchen-ur5e").obstacles[2:3]))
    data: Data = json.loads(json.dumps(planned.to_dict()))
    return data


def ends(part: float) -> bool:
    """Whether a curve may begin so far from the start, in 1e-9 of the largest coordinate."""
    scene = load_scene("paper")
    x, y, z = scene.start
    largest = max(map(abs, (*scene.workspace.min, *scene.workspace.max)))
    first, last = vector((x + part * 1e-9 * largest, y, z)), vector(scene.goal)
    knots = [Fraction(number) for number in (0, 0, 1, 1)]
    try:
        tool_path.check_ends(exact_spline(1, knots, [first, last]), scene)
    except Fault:
        return False
    return True


def margin(part: float) -> bool:
    """Whether a curve may be called certified that misses the clearance by parts of 1e-9."""
    data = copy.deepcopy(_of_paper())
    claimed = data["scene"]["spline"]["clearance"] - part * 1e-9
    data["bspline"]["certificate"]["margin"] = data["bspline"]["clearance"] = claimed
    assert data["bspline"]["certified"]
    return verdict_on("bspline", data).proven


def tool(part: float) -> bool:
    """Whether the tool may be beside the curve by parts of 1e-7 of the arm's length."""
    data = copy.deepcopy(_of_paper())
    arm = data["scene"]["arm"]
    length = arm["a3"] + arm["a4"] + arm["a5"]
    q1, q2, q3 = data["arm"]["positions"][0][:3]
    out = arm["a3"] * math.sin(q2) + (length - arm["a3"]) * math.sin(q2 + q3)
    # what counts is the largest of the coordinates' errors
    across = abs(out) * max(abs(math.sin(q1)), abs(math.cos(q1)))
    data["arm"]["positions"][0][0] += part * 1e-7 * length / across
    return verdict_on("arm", data).proven


def end_of_chain(part: float) -> bool:
    """Whether a URDF arm's tool may miss the start by parts of 1e-5 of the chain's length."""
    data = copy.deepcopy(_of_urdf())
    scene = load_scene("kitchen-ur5e")
    chain = exact_chain(scene.arm.robot, scene.arm.tool, scene.arm.base, 1, scene.arm.base_wxyz)
    length = float(
        sum(sum(map(abs, origin)) for origin in (pose[:3, 3] for pose in chain.origins[1:]))
    )
    data["scene"]["start"][0] += part * 1e-5 * length
    return verdict_on("arm", data).proven


def past_limit(part: float) -> bool:
    """Whether a joint may be past its limit by parts of 1e-9, where its turns cost no clearance."""
    data = copy.deepcopy(_of_urdf())
    limit = 2 * math.pi
    for rows in (data["arm"]["positions"], data["arm"]["certificate"]["positions"]):
        for row in rows:
            row[-1] = limit + part * 1e-9
    return verdict_on("arm", data).proven


def seam(part: float) -> bool:
    """Whether capsules may leave a gap of parts of an 80th of the forearm before the gripper."""
    certificate = copy.deepcopy(_of_paper()["arm"]["certificate"])
    arm = ExactArm(vector((0, 0, 0)), Fraction(3), Fraction(6), Fraction(8), 1)
    for one in certificate["capsules"]:
        one["neighbour"] = one["grips"] = False
        whole = one["body"] in ("column", "upper_arm")
        one["low"], one["high"], one["radius"] = 0.0, 6.0 if whole else 4.0, 0.5
        if one["link"] == "gripper":
            one["low"], one["high"] = 5.0 + part / 10, 8.0
    try:
        capsules_of(certificate, arm, Fraction(1))
    except Fault:
        return False
    return True


def turned(part: float) -> bool:
    """Whether a tool may be off its direction by parts of 1e-9 rad more than is asked for."""
    scene = load_scene("kitchen-ur5e")
    chain = exact_chain(scene.arm.robot, scene.arm.tool, scene.arm.base, 1, scene.arm.base_wxyz)
    joints = [0.3, -1.2, 1.0, 0.4, 0.5, 0.6]
    z = chain.place([*map(Fraction, joints)])[-1].turn[:, 2].astype(float) / 2.0**200
    aside = np.cross(z, [1.0, 0.0, 0.0])
    angle = 0.1 + part * 1e-9
    direction = math.cos(angle) * z + math.sin(angle) * aside / np.linalg.norm(aside)
    axis = HeldAxis.model_validate({"direction": direction.tolist(), "tolerance": 0.1})
    still = {"time": [0.0, 1.0], "positions": [joints, joints]}
    try:
        rows = [[*map(Fraction, joints)]] * 2
        held_direction.check_held_at_samples(axis, chain, scene.arm.tool, rows, still)
    except Fault:
        return False
    return True


class Tolerance(NamedTuple):
    """A tolerance of the verifier, and a test that lets pass so many parts of it."""

    module: str
    name: str
    lets_pass: Callable[[float], bool]


TOLERANCES = [
    Tolerance("tool_path", "_ROUNDING", ends),
    Tolerance("verify_curve", "_TOUCH", margin),
    Tolerance("tool_path", "_REACHED", tool),
    Tolerance("verify_chain", "_REACHED", end_of_chain),
    Tolerance("verify_chain", "_PAST", past_limit),
    Tolerance("arm_capsules", "_GAP", seam),
    Tolerance("held_direction", "_SLACK", turned),
]


@pytest.mark.slow
@pytest.mark.parametrize("one", TOLERANCES, ids=lambda one: f"{one.module} {one.name}")
def test_a_tolerance_is_what_it_says(one: Tolerance, monkeypatch: pytest.MonkeyPatch) -> None:
    assert one.lets_pass(0.75)
    assert not one.lets_pass(1.5)
    module = importlib.import_module(f"abi.verify.{one.module}")
    value = getattr(module, one.name)
    for part in (Fraction(1, 2), Fraction(0)):
        monkeypatch.setattr(module, one.name, part * value)
        assert not one.lets_pass(0.75)
    monkeypatch.setattr(module, one.name, 2 * value)
    assert one.lets_pass(1.5)

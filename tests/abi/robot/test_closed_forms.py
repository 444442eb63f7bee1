"""Closed forms of the inverse kinematics give every pose, and are believed only where they hold."""

from __future__ import annotations

import importlib
import itertools
import pkgutil
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from abi.arrays import FloatArray
from abi.robot import kinematics
from abi.robot.kinematics import closed_forms
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.closed_forms import closed_positions
from abi.robot.urdf.robot_files import robot_from_archive
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from tests.abi.robot.robots import arm, link, packed, urdf

LIMIT = '<limit lower="{0}" upper="{1}" velocity="1" effort="9"/>'
ORDERS = sorted(set(itertools.permutations(["revolute", "revolute", "prismatic"])))


def scara(seed: int, order: tuple[str, ...], wrist: bool = True, tilt: float = 0.0) -> str:
    """A SCARA arm of random lengths from ``a`` to ``tip``, its axes upwards or downwards.

    ``tilt`` is the angle of the second axis, [rad].
    """
    random = np.random.default_rng(seed)
    names, joints = "abcde", []
    kinds = [*order, "revolute"] if wrist else [*order]
    for k, kind in enumerate(kinds):
        x, y, z = random.uniform(0.1, 0.5, 3) * (k > 0)
        limit = (-0.4, 0.6) if kind == "prismatic" else (-2.9, 3.1)
        turn = f'rpy="{tilt * (k == 1)} 0 {random.uniform(-1, 1) if k < 3 else 0}"'
        joints.append(
            f'<joint name="j{k}" type="{kind}"><origin xyz="{x} {y} {z}" {turn}/>'
            f'<parent link="{names[k]}"/><child link="{names[k + 1]}"/>'
            f'<axis xyz="0 0 {random.choice([-1, 1])}"/>{LIMIT.format(*limit)}</joint>'
        )
    last, far = names[len(kinds)], "0 0 -0.2" if wrist else "0.3 0.1 -0.2"
    joints.append(
        f'<joint name="end" type="fixed"><origin xyz="{far}"/><parent link="{last}"/>'
        '<child link="tip"/></joint>'
    )
    return urdf(*map(link, names[: len(kinds) + 1]), '<link name="tip"/>', *joints)


def standing(text: str, seed: int = 0) -> UrdfArm:
    x, y, z, w = Rotation.random(random_state=seed).as_quat().tolist()
    robot = robot_from_archive(packed({"a.urdf": text}))
    return urdf_arm(robot, "tip", (0.3, -0.2, 0.1), None, "cm", (w, x, y, z))


@given(st.integers(0, 1_000), st.sampled_from(ORDERS), st.booleans())
def test_every_pose_of_a_scara_arm_is_found(seed: int, order: tuple[str, ...], wrist: bool) -> None:
    chain = standing(scara(seed, order, wrist), seed).chain
    low, high = chain.limits.T
    at = np.random.default_rng(seed).uniform(low, high)
    at[3:] = 0.0
    point = tip_of(chain, at)
    found = closed_positions(chain, point)

    assert 1 <= len(found) <= 2
    for positions in found:
        np.testing.assert_allclose(tip_of(chain, positions), point, atol=1e-9)
        assert ((positions >= low) & (positions <= high)).all()
    assert min(np.abs(positions - at).max() for positions in found) < 1e-6


def tip_of(chain: Chain, positions: FloatArray) -> FloatArray:
    return np.asarray(chain.poses(positions[None])[0, -1, :, 3])


def test_what_is_no_scara_arm_has_no_closed_form() -> None:
    others = [
        standing(scara(1, ORDERS[0], tilt=0.01)).chain,
        standing(scara(1, ("revolute", "revolute", "revolute"))).chain,
        # both turn about one axis
        standing(
            re.sub(r'<origin xyz="[^ ]+ [^ ]+', '<origin xyz="0 0', scara(1, ORDERS[1]), count=3)
        ).chain,
        Chain.of(robot_from_archive(packed({"a.urdf": arm()})), "d"),
    ]
    for chain in others:
        assert closed_positions(chain, tip_of(chain, np.full(len(chain.names), 0.2))) == []
    chain = standing(scara(1, ORDERS[0])).chain
    assert closed_positions(chain, np.array([100.0, 0.0, 0.0])) == []


def test_first_poses_are_those_of_the_closed_form(monkeypatch: pytest.MonkeyPatch) -> None:
    one = standing(scara(4, ("revolute", "revolute", "prismatic"), wrist=False))
    (point,) = one.tool(np.array([[0.3, 0.9, 10.0]]))
    exact = one.first_poses(point)
    assert len(exact) == 2

    def wrong(chain: Chain, point: FloatArray) -> list[FloatArray]:
        return [np.full(len(chain.names), 1e6)]

    monkeypatch.setattr(closed_forms, "CLOSED_FORMS", (wrong,))
    other = standing(scara(4, ("revolute", "revolute", "prismatic"), wrist=False))
    sought = other.first_poses(point)
    np.testing.assert_allclose(np.sort(exact, axis=0), np.sort(sought, axis=0), atol=1e-3)


def test_every_closed_form_is_in_the_table() -> None:
    for module in pkgutil.iter_modules(kinematics.__path__):
        found = vars(importlib.import_module(f"{kinematics.__name__}.{module.name}"))
        for name, one in found.items():
            if name.endswith("_positions") and one.__module__ != closed_forms.__name__:
                assert one in closed_forms.CLOSED_FORMS, f"{name} is missing in CLOSED_FORMS"

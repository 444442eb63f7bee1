"""An arm that does not come along follows the shipped scenes."""

from __future__ import annotations

import json

import numpy as np
import pytest

from abi.arm_planning.certificates.separate_chain_kernels import separate_chain
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.planner import Planner
from abi.scene.scene import load_scene
from abi.verify.verify import verify
from tests.abi.robot.robots import packed

_AXES = ("0 0 1", "0 1 0", "0 0 1", "0 -1 0", "0 0 1", "0 1 0", "0 0 1")
_HEIGHTS = (0.1575, 0.2025, 0.2045, 0.2155, 0.1845, 0.2155, 0.081)
_LIMITS = (2.97, 2.09, 2.97, 2.09, 2.97, 2.09, 3.05)


def iiwa() -> str:
    """Seven joints in the places of a KUKA LBR iiwa, and a flange; no shapes but short rods."""
    parts = ['<robot name="iiwa"><link name="l0"/>']
    for k, (axis, height, limit) in enumerate(zip(_AXES, _HEIGHTS, _LIMITS, strict=True)):
        rod = '<cylinder radius="0.06" length="0.12"/>'
        rod = f"<collision><geometry>{rod}</geometry></collision>"
        parts.append(f'<link name="l{k + 1}">{rod}</link>')
        parts.append(
            f'<joint name="j{k + 1}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/>'
            f'<origin xyz="0 0 {height}"/><axis xyz="{axis}"/>'
            f'<limit lower="-{limit}" upper="{limit}" effort="100" velocity="1.5"/></joint>'
        )
    flange = '<origin xyz="0 0 0.045"/><parent link="l7"/><child link="flange"/>'
    parts.append(f'<link name="flange"/><joint name="f" type="fixed">{flange}</joint></robot>')
    return "".join(parts)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper", "two-boxes", "wall-with-window", "thin-plate"])
def test_it_follows_the_curve_or_it_is_said_where_not(name: str) -> None:
    scene = load_scene(name).replace(
        {"iiwa.zip": packed({"iiwa.urdf": iiwa()})},
        arm={"model": "urdf", "urdf": "iiwa.zip", "tip": "flange", "base": (3.0, -45.0, -30.0)}
        | {"avoid": False},
    )
    made = Planner()(scene)
    motion, arm = made.motion, made.arm

    assert made.error is None, made.error
    assert motion is not None
    assert arm is not None
    assert motion.reachable
    assert motion.joints == tuple(f"j{k}" for k in range(1, 8))
    assert np.abs(motion.tool - motion.target).max() < 1e-4 * arm.reach
    assert (motion.positions >= arm.limits[:, 0] - 1e-12).all()
    assert (motion.positions <= arm.limits[:, 1] + 1e-12).all()

    far = Planner()(scene.replace(arm={"base": (300.0, 0.0, 0.0)}))
    assert far.error is not None
    assert far.error.kind == "out_of_reach"
    assert "From t =" in far.error.message


@pytest.mark.slow
def test_its_plan_avoids_the_obstacles_with_the_whole_arm_and_is_proven() -> None:
    separate_chain.compile()
    files = {"iiwa.zip": packed({"iiwa.urdf": iiwa()})}
    arm = {"urdf": "iiwa.zip", "tip": "flange"}
    scene = load_scene("kitchen-ur5e").replace(files, arm=arm)
    alone = Planner()(scene.replace(arm={"avoid": False})).arm_clearance
    assert alone is not None
    assert alone.contacts

    made = Planner()(scene)
    assert made.error is None, made.error
    assert made.is_arm_clear
    data = json.loads(json.dumps(made.to_dict()))
    verdicts = {one.curve: one for one in verify(data, MeshSource(files))}
    assert verdicts["arm"].proven, verdicts["arm"].reason
    del data["arm"]["certificate"]["planes"][7]
    assert not {one.curve: one for one in verify(data, MeshSource(files))}["arm"].proven

"""Links that never touch by their shapes are proven apart where one or two joints move them."""

from __future__ import annotations

import json
import math
import re
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import event, given, settings
from hypothesis import strategies as st

from abi.planner.planner import plan
from abi.robot.bodies import never_touching
from abi.robot.bodies.never_touching import never_touch
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import robot_from_archive
from abi.robot.urdf_arm import UrdfArm
from abi.scene.scene import Scene
from abi.verify import never_touching as verified
from abi.verify.exact.robot_chain import exact_joints
from abi.verify.verify import verify
from tests.abi.robot.robots import follows, joint, packed, urdf

TUBE_FILE: bytes = trimesh.creation.annulus(0.1, 0.2, 0.1).export(file_type="stl")
seeds = st.integers(0, 2**31)


def shaped(name: str, shape: str, xyz: tuple[float, float, float] = (0, 0, 0)) -> str:
    x, y, z = xyz
    return (
        f'<link name="{name}"><collision><origin xyz="{x} {y} {z}" rpy="0.2 0 0.4"/>'
        f"<geometry>{shape}</geometry></collision></link>"
    )


def apart(robot: Robot, names: tuple[str, ...], first: str, second: str) -> bool:
    """What the planner proves, which the verifier has to find, too."""
    found = never_touch(Chain.moved_by(robot, names), first, second)
    exact = exact_joints(robot, names, (0, 0, 0), 1000)
    assert not found or verified.never_touch(robot, exact, first, second)
    return found


def touches(robot: Robot, names: tuple[str, ...], first: str, second: str, count: int) -> bool:
    """Whether two links touch at some of many positions, by the verifier's arithmetic."""
    exact = exact_joints(robot, names, (0, 0, 0), 1000)
    low, high = (np.array([float(one[side]) for one in exact.limits]) for side in (0, 1))
    middle = [(one + other) / 2 for one, other in exact.limits]
    axes = verified._axes(exact, exact.place(middle), first, second)
    frames = exact.place(middle)
    still, moved = (verified._placed(robot, exact, frames, name) for name in (first, second))
    used = sorted({one.coordinate for one in axes})
    positions = np.random.default_rng(3).uniform(-0.5, 0.5, (count, len(low))) * (high - low)
    return bool(verified._meeting(still, moved, axes, positions[:, used], np.zeros(count)).any())


@settings(deadline=None, max_examples=10)
@given(seeds)
def test_what_is_proven_apart_meets_nowhere(seed: int) -> None:
    random = np.random.default_rng(seed)
    shapes = ['<box size="0.2 0.3 0.4"/>', '<sphere radius="0.15"/>',
              '<cylinder radius="0.1" length="0.4"/>', '<mesh filename="a.stl"/>']  # fmt: skip
    one, other = random.choice(shapes, 2).tolist()
    places = [tuple(random.normal(0, 0.25, 3).tolist()) for _ in "ab"]
    kinds = random.choice(["revolute", "prismatic"], 2).tolist()
    more = follows("p", 0.7, 0.1) if random.random() < 0.3 else ""
    axes = [" ".join(map(str, random.normal(size=3))) for _ in "ab"]
    limits = [f'<limit lower="-0.4" upper="{high}"/>' for high in random.uniform(0, 2, 2)]
    robot = robot_from_archive(packed({"a.stl": TUBE_FILE, "a.urdf": urdf(
        shaped("a", one, places[0]),
        '<link name="m"/>',
        shaped("b", other, places[1]),
        joint("p", "a", "m", kinds[0], axes[0], limits[0]),
        joint("q", "m", "b", kinds[1], axes[1], limits[1] + more),
    )}))  # fmt: skip
    names = ("p",) if more else ("p", "q")
    first, second = random.permutation(["a", "b"]).tolist()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(never_touching, "_WORK", 100_000)
        if apart(robot, names, first, second):
            assert not touches(robot, names, first, second, 200)
            event("apart")


RING = trimesh.creation.annulus(0.1, 0.2, 0.05)


def pin_in_ring(thorn: float, high: float = 1.5, name: str = "r") -> dict[str, str | bytes]:
    """Files of a robot whose pin turns and rises in a ring, with a thorn on each, so long."""
    inside = trimesh.creation.box((0.0004, thorn, 0.004))
    inside.apply_translation((0, 0.1 - thorn / 2, 0))
    ring = trimesh.Trimesh(
        np.concatenate([RING.vertices, inside.vertices]),
        np.concatenate([RING.faces, inside.faces + len(RING.vertices)]),
    )
    pin = shaped("pin", '<box size="0.0004 0.13 0.004"/>').replace('rpy="0.2 0 0.4"', "")
    limit = f'<limit lower="-1.3" upper="{high}" velocity="1" effort="9"/>'
    short = '<limit lower="0" upper="0.001" velocity="1" effort="9"/>'
    text = urdf(
        shaped("ring", '<mesh filename="a.stl"/>').replace('rpy="0.2 0 0.4"', ""),
        '<link name="m"/>',
        pin,
        joint("p", "ring", "m", "revolute", "0 0 1", limit).replace("0 0 0.4", "0 0 0"),
        joint("q", "m", "pin", "prismatic", "0 0 1", short).replace("0 0 0.4", "0 0 0"),
    ).replace('rpy="0.3 0.2 0.1"', "")
    text = text.replace('<robot name="r">', f'<robot name="{name}">')
    content: bytes = trimesh.exchange.stl.export_stl(ring)
    return {"a.urdf": text, "a.stl": content}


@pytest.mark.parametrize(
    ("thorn", "high", "never"),
    # the pin gets to 0.065 from the axis, and meets the thorn in a five-hundredth of its turn
    [(0.03, 1.5, True), (0.034, 1.5, True), (0.036, 1.5, False), (0.036, -0.3, True)],
)
def test_a_contact_in_a_small_part_of_the_range_is_not_passed_over(
    thorn: float, high: float, never: bool
) -> None:
    robot = robot_from_archive(packed(pin_in_ring(thorn, high)))
    chain = Chain.moved_by(robot, ("p", "q"))
    exact = exact_joints(robot, ("p", "q"), (0, 0, 0), 1000)
    for links in (("ring", "pin"), ("pin", "ring")):
        assert never_touch(chain, *links) == never
        assert verified.never_touch(robot, exact, *links) == never


@pytest.mark.parametrize("apart", [False, True])
def test_two_drums_are_apart_only_if_both_of_their_rims_are(apart: bool) -> None:
    drum = '<link name="{}"><collision><geometry><cylinder radius="1" length="1"/></geometry>'
    drum += "</collision></link>"
    # turned by half a corner of 192, both prisms have their sides towards each other
    way, turned = 2 + (3e-4 if apart else -4e-5), math.pi / 192
    place = f'xyz="{way * math.cos(turned)} {way * math.sin(turned)} 0"'
    limit = '<limit lower="-1e-5" upper="1e-5"/>'
    slide = joint("p", "a", "b", "prismatic", "0 0 1", limit)
    slide = re.sub("<origin[^>]*>", f"<origin {place}/>", slide)
    text = urdf(drum.format("a"), drum.format("b"), slide)
    robot = robot_from_archive(packed({"a.urdf": text}))
    exact = exact_joints(robot, ("p",), (0, 0, 0), 1)
    assert verified.never_touch(robot, exact, "a", "b") == apart


def scene(files: dict[str, Any]) -> Scene:
    return Scene.from_dict(
        {
            "version": 1,
            "unit": "m",
            "workspace": {"min": [-1, -1, -1], "max": [1, 1, 1]},
            "start": {"joints": [-1.0, 0.0]},
            "goal": {"joints": [-0.5, 0.0005]},
            "arm": {"model": "urdf", "urdf": "a.zip", "base": [0, 0, 0], "search": "joints"},
        },
        {"a.zip": packed(files)},
    )


def test_links_whose_pieces_alone_overlap_are_planned_and_the_proof_holds() -> None:
    found = plan(scene(pin_in_ring(0.03)))
    assert found.error is None
    assert isinstance(found.arm, UrdfArm)
    assert [one.reason for one in found.arm.allowed if "pin" in one] == ["never"]
    data = json.loads(json.dumps(found.to_dict()))
    assert verify(data, found.scene.meshes)[-1].proven


def test_a_certificate_that_calls_a_contact_impossible_is_refused() -> None:
    found = plan(scene(pin_in_ring(0.03)))
    data = json.loads(json.dumps(found.to_dict()))
    other = scene(pin_in_ring(0.036, name="other"))
    verdict = verify(data | {"scene": other.to_dict()}, other.meshes)[-1]
    assert not verdict.proven
    assert "no pair that may touch" in verdict.reason

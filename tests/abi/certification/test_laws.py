"""Laws of verdicts on random motions: samples never refute a proof, and contacts are there."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from abi.certification import exact_contact
from abi.certification.certify_motion import _covered, certify_motion
from abi.certification.clearance_proof import nearest
from abi.certification.motion import Motion
from abi.certification.read_motion import joint_names
from abi.certification.robot_scene import robot_scene
from abi.scene.scene import Scene
from abi.verify.verify import verify
from tests.thorough import of_each_kind

pytestmark = pytest.mark.slow
ARMS = ("ur5e", "panda", "xarm7")


def random_task(seed: int) -> tuple[Motion, Scene]:
    """A motion of a shipped arm among boxes, balls and cylinders around it."""
    random = np.random.default_rng(seed)
    scene = robot_scene(ARMS[seed % 3])
    robot = scene.arm.robot
    names = [name for name in joint_names(robot) if "finger" not in name and "drive" not in name]
    limits = {joint.name: (joint.low, joint.high) for joint in robot.joints}
    low, high = np.clip(np.array([limits[name] for name in names]).T, -2.5, 2.5)
    count = int(random.integers(2, 6))
    steps = np.cumsum(random.normal(scale=0.25, size=(count, len(names))), axis=0)
    positions = np.clip(random.uniform(low, high) * 0.6 + steps, low, high)
    velocities = random.normal(scale=0.2, size=positions.shape) if seed % 2 else None
    obstacles = []
    for kind in random.choice(["box", "sphere", "cylinder"], 6):
        way = random.normal(size=3)
        place = (way / np.linalg.norm(way) * random.uniform(0.4, 1.2)).tolist()
        wxyz = random.normal(size=4).tolist()
        sizes = {
            "box": {"size": random.uniform(0.02, 0.3, 3).tolist(), "wxyz": wxyz},
            "sphere": {"radius": float(random.uniform(0.02, 0.15))},
            "cylinder": {"radius": 0.05, "height": 0.3, "wxyz": wxyz},
        }
        obstacles.append({"shape": kind, "position": place, **sizes[str(kind)]})
    times = np.arange(float(count))
    return Motion(tuple(names), times, positions, velocities), scene.replace(obstacles=obstacles)


@pytest.mark.parametrize("seed", of_each_kind(range(24), *range(6)))
def test_samples_agree_with_the_verdict(seed: int) -> None:
    motion, scene = random_task(seed)
    verdict = certify_motion(motion, scene)
    samples = np.linspace(0, len(motion.times) - 1, 1001)
    distance, _ = nearest(verdict.problem, samples)
    touches = partial(exact_contact.touches, verdict.problem)
    assert verdict.stretches[0].first == motion.times[0]
    assert verdict.stretches[-1].last == motion.times[-1]
    if verdict.state == "clear":
        assert verdict.clearance <= distance
        assert verify(verdict.to_dict())[0].proven
        return
    for one in verdict.touches:
        at = np.interp(one.first, motion.times, np.arange(len(motion.times)))
        assert touches(float(at) + 1e-7 * (one.first < motion.times[-1]), one.link, one.obstacle)
    if verdict.touches:
        first = next(one.first for one in verdict.stretches if one.state == "touches")
        assert first <= verdict.touches[0].first + 1e-9
    # what is called proven does not touch: at samples inside, the exact shapes are apart
    touched = {(one.link, one.obstacle) for one in verdict.touches}
    for stretch in verdict.stretches:
        if stretch.state == "clear":
            middle = np.interp(
                (stretch.first + stretch.last) / 2, motion.times, range(len(motion.times))
            )
            for link, other in touched:
                assert not touches(float(middle), link, other)


TWO_ARMS = """<robot name="two"><link name="base"/>{arms}</robot>"""
LINK = """<link name="{n}"><collision><origin xyz="0 0 0.1"/><geometry><box size="0.04 0.04 0.2"/>
</geometry></collision></link><joint name="j{n}" type="revolute"><parent link="{p}"/>
<child link="{n}"/><origin xyz="{x} 0 {z}"/><axis xyz="{a}"/>
<limit lower="-3" upper="3" velocity="2" effort="50"/></joint>"""


def two_arms() -> bytes:
    """Two arms of six joints on one base, half a metre from each other."""
    text = ""
    for side, x in (("l", -0.25), ("r", 0.25)):
        parent = "base"
        for k in range(6):
            axis = "0 1 0" if k % 2 else "1 0 0"
            name, first = f"{side}{k}", k == 0
            text += LINK.format(
                n=name, p=parent, x=x if first else 0, z=0 if first else 0.2, a=axis
            )
            parent = name
    return TWO_ARMS.format(arms=text).encode()


def test_two_arms_move_together_and_meet(tmp_path: object) -> None:
    from pathlib import Path

    file = Path(str(tmp_path)) / "two.urdf"
    file.write_bytes(two_arms())
    scene = robot_scene(file)
    names = joint_names(scene.arm.robot)
    assert len(names) == 12
    rest = np.zeros((2, 12))
    apart = certify_motion(Motion(names, np.array([0.0, 1.0]), rest), scene)
    assert apart.state == "clear"
    meeting = rest.copy()
    # both lean towards each other about the axis across: the second joints
    meeting[1, names.index("jl1")], meeting[1, names.index("jr1")] = 0.9, -0.9
    verdict = certify_motion(Motion(names, np.array([0.0, 1.0]), meeting), scene)
    assert verdict.state == "touches"
    one = verdict.touches[0]
    assert {one.link[0], str(one.obstacle)[0]} == {"l", "r"}
    assert 0 < one.first < 1
    only_one = meeting.copy()
    only_one[1, names.index("jr1")] = 0.9
    clear = certify_motion(Motion(names, np.array([0.0, 1.0]), only_one), scene)
    assert clear.state == "clear"
    assert verify(clear.to_dict(), Path(str(tmp_path)))[0].proven


@given(st.integers(0, 2**31))
def test_a_place_is_covered_where_any_stretch_contains_it(seed: int) -> None:
    random = np.random.default_rng(seed)
    stretches = np.sort(random.integers(0, 12, (int(random.integers(0, 9)), 2)), axis=1) / 2
    places = np.arange(-1, 13) / 2
    within = (stretches[:, 0] <= places[:, None]) & (places[:, None] <= stretches[:, 1])
    assert (_covered(places, stretches) == within.any(axis=1)).all()

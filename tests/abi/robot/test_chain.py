"""Chains against yourdfpy, finite differences and laws of motion."""

from __future__ import annotations

import io

import numpy as np
import pytest
import yourdfpy
from hypothesis import given, settings
from hypothesis import strategies as st

from abi import assets
from abi.arrays import FloatArray
from abi.errors import SceneError
from abi.obstacles.pose import UNTURNED, Quaternion, Vec3, rotation
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.chain_kernels import POSE, fill_jacobian
from abi.robot.urdf.held_joints import planned_joints
from abi.robot.urdf.robot_files import SHIPPED, load_robot, robot_from_archive
from tests.abi.robot.robots import OWN, follows, packed
from tests.kernel_forms import compiled, plain
from tests.random_robots import link_poses, random_robot

BASE: Vec3 = (0.1, -0.2, 0.3)
DOWN: Vec3 = (0.0, 0.0, -1.0)


def chain(name: str, axis: Vec3 | None = None) -> Chain:
    return Chain.of(load_robot(name, MeshSource()), SHIPPED[name], BASE, axis)


def test_a_turned_base_turns_all_of_the_chain() -> None:
    robot = load_robot("panda", MeshSource())
    wxyz: Quaternion = (0.1, -0.5, 0.7, 0.5)
    stands, hangs = (Chain.of(robot, SHIPPED["panda"], BASE, None, how) for how in (UNTURNED, wxyz))
    positions = random_positions(stands, 5)
    expected = stands.poses(positions)
    expected[..., 3] -= BASE
    expected = rotation(wxyz) @ expected
    expected[..., 3] += BASE
    np.testing.assert_allclose(hangs.poses(positions), expected, atol=1e-12)
    assert stands.frames == hangs.frames
    for link, frame in stands.frames.items():
        turned = np.array(stands.places[link])
        if frame < 0:
            turned[:3, :3] = rotation(wxyz) @ turned[:3, :3]
            turned[:3, 3] = rotation(wxyz) @ (turned[:3, 3] - BASE) + BASE
        np.testing.assert_allclose(hangs.places[link], turned, atol=1e-12)


def random_positions(one: Chain, count: int, seed: int = 0) -> FloatArray:
    random = np.random.default_rng(seed)
    return random.uniform(one.limits[:, 0], one.limits[:, 1], (count, len(one.names)))


@pytest.mark.parametrize("name", [*SHIPPED, *OWN])
def test_poses_are_the_same_compiled_and_by_numpy(name: str) -> None:
    if name in SHIPPED:
        one = chain(name)
    else:
        one = Chain.of(robot_from_archive(packed({"a.urdf": OWN[name]})), "d", BASE)
    positions = random_positions(one, 9)
    found = [form(lambda: one.packed_poses(positions)) for form in (plain, compiled)]
    assert found[0].tobytes() == found[1].tobytes()


def path(one: Chain, start: FloatArray, end: FloatArray) -> FloatArray:
    """A bent path between the tips of two poses near each other."""
    ends = one.poses(np.stack([start, end]))[:, -1, :, 3]
    share = np.linspace(0, 1, 101)[:, None]
    return np.asarray(ends[0] + share * (ends[1] - ends[0]) + 0.02 * np.sin(3 * share))


@pytest.mark.parametrize("name", [*SHIPPED, *OWN])
def test_every_link_is_where_yourdfpy_has_it(name: str) -> None:
    if name in SHIPPED:
        one = chain(name)
        robot = yourdfpy.URDF.load(str(assets.path("urdf", name, f"{name}.urdf")))
    else:
        one = Chain.of(robot_from_archive(packed({"a.urdf": OWN[name]})), "d", BASE)
        # yourdfpy takes a master that follows another for one that rests
        flat = OWN[name].replace(follows("q", -1.5, 0.3), follows("m", -0.75, 0.15))
        robot = yourdfpy.URDF.load(io.BytesIO(flat.encode()))
    positions = random_positions(one, 8)
    poses = one.poses(positions)
    for q, found in zip(positions, poses, strict=True):
        state = {**one.held, **dict(zip(one.names, q.tolist(), strict=True))}
        robot.update_cfg({name: state[name] for name in robot.actuated_joint_names})
        for link, number in one.frames.items():
            expected = robot.get_transform(link)[:3].copy()
            expected[:, 3] += BASE
            frame = one.places[link]
            if number >= 0:
                frame = np.vstack([found[number], [0, 0, 0, 1]]) @ frame
            np.testing.assert_allclose(frame[:3], expected, atol=1e-12)


@settings(max_examples=30)
@given(st.integers(0, 2**31))
def test_every_link_of_a_random_robot_is_where_its_file_says(seed: int) -> None:
    random = np.random.default_rng(seed)
    made = random_robot(random)
    robot = robot_from_archive(packed({"a.urdf": made.text}))
    moved = [joint.child for joint in robot.joints if joint.kind != "fixed"]
    for tip in random.choice(moved, min(3, len(moved)), replace=False).tolist():
        free = {
            joint.name for joint in robot.joints if joint.follows is None and joint.kind != "fixed"
        }
        planned = planned_joints(robot, tip)
        held = {
            joint.name: float(random.uniform(joint.low, joint.high))
            for joint in robot.joints
            if joint.name in free - {*planned} and random.random() < 0.7
        }
        one = Chain.of(robot, tip, BASE, None, UNTURNED, held)
        rest = {name: min(max(0.0, made.limits[name][0]), made.limits[name][1]) for name in free}
        for q in random_positions(one, 3, seed):
            state = {**rest, **held, **dict(zip(one.names, q.tolist(), strict=True))}
            poses = one.poses(q[None])[0]
            truth = link_poses(made, state)
            assert one.frames.keys() == truth.keys()
            for link, number in one.frames.items():
                frame, expected = one.places[link], truth[link]
                if number >= 0:
                    frame = np.vstack([poses[number], [0, 0, 0, 1]]) @ frame
                expected[:3, 3] += BASE
                np.testing.assert_allclose(frame, expected, atol=1e-9 * (1 + one.table.reach))


@pytest.mark.parametrize("name", [*SHIPPED, *OWN])
def test_the_jacobian_is_what_small_steps_do(name: str) -> None:
    if name in SHIPPED:
        one = chain(name, DOWN)
    else:
        one = Chain.of(robot_from_archive(packed({"a.urdf": OWN[name]})), "d", BASE, DOWN)
    count, step = len(one.names), 1e-6
    for q in random_positions(one, 5):
        poses = one.poses(q[None])[0]
        flat = np.concatenate([np.append(pose[:, :3].ravel(), pose[:, 3]) for pose in poses])
        assert len(flat) == POSE * len(poses)
        jacobian = np.empty(6 * count)
        fill_jacobian(one.table, flat, 6, count, jacobian)
        moved = one.poses(np.concatenate([q + step * np.eye(count), q - step * np.eye(count)]))
        ahead, behind = moved[:count, -1], moved[count:, -1]
        places = (ahead[:, :, 3] - behind[:, :, 3]) / (2 * step)
        axes = (ahead[:, :, 2] - behind[:, :, 2]) / (2 * step)
        rows = jacobian.reshape(6, count)
        np.testing.assert_allclose(rows[:3] * one.table.reach, places.T, atol=1e-8)
        # the axis moves by the turn crossed with it
        np.testing.assert_allclose(np.cross(rows[3:].T, poses[-1][:, 2]), axes, atol=1e-8)


@settings(max_examples=25)
@given(st.sampled_from([*SHIPPED]), st.integers(0, 2**31), st.booleans())
def test_the_tip_stays_on_a_path_that_can_be_followed(name: str, seed: int, aims: bool) -> None:
    one = chain(name, DOWN if aims else None)
    random = np.random.default_rng(seed)
    middle = one.limits.mean(axis=1)
    start = middle + random.uniform(-0.3, 0.3, len(middle)) * np.diff(one.limits)[:, 0]
    targets = path(one, start, start + random.uniform(-0.05, 0.05, len(middle)))
    first, error = one.follow(start, targets[:1])
    positions, errors = one.follow(first[0], targets)

    assert (positions >= one.limits[:, 0]).all()
    assert (positions <= one.limits[:, 1]).all()
    tips = one.poses(positions)[:, -1]
    missed = np.linalg.norm(tips[:, :, 3] - targets, axis=1) / one.table.reach
    sines = np.linalg.norm(np.cross(tips[:, :, 2], DOWN), axis=1)
    turned = np.arctan2(sines, tips[:, :, 2] @ np.array(DOWN)) if aims else 0 * missed
    # what is told of the errors is true, whether they vanish or not
    np.testing.assert_allclose(errors, np.maximum(missed, turned), atol=1e-12)
    if not aims:
        assert error[0] < 1e-9


@pytest.mark.parametrize("axis", [None, DOWN])
@pytest.mark.parametrize("name", SHIPPED)
def test_arms_follow_a_usual_path_smoothly(name: str, axis: Vec3 | None) -> None:
    one = chain(name, axis)
    share = np.linspace(0, 1, 201)[:, None]
    targets = np.array(BASE) + (0.4, -0.2, 0.25) + share * (-0.1, 0.4, 0.1)
    starts = np.random.default_rng(1).uniform(-1.5, 1.5, (20, len(one.names)))
    solved = (one.follow(start, targets[:1]) for start in starts)
    found = [one.follow(pose[0], targets) for pose, error in solved if error[0] < 1e-9]

    good = [positions for positions, errors in found if errors.max() < 1e-9]
    assert good
    smoothest = min(float(np.abs(np.diff(positions, 2, axis=0)).max()) for positions in good)
    assert smoothest < 1e-3


def test_following_is_the_same_compiled_and_plain() -> None:
    one = chain("panda", DOWN)
    start = np.array([0.1, 0.2, -0.1, -1.8, 0.1, 2.0, 0.3])
    targets = path(one, start, start + 0.1)[::10]
    first = plain(lambda: (one.follow(start, targets), one.poses(start[None])))
    second = compiled(lambda: (one.follow(start, targets), one.poses(start[None])))

    np.testing.assert_allclose(first[0][0], second[0][0], atol=1e-9)
    np.testing.assert_allclose(first[1], second[1], atol=1e-14)


@pytest.mark.parametrize("part", [1, 7, 250])
def test_following_by_parts_is_the_same(monkeypatch: pytest.MonkeyPatch, part: int) -> None:
    one = chain("panda")
    start = np.array([0.1, 0.2, -0.1, -1.8, 0.1, 2.0, 0.3])
    targets = path(one, start, start + 0.4)
    monkeypatch.setattr("abi.robot.kinematics.chain._PART", len(targets))
    at_once = one.follow(start, targets, home=start - 0.3)
    monkeypatch.setattr("abi.robot.kinematics.chain._PART", part)
    for found, expected in zip(one.follow(start, targets, home=start - 0.3), at_once, strict=True):
        np.testing.assert_array_equal(found, expected)


def test_a_tip_that_nothing_moves_is_refused() -> None:
    robot = load_robot("ur5e", MeshSource())

    for tip, expected in (("base_link", "that 1 to 16 joints move"), ("hand", "tool0")):
        with pytest.raises(SceneError, match=expected):
            Chain.of(robot, tip)

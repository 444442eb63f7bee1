"""Torques against Lagrange's equations, whose energies are differences of poses."""

from __future__ import annotations

import numpy as np
import pytest

from abi.arrays import FloatArray
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.inverse_dynamics import GRAVITY, has_masses, joint_torques
from abi.robot.urdf.robot_files import SHIPPED, load_robot, robot_from_archive
from tests.abi.robot.robots import OWN, arm, packed

STEP = 1e-5
MASSES = (
    '<inertial><origin xyz="0.1 -0.2 0.15" rpy="1 2 3"/><mass value="3"/>'
    '<inertia ixx="0.3" iyy="0.2" izz="0.4" ixy="0.02" ixz="-0.03" iyz="0.05"/></inertial></link>'
)


def chain(name: str) -> Chain:
    if name in SHIPPED:
        return Chain.of(load_robot(name, MeshSource()), SHIPPED[name], (0.1, -0.2, 0.3))
    text = OWN[name].replace("</link>", MASSES)
    return Chain.of(robot_from_archive(packed({"a.urdf": text})), "d")


def bodies(one: Chain, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Mass, centre, orientation and inertia of every moved link at one position, in the world."""
    poses = one.poses(q[None])[0]
    masses, centres, turns, inertias = [], [], [], []
    for name, frame in one.frames.items():
        link = one.robot.links[name]
        if frame >= 0:
            pose = np.vstack([poses[frame], [0, 0, 0, 1]]) @ one.places[name]
            masses.append(link.mass)
            centres.append(pose[:3, :3] @ link.centre + pose[:3, 3])
            turns.append(pose[:3, :3])
            inertias.append(pose[:3, :3] @ link.inertia @ pose[:3, :3].T)
    return np.array(masses), np.array(centres), np.array(turns), np.array(inertias)


def mass_matrix(one: Chain, q: FloatArray) -> FloatArray:
    masses, _, turns, inertias = bodies(one, q)
    steps = STEP * np.eye(len(q))
    moved = [(bodies(one, q + step), bodies(one, q - step)) for step in steps]
    linear = np.array([(a[1] - b[1]) / (2 * STEP) for a, b in moved])
    spin = np.array([(a[2] - b[2]) / (2 * STEP) @ turns.swapaxes(1, 2) for a, b in moved])
    angular = np.stack([spin[..., 2, 1], spin[..., 0, 2], spin[..., 1, 0]], axis=-1)
    return np.asarray(
        np.einsum("ibx,b,jbx->ij", linear, masses, linear)
        + np.einsum("ibx,bxy,jby->ij", angular, inertias, angular)
    )


def lagrange(one: Chain, q: FloatArray, speed: FloatArray, growth: FloatArray) -> FloatArray:
    """M q'' + (dM/dt q' - 1/2 d(q' M q')/dq) + dU/dq."""
    wide = 1e-4
    slopes = np.array(
        [
            (mass_matrix(one, q + step) - mass_matrix(one, q - step)) / (2 * wide)
            for step in wide * np.eye(len(q))
        ]
    )
    height = [(bodies(one, q + step), bodies(one, q - step)) for step in STEP * np.eye(len(q))]
    weight = [GRAVITY * a[0] @ (a[1] - b[1])[:, 2] / (2 * STEP) for a, b in height]
    turning = np.einsum("kij,k,j->i", slopes, speed, speed)
    turning -= np.einsum("ijk,j,k->i", slopes, speed, speed) / 2
    return np.asarray(mass_matrix(one, q) @ growth + turning + weight)


@pytest.mark.parametrize("name", [*SHIPPED, *OWN])
def test_torques_are_those_of_lagrange(name: str) -> None:
    one, random = chain(name), np.random.default_rng(1)
    low, high = np.clip(one.limits, -2, 2).T
    q = random.uniform(low, high, (3, len(low)))
    speed, growth = random.normal(size=(2, 3, len(low))) * 2
    found = joint_torques(one, q, speed, growth)

    assert has_masses(one)
    for k in range(3):
        expected = lagrange(one, q[k], speed[k], growth[k])
        np.testing.assert_allclose(found[k], expected, atol=2e-5 * np.abs(expected).max())


def test_power_is_what_the_energy_grows_by() -> None:
    """Along a motion the drives' power is the rate of kinetic and potential energy."""
    one = chain("panda")
    random, times = np.random.default_rng(4), np.linspace(0, 1, 2001)
    phase, size = random.uniform(0, 6, 7), random.uniform(0.2, 0.8, 7)
    angle = times[:, None] * 3 + phase
    q, speed, growth = size * np.sin(angle), 3 * size * np.cos(angle), -9 * size * np.sin(angle)
    power = np.einsum("kn,kn->k", joint_torques(one, q, speed, growth), speed)
    done = np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * times[1])])

    def energy(k: int) -> float:
        masses, centres, _, _ = bodies(one, q[k])
        motion = speed[k] @ mass_matrix(one, q[k]) @ speed[k] / 2
        return float(motion + GRAVITY * masses @ centres[:, 2])

    for k in (500, 1300, 2000):
        assert done[k] == pytest.approx(energy(k) - energy(0), abs=1e-4)


def test_without_masses_there_is_nothing_to_tell() -> None:
    one = Chain.of(robot_from_archive(packed({"a.urdf": arm()})), "d")
    assert not has_masses(one)

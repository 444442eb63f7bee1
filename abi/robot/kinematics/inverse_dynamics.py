"""Inverse dynamics: torques of an arm's joints along a motion, from its links' masses.

The recursive Newton-Euler equations: velocities and accelerations from the base to the tip, forces
back (Luh, Walker and Paul, On-line computational scheme for mechanical manipulators, 1980; in the
world's frame, Siciliano et al., Robotics, section 7.5).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abi import arguments
from abi.arrays import FloatArray
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.urdf_masses import Masses

GRAVITY = 9.80665
"""Standard gravity, downwards along z, [m/s²]."""


def has_masses(chain: Chain) -> bool:
    """Check whether the URDF gives a mass for any link that the chain moves."""
    links = chain.robot.links
    return any(links[link].mass > 0 for link, frame in chain.frames.items() if frame >= 0)


def joint_torques(
    chain: Chain, positions: FloatArray, speeds: FloatArray, accelerations: FloatArray
) -> FloatArray:
    """Torques that the drives must supply, without friction and without a load on the tool.

    Args:
        chain: the chain; its z axis is upright.
        positions: of the coordinates, shape (k, n), [rad] or [m].
        speeds: shape (k, n), [rad/s] or [m/s].
        accelerations: shape (k, n), [rad/s²] or [m/s²].

    Returns:
        Shape (k, n), [N·m], for sliding joints forces [N]; the torque of a joint that others mimic
        includes theirs.
    """
    positions = arguments.numbers("positions", positions, (-1, len(chain.names)))
    speeds = arguments.numbers("speeds", speeds, positions.shape)
    accelerations = arguments.numbers("accelerations", accelerations, positions.shape)
    table, bodies = chain.table, _bodies(chain)
    poses = chain.poses(positions)
    turns, origins = poses[..., :3], poses[..., 3]
    axes = np.einsum("kmij,mj->mki", turns[:, :-1], table.axes.reshape(-1, 3))
    rates = (speeds[:, table.source] * table.factor).T[..., None]
    growths = (accelerations[:, table.source] * table.factor).T[..., None]
    still = np.zeros((len(positions), 3))
    # of each frame its angular velocity and acceleration, [rad/s] and [rad/s²], and how its origin
    # is accelerated, [m/s²]: an arm at rest that is lifted feels what one that hangs does
    ground = still, still, np.full_like(still, (0.0, 0.0, GRAVITY))
    motions: list[tuple[FloatArray, FloatArray, FloatArray]] = []
    forces, moments = [], []
    for m, (mass, middle, tensor) in enumerate(bodies):
        before = int(table.before[m])
        omega, alpha, pull = motions[before] if before >= 0 else ground
        if before >= 0:
            pull = pull + _carried_along(omega, alpha, origins[:, m] - origins[:, before])
        rate, growth = axes[m] * rates[m], axes[m] * growths[m]
        if table.slides[m]:
            pull = pull + 2 * np.cross(omega, rate) + growth
        else:
            alpha = alpha + growth + np.cross(omega, rate)
            omega = omega + rate
        motions.append((omega, alpha, pull))
        turn = turns[:, m]
        centre = turn @ middle
        inertia = turn @ tensor @ turn.swapaxes(1, 2)
        force = mass * (pull + _carried_along(omega, alpha, centre))
        spin = _times(inertia, alpha) + np.cross(omega, _times(inertia, omega))
        forces.append(force)
        moments.append(spin + np.cross(centre, force))
    return _summed(chain, axes, origins, forces, moments)


def _carried_along(omega: FloatArray, alpha: FloatArray, lever: FloatArray) -> FloatArray:
    """Acceleration of the end of a lever (k, 3) beside its beginning, of one rigid body."""
    return np.cross(alpha, lever) + np.cross(omega, np.cross(omega, lever))


def _summed(
    chain: Chain,
    axes: FloatArray,
    origins: FloatArray,
    forces: Sequence[FloatArray],
    moments: Sequence[FloatArray],
) -> FloatArray:
    """Torques (k, n) from the forces and moments (k, 3) that each body needs, ends first."""
    table, count = chain.table, len(chain.names)
    torques = np.zeros((len(origins), count))
    forces, moments = list(forces), list(moments)
    for m in reversed(range(len(forces))):
        force, moment, before = forces[m], moments[m], int(table.before[m])
        own = np.einsum("ki,ki->k", force if table.slides[m] else moment, axes[m])
        torques[:, table.source[m]] += table.factor[m] * own
        if before >= 0:
            lever = origins[:, m] - origins[:, before]
            forces[before] = forces[before] + force
            moments[before] = moments[before] + moment + np.cross(lever, force)
    return torques


def joined(parts: Sequence[Masses]) -> Masses:
    """One body of several, all in the same frame."""
    masses = np.array([mass for mass, _, _ in parts])
    centres = np.array([centre for _, centre, _ in parts]).reshape(-1, 3)
    mass, inertia = float(masses.sum()), np.zeros((3, 3))
    centre = masses @ centres / mass if mass > 0 else np.zeros(3)
    for (of_part, _, own), offset in zip(parts, centres - centre, strict=True):
        inertia += own
        # Steiner's theorem: the part's mass about the common centre
        inertia += of_part * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return mass, centre, inertia


def _bodies(chain: Chain) -> list[Masses]:
    """Load of each joint, in its frame."""
    loads: list[list[Masses]] = [[] for _ in chain.joints]
    for name, frame in chain.frames.items():
        if frame >= 0:
            link, pose = chain.robot.links[name], chain.places[name]
            turn, origin = pose[:3, :3], pose[:3, 3]
            centre, inertia = turn @ link.centre + origin, turn @ link.inertia @ turn.T
            loads[frame].append((link.mass, centre, inertia))
    return [joined(load) for load in loads]


def _times(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Products of matrices (k, 3, 3) and vectors (k, 3)."""
    return np.asarray(np.einsum("kij,kj->ki", matrices, vectors))

"""Closed-form inverse kinematics of a SCARA arm: two parallel turning joints and a parallel slide.

The three come in any order. A joint behind them that turns about the tip does not move it, and
stays where it is nearest to 0. Both sides of the elbow are found.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from abi.arrays import FloatArray
from abi.robot.kinematics.chain import Chain

_PARALLEL = 1e-9
"""Largest sine of the angle between axes that count as parallel."""


def scara_positions(chain: Chain, point: FloatArray) -> list[FloatArray]:
    """Positions of a SCARA arm with its tip at a point, for both sides of its elbow.

    In the plane across the axes the tip is at o + R(p) (u + R(q) v), where p and q are the angles
    of the turning joints, u leads from the first to the second, and v from there to the tip.

    Args:
        chain: any chain.
        point: (3,), [m], world.

    Returns:
        Positions (n,); none for a chain that is no SCARA arm, or a point out of its reach.
    """
    count = chain.table.length
    joints = chain.joints[:count]
    if len(chain.names) != count or any(joint.follows is not None for joint in joints):
        return []
    frames = chain.poses(np.zeros((1, count)))[0]
    origins, tip = frames[:count, :, 3], frames[-1, :, 3]
    axes = np.stack([frame[:, :3] @ one.axis for frame, one in zip(frames, joints, strict=False)])
    axis = axes[0]
    if (np.linalg.norm(np.cross(axes, axis), axis=1) > _PARALLEL).any():
        return []
    across = np.cross(tip - origins, axis)
    reach = float(chain.table.reach)
    is_idle = ~np.array(chain.slides) & (np.linalg.norm(across, axis=1) <= _PARALLEL * reach)
    turning = np.flatnonzero(~np.array(chain.slides) & ~is_idle)
    sliding = np.flatnonzero(chain.slides)
    if len(turning) != 2 or len(sliding) != 1 or is_idle[: turning[1]].any():
        return []
    plane = _plane_across(axis)
    first, second = turning
    flat_origins, flat_tip, target = (_complex(plane @ at.T) for at in (origins, tip, point))
    upper, fore = flat_origins[second] - flat_origins[first], flat_tip - flat_origins[second]
    if abs(upper) <= _PARALLEL * reach:
        return []
    away = target - flat_origins[first]
    cosine = (abs(away) ** 2 - abs(upper) ** 2 - abs(fore) ** 2) / (2 * abs(upper) * abs(fore))
    if abs(cosine) > 1 or away == 0:
        return []
    low, high = chain.limits.T
    signs = axes @ axis
    found = []
    for angle in {math.acos(cosine), -math.acos(cosine)}:
        bend = angle - float(np.angle(fore / upper))
        turn = float(np.angle(away / (upper + fore * np.exp(1j * bend))))
        positions = np.where(is_idle, np.clip(0.0, low, high), 0.0)
        positions[first], positions[second] = signs[first] * turn, signs[second] * bend
        positions[sliding] = signs[sliding] * ((point - tip) @ axis)
        found.append(positions)
    return found


def _plane_across(axis: FloatArray) -> FloatArray:
    """Two unit vectors across an axis, (2, 3), that turn counter-clockwise about it."""
    least = np.eye(3)[np.abs(axis).argmin()]
    first = np.cross(axis, least)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)])


def _complex(flat: FloatArray) -> NDArray[np.complex128]:
    """Points of a plane, (2,) or (2, k), as complex numbers."""
    return np.asarray(flat[0] + 1j * flat[1])

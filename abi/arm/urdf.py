"""URDF text from solids, links and joints; masses and inertias follow from the solids.

The format: http://wiki.ros.org/urdf/XML. Lengths in [m], angles in [rad], masses in [kg].
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from abi.arrays import FloatArray

Triple = tuple[float, float, float]

DENSITY = 2700.0
"""Density of every solid, [kg/m³]: aluminium."""


@dataclass(frozen=True)
class Solid:
    """A box or a cylinder of a link.

    Attributes:
        shape: ``box`` with ``size`` = edge lengths, or ``cylinder`` with ``size`` = (radius,
            radius, height) and its axis along its own z, [m].
        material: name of its colour.
        xyz: centre in the link's frame, [m].
        rpy: roll, pitch and yaw in the link's frame, [rad].
        body: True when it has mass and can collide; False when it is trim, only drawn.
    """

    shape: Literal["box", "cylinder"]
    size: Triple
    material: str
    xyz: Triple = (0.0, 0.0, 0.0)
    rpy: Triple = (0.0, 0.0, 0.0)
    body: bool = True


@dataclass(frozen=True)
class Link:
    """A rigid body; one without solids is a frame."""

    name: str
    solids: tuple[Solid, ...] = ()


@dataclass(frozen=True)
class Joint:
    """What joins a link to its parent.

    Attributes:
        name: name of the joint.
        kind: type of the joint.
        parent: name of the link nearer to the root.
        child: name of the link that moves.
        xyz: the child's origin in the parent's frame at position 0, [m].
        axis: unit axis in the child's frame.
        limits: lowest and highest position, [rad] or [m].
        speed: largest speed, [rad/s] or [m/s].
        effort: largest torque or force, [N·m] or [N].
    """

    name: str
    kind: Literal["revolute", "prismatic", "fixed"]
    parent: str
    child: str
    xyz: Triple
    axis: Triple = (0.0, 0.0, 1.0)
    limits: tuple[float, float] = (0.0, 0.0)
    speed: float = 0.0
    effort: float = 0.0


def write(
    name: str,
    materials: Mapping[str, Triple],
    links: Iterable[Link],
    joints: Iterable[Joint],
    comment: str = "",
) -> str:
    """Write a robot as URDF text.

    Args:
        name: the robot's name.
        materials: red, green and blue from 0 to 1 of each colour the solids use.
        links: the bodies, in the order they are written.
        joints: what joins them.
        comment: text of an XML comment at the top.

    Returns:
        The text, ending in a newline; equal arguments give equal text.
    """
    lines = ['<?xml version="1.0" encoding="utf-8"?>']
    if comment:
        lines.append(f"<!-- {comment} -->")
    lines.append(f'<robot name="{name}">')
    for label, colour in materials.items():
        lines += [
            f'  <material name="{label}">',
            f'    <color rgba="{_numbers(colour)} 1"/>',
            "  </material>",
        ]
    for link in links:
        lines += _link(link)
    for joint in joints:
        lines += _joint(joint)
    return "\n".join([*lines, "</robot>", ""])


def inertia(solids: Iterable[Solid]) -> tuple[float, FloatArray, FloatArray]:
    """Mass, centre of mass and inertia of the bodies among ``solids``.

    Solids that overlap count twice where they do: the shape of a link is a picture, its masses
    are nominal.

    Args:
        solids: at least one with ``body``.

    Returns:
        Mass [kg], centre of mass shape (3,) [m] in the link's frame, inertia shape (3, 3) [kg·m²]
        about that centre along the link's axes; positive definite.
    """
    bodies = [solid for solid in solids if solid.body]
    masses = np.array([_mass(solid) for solid in bodies])
    centres = np.array([solid.xyz for solid in bodies])
    mass = masses.sum()
    centre = masses @ centres / mass
    total = np.zeros((3, 3))
    for solid, part, offset in zip(bodies, masses, centres - centre, strict=True):
        turn = _rotation(solid.rpy)
        total += turn @ np.diag(part * _squared_radii(solid)) @ turn.T
        # Steiner: the part's mass, seen from the common centre.
        total += part * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return float(mass), centre, total


def _mass(solid: Solid) -> float:
    x, y, z = solid.size
    return DENSITY * x * y * z * (1.0 if solid.shape == "box" else math.pi)


def _squared_radii(solid: Solid) -> FloatArray:
    """Squares of the radii of inertia about the solid's own axes, shape (3,), [m²]."""
    x, y, z = (edge * edge for edge in solid.size)
    if solid.shape == "box":
        return np.array([y + z, x + z, x + y]) / 12
    return np.array([3 * x + z, 3 * x + z, 6 * x]) / 12


def _rotation(rpy: Triple) -> FloatArray:
    """Rz(yaw)·Ry(pitch)·Rx(roll), URDF's order, shape (3, 3)."""
    (a, b, c), (u, v, w) = np.cos(rpy), np.sin(rpy)
    about_x = np.array([[1, 0, 0], [0, a, -u], [0, u, a]])
    about_y = np.array([[b, 0, v], [0, 1, 0], [-v, 0, b]])
    about_z = np.array([[c, -w, 0], [w, c, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


def _link(link: Link) -> list[str]:
    if not link.solids:
        return [f'  <link name="{link.name}"/>']
    mass, centre, tensor = inertia(link.solids)
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2)}
    tensor = np.where(np.abs(tensor) < 1e-12 * np.trace(tensor), 0.0, tensor)
    parts = " ".join(
        f'{key}="{_number(tensor[at])}"' for key, at in {**names, "izz": (2, 2)}.items()
    )
    lines = [
        f'  <link name="{link.name}">',
        "    <inertial>",
        f'      <origin xyz="{_numbers(centre)}"/>',
        f'      <mass value="{_number(mass)}"/>',
        f"      <inertia {parts}/>",
        "    </inertial>",
    ]
    for solid in link.solids:
        colour = f'<material name="{solid.material}"/>'
        lines += [f"    <visual>{_placed(solid)}{colour}</visual>"]
    for solid in link.solids:
        if solid.body:
            lines += [f"    <collision>{_placed(solid)}</collision>"]
    return [*lines, "  </link>"]


def _placed(solid: Solid) -> str:
    turned = f' rpy="{_numbers(solid.rpy)}"' if any(solid.rpy) else ""
    shape = (
        f'<box size="{_numbers(solid.size)}"/>'
        if solid.shape == "box"
        else f'<cylinder radius="{_number(solid.size[0])}" length="{_number(solid.size[2])}"/>'
    )
    return f'<origin xyz="{_numbers(solid.xyz)}"{turned}/><geometry>{shape}</geometry>'


def _joint(joint: Joint) -> list[str]:
    lines = [
        f'  <joint name="{joint.name}" type="{joint.kind}">',
        f'    <parent link="{joint.parent}"/>',
        f'    <child link="{joint.child}"/>',
        f'    <origin xyz="{_numbers(joint.xyz, 15)}"/>',
    ]
    if joint.kind != "fixed":
        low, high = joint.limits
        lines += [
            f'    <axis xyz="{_numbers(joint.axis)}"/>',
            f'    <limit lower="{_number(low, 12)}" upper="{_number(high, 12)}" '
            f'velocity="{_number(joint.speed)}" effort="{_number(joint.effort)}"/>',
        ]
    return [*lines, "  </joint>"]


def _number(value: float, digits: int = 6) -> str:
    # Adding zero turns -0 into 0.
    return f"{value + 0.0:.{digits}g}"


def _numbers(values: Iterable[float], digits: int = 6) -> str:
    """Numbers of one vector; what is only the rounding of a sine is 0, on every machine."""
    numbers = [float(value) for value in values]
    least = 1e-12 * max(map(abs, numbers))
    return " ".join(_number(n if abs(n) > least else 0.0, digits) for n in numbers)

"""Writer of URDF text from solids and joints; masses and inertias follow from the solids.

The format: http://wiki.ros.org/urdf/XML. Lengths in [m], angles in [rad], masses in [kg].
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

import numpy as np
from lxml import etree
from numpy.typing import ArrayLike

from abi.arrays import FloatArray
from abi.obstacles.pose import Vec3
from abi.robot.bodies.link_solid import LinkSolid, rotation_of
from abi.robot.kinematics.inverse_dynamics import joined
from abi.robot.urdf.urdf_masses import Masses

DENSITY = 2700.0
"""Density of every solid, [kg/m³]: aluminium."""

EFFORT = 1000.0
"""Largest torque or force of every joint, [N·m] or [N]."""

_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_NO_TURN = (0.0, 0.0, 0.0)


def write(
    name: str,
    materials: Mapping[str, Vec3],
    links: Mapping[str, Sequence[LinkSolid]],
    joints: Iterable[etree._Element],
    comment: str,
) -> str:
    """Write a robot as URDF text.

    Args:
        name: the robot's name.
        materials: red, green and blue from 0 to 1 of each colour the solids use.
        links: the solids of each body, in the order they are written; a body without is a frame.
        joints: the joints between them, made by :func:`joint`.
        comment: text of an XML comment at the top.

    Returns:
        The text, ending in a newline; equal arguments give equal text.
    """
    robot = etree.Element("robot", name=name)
    robot.extend(_link(link, solids) for link, solids in links.items())
    robot.extend(joints)
    for label, colour in materials.items():
        material = etree.SubElement(robot, "material", name=label)
        etree.SubElement(material, "color", rgba=_numbers((*colour, 1.0)))
    text = etree.tostring(robot, encoding="unicode", pretty_print=True)
    return f'<?xml version="1.0" encoding="utf-8"?>\n<!-- {comment} -->\n{text}'


def joint(
    name: str,
    kind: Literal["revolute", "prismatic", "fixed"],
    links: tuple[str, str],
    height: float,
    axis: Vec3 | None = None,
    limits: tuple[float, float] | None = None,
    speed: float = 0.0,
) -> etree._Element:
    """Joint between two links, as an XML element.

    Args:
        name: name of the joint.
        kind: its type.
        links: names of the parent and of the child.
        height: of the child's origin above the parent's at position 0, [m].
        axis: unit axis in the child's frame; None for a fixed joint.
        limits: lowest and highest position, [rad] or [m]; None for a fixed joint.
        speed: largest speed, [rad/s] or [m/s].
    """
    element = etree.Element("joint", name=name, type=kind)
    for tag, link in zip(("parent", "child"), links, strict=True):
        etree.SubElement(element, tag, link=link)
    _add_origin(element, (0.0, 0.0, height))
    if axis is not None:
        etree.SubElement(element, "axis", xyz=_numbers(axis))
    if limits is not None:
        named = {"effort": EFFORT, "velocity": speed, "lower": limits[0], "upper": limits[1]}
        etree.SubElement(element, "limit", {key: _numbers(one) for key, one in named.items()})
    return element


def inertia(solids: Iterable[LinkSolid]) -> Masses:
    """Mass, centre of mass and inertia of the bodies among ``solids``, in the link's frame.

    Where solids overlap, they count twice: the shape of a link is for drawing, its masses are
    nominal.

    Args:
        solids: at least one with ``body``.
    """
    parts = []
    for solid in solids:
        if solid.body:
            mass, rotation = _mass(solid), rotation_of(solid.rpy)
            own = rotation @ np.diag(mass * _squared_radii(solid)) @ rotation.T
            parts.append((mass, np.array(solid.xyz), own))
    return joined(parts)


def _mass(solid: LinkSolid) -> float:
    x, y, z = solid.size
    return DENSITY * x * y * z * (1.0 if solid.shape == "box" else math.pi)


def _squared_radii(solid: LinkSolid) -> FloatArray:
    """Squares of the radii of inertia about the solid's own axes, shape (3,), [m²]."""
    x, y, z = (edge * edge for edge in solid.size)
    if solid.shape == "box":
        return np.array([y + z, x + z, x + y]) / 12
    return np.array([3 * x + z, 3 * x + z, 6 * x]) / 12


def _link(name: str, solids: Sequence[LinkSolid]) -> etree._Element:
    link = etree.Element("link", name=name)
    if solids:
        _add_inertia(link, *inertia(solids))
    for solid in solids:
        _add_solid(etree.SubElement(link, "visual"), solid)
        etree.SubElement(link[-1], "material", name=solid.material)
    for solid in solids:
        if solid.body:
            _add_solid(etree.SubElement(link, "collision"), solid)
    return link


def _add_inertia(link: etree._Element, mass: float, centre: FloatArray, tensor: FloatArray) -> None:
    tensor = np.where(np.abs(tensor) < 1e-12 * np.trace(tensor), 0.0, tensor)
    inertial = etree.SubElement(link, "inertial")
    _add_origin(inertial, centre)
    etree.SubElement(inertial, "mass", value=_numbers(mass))
    values = map(_numbers, tensor[np.triu_indices(3)])
    etree.SubElement(inertial, "inertia", dict(zip(_INERTIA, values, strict=True)))


def _add_solid(part: etree._Element, solid: LinkSolid) -> None:
    geometry = etree.SubElement(part, "geometry")
    if solid.shape == "box":
        etree.SubElement(geometry, "box", size=_numbers(solid.size))
    else:
        radius, _, length = solid.size
        etree.SubElement(geometry, "cylinder", radius=_numbers(radius), length=_numbers(length))
    _add_origin(part, solid.xyz, solid.rpy)


def _add_origin(part: etree._Element, xyz: ArrayLike, rpy: Vec3 = _NO_TURN) -> None:
    etree.SubElement(part, "origin", xyz=_numbers(xyz), rpy=_numbers(rpy))


def _numbers(values: ArrayLike) -> str:
    """Text of a number or vector; the rounding error of a sine becomes 0, on every machine."""
    numbers = np.atleast_1d(np.asarray(values, dtype=float))
    large = np.where(np.abs(numbers) <= 1e-12 * np.abs(numbers).max(), 0.0, numbers)
    return " ".join(f"{number:.12g}" for number in large)

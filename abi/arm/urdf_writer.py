"""Writer of URDF text from solids and joints; masses and inertias follow from the solids.

The format: http://wiki.ros.org/urdf/XML. Lengths in [m], angles in [rad], masses in [kg].
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from yourdfpy import urdf as model

from abi.arm.inverse_dynamics import Body, joined
from abi.arm.link_solid import LinkSolid, rotation_of
from abi.arrays import FloatArray
from abi.obstacles.pose import Vec3

DENSITY = 2700.0
"""Density of every solid, [kg/m³]: aluminium."""

EFFORT = 1000.0
"""Largest torque or force of every joint, [N·m] or [N]."""

_TEXTS = {"name", "type", "link"}
"""Attributes that are not numbers."""


def write(
    name: str,
    materials: Mapping[str, Vec3],
    links: Mapping[str, Sequence[LinkSolid]],
    joints: Iterable[model.Joint],
    comment: str,
) -> str:
    """Write a robot as URDF text.

    Args:
        name: the robot's name.
        materials: red, green and blue from 0 to 1 of each colour the solids use.
        links: the solids of each body, in the order they are written; a body without is a frame.
        joints: the joints between them.
        comment: text of an XML comment at the top.

    Returns:
        The text, ending in a newline; equal arguments give equal text.
    """
    robot = model.Robot(
        name,
        links=[_link(link, solids) for link, solids in links.items()],
        joints=list(joints),
        materials=[
            model.Material(label, model.Color((*colour, 1.0)))
            for label, colour in materials.items()
        ],
    )
    tree = model.URDF(robot, build_scene_graph=False).write_xml()
    for element in tree.iter():
        for key in set(element.keys()) - _TEXTS:
            element.set(key, _rounded(element.get(key)))
    text = io.BytesIO()
    tree.write(text, encoding="utf-8", pretty_print=True)
    return f'<?xml version="1.0" encoding="utf-8"?>\n<!-- {comment} -->\n{text.getvalue().decode()}'


def joint(
    name: str,
    kind: Literal["revolute", "prismatic", "fixed"],
    links: tuple[str, str],
    height: float,
    axis: Vec3 | None = None,
    limits: tuple[float, float] | None = None,
    speed: float = 0.0,
) -> model.Joint:
    """Joint between two links.

    Args:
        name: name of the joint.
        kind: its type.
        links: names of the parent and of the child.
        height: of the child's origin above the parent's at position 0, [m].
        axis: unit axis in the child's frame; None for a fixed joint.
        limits: lowest and highest position, [rad] or [m]; None for a fixed joint.
        speed: largest speed, [rad/s] or [m/s].
    """
    limit = None if limits is None else model.Limit(EFFORT, speed, *limits)
    return model.Joint(name, kind, *links, _pose((0.0, 0.0, height)), axis, limit=limit)


def inertia(solids: Iterable[LinkSolid]) -> Body:
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
            parts.append(Body(mass, np.array(solid.xyz), own))
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


def _pose(xyz: ArrayLike, rpy: Vec3 = (0.0, 0.0, 0.0)) -> FloatArray:
    """Homogeneous matrix (4, 4)."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation_of(rpy), xyz
    return pose


def _link(name: str, solids: Sequence[LinkSolid]) -> model.Link:
    link = model.Link(name)
    if solids:
        mass, centre, tensor = inertia(solids)
        tensor[np.abs(tensor) < 1e-12 * np.trace(tensor)] = 0.0
        link.inertial = model.Inertial(_pose(centre), mass, tensor)
    for solid in solids:
        pose, (x, y, z) = _pose(solid.xyz, solid.rpy), solid.size
        if solid.shape == "box":
            geometry = model.Geometry(box=model.Box((x, y, z)))
        else:
            geometry = model.Geometry(cylinder=model.Cylinder(x, z))
        link.visuals.append(model.Visual(None, pose, geometry, model.Material(solid.material)))
        if solid.body:
            link.collisions.append(model.Collision(None, pose, geometry))
    return link


def _rounded(text: str) -> str:
    """Round the numbers of a vector; the rounding error of a sine becomes 0, on every machine."""
    numbers = np.array(text.split(), dtype=float)
    numbers[np.abs(numbers) <= 1e-12 * np.abs(numbers).max()] = 0.0
    return " ".join(f"{number:.12g}" for number in numbers)

"""Mesh files that a URDF names."""

from __future__ import annotations

import contextlib

from abi.errors import SceneError
from abi.robot.urdf.mesh_places import reference
from abi.robot.urdf.strict_xml import XmlElement, parse


def mesh_names(content: bytes, name: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Mesh files that a URDF names: those of collision shapes, and those of visuals only.

    Raises:
        SceneError: it is no URDF, or the mesh of a shape is outside the folder.
    """
    root = parse(content, name)
    needed: list[str] = []
    looks: list[str] = []
    for link in root.iterfind("link"):
        shape = "visual" if link.find("collision") is None else "collision"
        needed += [
            file_name(XmlElement(mesh, name, "mesh")) for mesh in link.iterfind(f"{shape}//mesh")
        ]
        for mesh in link.iterfind("visual//mesh"):
            with contextlib.suppress(SceneError):
                looks.append(file_name(XmlElement(mesh, name, "mesh")))
    return tuple(dict.fromkeys(needed)), tuple(k for k in dict.fromkeys(looks) if k not in needed)


def file_name(mesh: XmlElement) -> str:
    """Name of a mesh file in the upload, in the form of :func:`.mesh_places.reference`.

    Raises:
        SceneError: it leads outside.
    """
    text = mesh.text("filename")
    name = reference(text)
    if name is None:
        expected = "a file that comes with the URDF, as package://NAME/FILE or beside the URDF"
        raise mesh.refuse("mesh filename", text, expected)
    return name

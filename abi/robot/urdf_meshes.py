"""Mesh files that a URDF names."""

from __future__ import annotations

import contextlib
import re
from pathlib import PurePosixPath

from abi.errors import SceneError
from abi.robot.strict_xml import Element, parse


def mesh_names(content: bytes, name: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Mesh files that a URDF names: those of its shapes, and those only of visuals.

    Raises:
        SceneError: it is no URDF, or the mesh of a shape is outside the folder.
    """
    root = parse(content, name)
    needed: list[str] = []
    looks: list[str] = []
    for link in root.iterfind("link"):
        shape = "visual" if link.find("collision") is None else "collision"
        needed += [
            file_name(Element(mesh, name, "mesh")) for mesh in link.iterfind(f"{shape}//mesh")
        ]
        for mesh in link.iterfind("visual//mesh"):
            with contextlib.suppress(SceneError):
                looks.append(file_name(Element(mesh, name, "mesh")))
    return tuple(dict.fromkeys(needed)), tuple(k for k in dict.fromkeys(looks) if k not in needed)


def file_name(mesh: Element) -> str:
    """Path of a mesh file inside the upload, without its scheme.

    Raises:
        SceneError: it leads outside.
    """
    text = mesh.text("filename")
    path = re.sub(r"\Apackage://[^/]*/", "", text)
    parts = PurePosixPath(path).parts
    if not path or "://" in path or path.startswith("/") or ".." in parts or "\\" in path:
        raise mesh.refuse("mesh filename", text, "a file beside the URDF or below it")
    return path

"""A robot written as files: its URDF, alone or with the meshes that it names."""

from __future__ import annotations

import contextlib
from pathlib import PurePosixPath

from lxml import etree

from abi.errors import SceneError
from abi.robot.urdf.link_names import names_anew, rename_links
from abi.robot.urdf.mesh_lookup import MeshLookup
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import unpacked
from abi.robot.urdf.strict_xml import XmlElement, decoded, parse
from abi.robot.urdf.urdf_meshes import file_name


def description_of(robot: Robot) -> str:
    """Text of a robot's URDF as it was read, without links that are not part of the robot."""
    files = unpacked(robot.archive)
    path = _urdf_among(files)
    root = parse(files[path], PurePosixPath(path).name)
    renamed = names_anew(root)
    rename_links(root, renamed)
    if _drop_others(root, robot) or renamed:
        return str(etree.tostring(root, encoding="unicode"))
    return decoded(files[path])


def files_of(robot: Robot) -> dict[str, bytes]:
    """A robot's URDF, and what came with it, by paths as the URDF names them.

    It names a mesh where this is, without ``package://``: so other programs find it.
    """
    files = unpacked(robot.archive)
    path = _urdf_among(files)
    lookup = MeshLookup(files, PurePosixPath(path).parent)
    name = PurePosixPath(path).name
    root = parse(files.pop(path), name)
    if renamed := names_anew(root):
        rename_links(root, renamed)
        for other in [file for file in files if file.lower().endswith(".srdf")]:
            with contextlib.suppress(SceneError):  # one of several, which is not read
                srdf = parse(files[other], PurePosixPath(other).name)
                rename_links(srdf, renamed)
                files[other] = etree.tostring(srdf, xml_declaration=True, encoding="utf-8")
    _drop_others(root, robot)
    for mesh in root.iterfind("link//mesh"):
        with contextlib.suppress(SceneError):  # one for looks may be missing, as it was before
            mesh.set("filename", lookup.path(file_name(XmlElement(mesh, name, "mesh"))))
    return {name: etree.tostring(root, xml_declaration=True, encoding="utf-8"), **files}


def _urdf_among(files: dict[str, bytes]) -> str:
    (path,) = (name for name in files if name.lower().endswith(".urdf"))
    return path


def _drop_others(root: etree._Element, robot: Robot) -> bool:
    """Remove links and joints that are not part of a robot; whether there were any.

    Then all that is neither, such as transmissions, is dropped, too: it may name them.
    """
    kept = {"link": {*robot.links}, "joint": {joint.name for joint in robot.joints}}
    others = [one for one in root if one.get("name") not in kept.get(str(one.tag), ())]
    if not any(one.tag in kept for one in others):
        return False
    for one in others:
        if one.tag != "material":
            root.remove(one)
    return True

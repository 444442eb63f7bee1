"""Random robots in files as authors and programs write them: odd numbers, units, and archives.

What is changed changes no pose and no surface, so that what is read can be compared with both.
"""

from __future__ import annotations

import io
import struct
import zipfile
from dataclasses import dataclass

import numpy as np

from abi.arrays import FloatArray
from tests.random_robots import RandomRobot, random_robot

_PREFIXES = ("", "left/", "(1) ", "[a]", "机器人_", "λ:")
_HUGE = ("-1", "0", "2", "1e16", "1.7976931348623157e+308", "inf")
_UNUSED = (
    "",
    "<transmission><joint name='x'/></transmission>",
    "<gazebo reference='y'><kp>1e9</kp></gazebo>",
)
_INERTIAL = (
    "",
    "<inertial><mass value='1'/></inertial>",
    "<inertial><mass value='1'/><inertia ixx='-5e-20' iyy='1' izz='1'/></inertial>",
    "<inertial><mass value='nan'/><inertia ixx='nan' iyy='1' izz='1'/></inertial>",
)
_BOX = '<box size="0.05 0.06 0.2"/>'
_HALF = np.array([0.025, 0.03, 0.1])
_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * _HALF
_FACES = (
    *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
    *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
)
CORNERS = _CORNERS + np.array([0.0, 0.0, 0.1])
"""Corners (8, 3) of every link's box in its frame, whatever the file calls it, [m]."""


@dataclass(frozen=True)
class RobotFile:
    """A robot's file: its name, its content, and the robot that is written in it."""

    name: str
    content: bytes
    robot: RandomRobot


def random_file(random: np.random.Generator) -> RobotFile:
    """A robot as a ``.urdf`` or a ``.zip``."""
    robot = random_robot(random, str(random.choice(_PREFIXES)))
    text = _oddly(robot, random)
    if random.random() < 0.2:
        return RobotFile("r.urdf", _encoded(text, random), robot)
    folder = str(random.choice(["", "pkg/", "pkg/urdf/", "a/pkg/robots/"]))
    top = folder.partition("pkg/")[0] + ("pkg/" if "pkg/" in folder else "")
    mesh, reference, files = "part.stl", "", {}
    unit = float(random.choice([1.0, 0.001, 0.01]))
    scale = "" if unit == 1 else f' scale="{unit!r} {unit!r} {unit!r}"'
    where = str(random.choice(["meshes/collision/", "meshes/", ""]))
    if folder.endswith(("urdf/", "robots/")) and random.random() < 0.5:
        reference = f"../{where}{mesh}"
    else:
        reference = f"package://pkg/{where}{mesh}"
    files[f"{top}{where}{mesh}"] = _stl(_CORNERS / unit)
    if where and random.random() < 0.5:
        files[f"{top}meshes/visual/{mesh}"] = _stl(_CORNERS / unit * 0.5)
    count = int(random.integers(1, text.count(_BOX) + 1))
    text = text.replace(_BOX, f'<mesh filename="{reference}"{scale}/>', count)
    files[f"{folder}r.urdf"] = _encoded(text, random)
    return RobotFile("r.zip", _zipped(files, random), robot)


def _oddly(robot: RandomRobot, random: np.random.Generator) -> str:
    """The text with numbers that planning does not need, and ways to write those that it does."""
    text = robot.text
    for joint in robot.joints:
        own = joint.text()
        odd = own.replace('velocity="2"', f'velocity="{random.choice(_HUGE)}"')
        odd = odd.replace('effort="9"', f'effort="{random.choice(_HUGE)}"')
        if joint.kind == "fixed":
            at = odd.index("<axis")
            odd = odd[:at] + str(random.choice(["", '<axis xyz="0 0 0"/>'])) + "</joint>"
        if random.random() < 0.3:
            place = own.partition('xyz="')[2].partition('"')[0]
            odd = odd.replace(place, place.replace(" ", ", "), 1)
        if random.random() < 0.2:
            odd = odd.replace(
                "</joint>", "<calibration rising='0'/><dynamics damping='1'/></joint>"
            )
        text = text.replace(own, odd)
    for _ in range(2):
        text = text.replace("</link>", f"{random.choice(_INERTIAL)} </link>", 1)
    return text.replace("</robot>", f"{random.choice(_UNUSED)}</robot>")


def _encoded(text: str, random: np.random.Generator) -> bytes:
    how = int(random.integers(5))
    if how == 0:
        return text.encode("utf-16")
    if how == 1:
        return text.encode("utf-8-sig")
    if how == 2:
        return text.encode() + b"\r\n\0"
    if how == 3:
        return f"\n\n{text}".replace("><", ">\r\n<").encode()
    return f'<?xml version="1.0" encoding="latin-1"?>{text}'.encode()


def _zipped(files: dict[str, bytes], random: np.random.Generator) -> bytes:
    """The files as a file manager packs them."""
    how = str(random.choice(["plain", "mac", "windows", "case"]))
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        if how == "mac":
            archive.writestr(".DS_Store", b"Bud1")
        for name, data in files.items():
            folder, _, last = name.rpartition("/")
            if how == "mac":
                archive.writestr(f"__MACOSX/{folder}/._{last}", b"\0\5\x16\7")
            if how == "windows":
                name = name.replace("/", "\\")
            if how == "case" and last.endswith(".stl"):
                name = f"{folder}/{last.upper()}" if folder else last.upper()
            archive.writestr(name, data)
    return content.getvalue()


def _stl(corners: FloatArray) -> bytes:
    rows = np.asarray(corners, dtype="<f4")[np.array(_FACES)]
    body = b"".join(bytes(12) + row.tobytes() + bytes(2) for row in rows)
    return bytes(80) + struct.pack("<I", len(rows)) + body

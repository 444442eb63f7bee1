"""Work of the reader process: bytes of a file in, checked data out.

Only plain data with a schema passes between the processes, so that nothing in a file can make the
server run code.
"""

from __future__ import annotations

import json
from typing import Any, Literal

import msgspec

from abi.certification.read_motion import read_motion
from abi.errors import AbiError, SceneError
from abi.obstacles.triangle_mesh import mesh_reader
from abi.obstacles.triangle_mesh.mesh_source import Files, MeshSource
from abi.obstacles.triangle_mesh.surface import Surface
from abi.robot.bodies.link_bodies import link_bodies
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import file_of, load_plain_robot, robots_in
from abi.scene import scene_archive
from abi.scene.scene_archive import named_meshes
from abi.scene.scene_file import parse_bytes
from app.reading import sample_bag, sample_meshes
from app.reading.messages import encode

Kind = Literal["mesh", "arm", "scene", "motion"]


class ReadingRequest(msgspec.Struct):
    """A file to read.

    Attributes:
        kind: what it is to be.
        name: its name; the ending tells the format.
        content: its bytes.
        slides: joints of the robot of a motion, and whether each slides.
        topic: of a motion in a bag.
    """

    kind: Kind
    name: str
    content: bytes
    slides: dict[str, bool] = {}
    topic: str | None = None


class ReadingResult(msgspec.Struct):
    """Outcome of reading a file.

    Attributes:
        refusal: field, value and what was expected of a :class:`SceneError`; None without one.
        wrong: what else is wrong, and what would work; None where nothing is.
        fault: name of an error that no reader should have raised; empty otherwise.
        data: plain data of a scene or a motion, as JSON.
        surfaces: repaired meshes, by their names.
        robots: arms, by their names.
        choices: URDF files of an archive with several, or trajectories of a bag, of which one is to
            be named.
    """

    refusal: tuple[str, Any, str] | None = None
    wrong: tuple[str, str] | None = None
    fault: str = ""
    data: bytes = b""
    surfaces: dict[str, Surface] = {}
    robots: dict[str, Robot] = {}
    choices: tuple[str, ...] = ()


def read(request: ReadingRequest) -> ReadingResult:
    """Read a file; faults are part of the answer."""
    try:
        if request.kind == "motion":
            return _motion(request)
        return _READERS[request.kind](request.name, request.content)
    except SceneError as error:
        return ReadingResult(_refusal(error))
    except AbiError as error:
        return ReadingResult(wrong=_words(error), choices=tuple(map(_plain, error.choices)))
    except MemoryError:
        return ReadingResult(("file", request.name, "one that takes less memory to read"))
    except Exception as error:  # it stays in this process
        refusal = "file", request.name, "a file that can be read"
        return ReadingResult(refusal, fault=f"{type(error).__name__}: {error}"[:300])
    finally:
        link_bodies.cache_clear()


_ROBOT = b"""<robot name="a"><link name="b"/><link name="c"><collision><geometry>
<box size="1 1 1"/></geometry></collision></link><joint name="j" type="revolute"><parent link="b"/>
<child link="c"/><limit lower="0" upper="1" velocity="1" effort="1"/></joint></robot>"""
"""A robot with a shape, to load the code that makes bodies before file access is forbidden."""


def rehearse() -> None:
    """Read a file of every kind, complete and truncated, so that no code is left to load."""
    import trimesh

    box, other = trimesh.creation.box(), trimesh.creation.box()
    other.apply_translation((0.5, 0.5, 0.5))
    pair: Any = trimesh.util.concatenate([box, other])
    files = [
        ReadingRequest("scene", f"a.{ending}", b'{"version": 1}') for ending in ("json", "yaml")
    ]
    files += [ReadingRequest("arm", "a.urdf", _ROBOT)]
    own = {".dae": sample_meshes.dae, ".3mf": sample_meshes.threemf}
    for suffix in mesh_reader.SUFFIXES:
        content = own[suffix]() if suffix in own else pair.export(file_type=suffix[1:])
        mesh = content if isinstance(content, bytes) else content.encode()
        files += [
            ReadingRequest("mesh", f"a{suffix}", mesh),
            ReadingRequest("mesh", f"a{suffix}", mesh[:200]),
        ]
    for kind, name in (("scene", "a.zip"), ("arm", "a.zip")):
        files.append(ReadingRequest(kind, name, b"PK\x03\x04"))  # type: ignore[arg-type]
    for name, motion in (("a.csv", b"time,a\n0,0\n1,1\n"), ("a.mcap", sample_bag.mcap("a"))):
        files.append(ReadingRequest("motion", name, motion, {"a": False}))
    for request in files:
        encode(read(request))


def _mesh(name: str, content: bytes) -> ReadingResult:
    surface = mesh_reader.read_surface(content, name)
    return ReadingResult(surfaces={name: surface})


def _arm(name: str, content: bytes) -> ReadingResult:
    if file_of(name) == name and len(choices := robots_in(content)) > 1:
        raise AbiError(
            f"The archive has {len(choices)} robots.", "Name the URDF file of one.", choices
        )
    return ReadingResult(robots={name: _whole(name, {file_of(name): content})})


def _scene(name: str, content: bytes) -> ReadingResult:
    files: dict[str, bytes | Surface] = {}
    if name.lower().endswith(scene_archive.SUFFIX):
        data, files = scene_archive.unpack(content, name)
    else:
        data = parse_bytes(content, name)
    try:
        text = json.dumps(data, default=str)
    except (TypeError, ValueError):  # a key that is a list, a number of thousands of digits
        raise SceneError("scene", name, "plain numbers, lists and mappings") from None
    answer = ReadingResult(data=text.encode())
    meshes, arms = named_files(data)
    srdf = _srdf_of(data)
    for file in meshes & files.keys():
        found = files[file]
        if isinstance(found, Surface):
            answer.surfaces[file] = found
        else:
            assert isinstance(found, bytes)
            answer.surfaces[file] = mesh_reader.read_surface(found, file)
    for arm in arms:
        if arm in files or file_of(arm) in files:
            answer.robots[arm] = _whole(arm, files, srdf)
    return answer


def _motion(request: ReadingRequest) -> ReadingResult:
    motion = read_motion(request.name, request.content, request.slides, request.topic)
    data = {**motion.to_dict(), "notes": motion.notes, "start": motion.start}
    return ReadingResult(data=json.dumps(data).encode())


def _srdf_of(data: object) -> str | None:
    """Name of the SRDF in a scene that is not validated yet."""
    arm = data.get("arm") if isinstance(data, dict) else None
    name = arm.get("srdf") if isinstance(arm, dict) else None
    return name if isinstance(name, str) else None


def named_files(data: object) -> tuple[set[str], set[str]]:
    """Names of the mesh and arm files in a scene that is not validated yet."""
    arm = data.get("arm") if isinstance(data, dict) else None
    arms = [arm.get("urdf")] if isinstance(arm, dict) and arm.get("model") == "urdf" else []
    return named_meshes(data), {name for name in arms if isinstance(name, str)}


def _whole(name: str, files: Files, srdf: str | None = None) -> Robot:
    """Check an arm by fitting the bodies of its links, as planning does.

    Its archive has only meshes in formats of our own readers: a server that is started again reads
    it from its store.
    """
    robot = load_plain_robot(name, MeshSource(files), srdf)
    for link in robot.links.values():
        link_bodies(link)
    return robot


def _refusal(error: SceneError) -> tuple[str, Any, str]:
    """Convert an error to plain data that the schema can carry."""
    value = error.value
    try:
        msgspec.msgpack.encode(value)
    except (TypeError, ValueError, OverflowError):
        value = repr(value)[:200]
    return _plain(error.field), value, _plain(error.expected)


def _words(error: AbiError) -> tuple[str, str]:
    """Message and hint of an error, as plain text."""
    return _plain(error.message), _plain(error.hint)


def _plain(text: str) -> str:
    """Remove unpaired surrogates, which cannot be encoded."""
    return text.encode(errors="replace").decode()


_READERS = {"mesh": _mesh, "arm": _arm, "scene": _scene}

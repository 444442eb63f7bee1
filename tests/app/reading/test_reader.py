"""Files from outside are read in a process that can be lost without harm."""

from __future__ import annotations

import atexit
import json
import re
import resource
import signal
import sys
import threading
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from abi.certification.motion import RobotState
from abi.certification.read_motion import read_motion
from abi.certification.stated_object import StatedObject
from abi.errors import ArgumentError, SceneError
from abi.obstacles.triangle_mesh.mesh_reader import SUFFIXES, read_surface
from abi.obstacles.triangle_mesh.surface import Surface
from abi.progress import CancelledError
from abi.robot.urdf import robot_files
from abi.robot.urdf.robot_files import robot_from_archive
from abi.scene.scene import Scene
from app.reading import messages, running_reader
from app.reading import reader as module
from app.reading.reader import Reader
from app.reading.reading import ReadingRequest, ReadingResult
from app.reading.running_reader import AT_ONCE, reading_memory
from tests.abi import meshes
from tests.abi.robot.robots import arm, packed
from tests.abi.robot.test_robot_files import HOSTILE
from tests.abi.robot.test_visuals import ENTITY, dae, looking
from tests.app.fake_tab import until


@pytest.fixture(scope="module")
def reader() -> Iterator[Reader]:
    reader = Reader()
    yield reader
    reader.close()


def file_of(suffix: str) -> bytes:
    ball = trimesh.creation.icosphere(subdivisions=2)
    content = ball.export(file_type=suffix[1:])
    return content if isinstance(content, bytes) else str(content).encode()


@pytest.mark.slow
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_mesh_is_the_one_that_is_read_here(reader: Reader, suffix: str) -> None:
    content, name = file_of(suffix), f"ball{suffix}"
    surface, wanted = reader.mesh(content, name), read_surface(content, name)
    assert surface == wanted
    assert surface.notes == wanted.notes


def test_a_motion_is_the_one_that_is_read_here(reader: Reader) -> None:
    state = {"joint_state": {"name": ["b"], "position": [0.5]}}
    solid = {"type": 1, "dimensions": [1, 2, 3]}
    held = {
        "attached_collision_objects": [
            {"link_name": "l", "object": {"id": "rod", "primitives": [solid]}},
            {"object": {"id": "other"}},
        ]
    }
    points = [{"positions": [k], "time_from_start": 1 + k} for k in range(2)]
    trajectory = [{"joint_names": ["a"], "points": points}]
    content = json.dumps({"trajectory": trajectory, "trajectory_start": state | held}).encode()
    slides = {"a": False, "b": True}
    found = reader.motion(content, "a.json", slides)
    wanted = read_motion("a.json", content, slides)
    assert found.to_dict() == wanted.to_dict()
    assert (found.notes, found.start) == (wanted.notes, wanted.start)
    box = "box", (1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    objects = StatedObject("rod", "l", box), StatedObject("other", "", None)
    assert wanted.start == RobotState({"b": 0.5}, objects)
    alone = json.dumps(trajectory[0]).encode()
    assert reader.motion(alone, "a.json", slides).start.objects is None
    arm = {"base": [1, 2, 3], "base_link": "l", "gripper": {"b": 5}, "attached": {"shape": "box"}}
    motion = {"joints": ["a"], "time": [0, 1], "positions": [[0], [1]]}
    plan = json.dumps({"scene": {"unit": "cm", "arm": arm}, "arm": motion}).encode()
    stated = reader.motion(plan, "a.json", slides).start
    assert stated == read_motion("a.json", plan, slides).start
    assert stated.base == pytest.approx((0.01, 0.02, 0.03, 0, 0, 0, 1))
    assert (stated.joints, stated.root, stated.rests) == ({"b": 0.05}, "l", True)
    assert stated.attached == ("cm", {"shape": "box"})


def test_a_process_that_was_started_before_reads_the_first_file() -> None:
    reader = Reader()
    reader.warm()
    (process,) = reader._idle
    reader.warm()
    assert reader._idle == [process]
    content = meshes.stl(meshes.box())
    assert len(reader.mesh(content, "a.stl").faces) == 12
    assert reader._idle == [process]
    reader.close()

    reader.warm()  # one that is not wanted after all is not waited for
    (process,) = reader._idle
    reader.close()
    assert process.returncode == -signal.SIGKILL
    assert reader.lost == []


def test_a_scene_comes_with_its_meshes_and_its_arm(reader: Reader) -> None:
    files = {"a.stl": meshes.stl(meshes.bumpy(2)), "own.zip": packed({"x.urdf": arm()})}
    data = {
        "version": 1,
        "obstacles": [{"shape": "mesh", "file": "a.stl", "position": [3, 3, 3]}],
        "arm": {"model": "urdf", "urdf": "own.zip"},
    }
    scene = Scene.from_dict(data, files)
    again = Scene.from_dict(*reader.scene(scene.pack(), "scene.zip"))

    assert again.arm.robot == scene.arm.robot
    surface, other = (
        one.meshes.surface(file) for one, file in ((scene, "a.stl"), (again, "a.stl"))
    )
    np.testing.assert_array_equal(surface.vertices, other.vertices)
    assert reader.arm(arm().encode(), "plain.urdf").links.keys() == scene.arm.robot.links.keys()


def test_an_arm_comes_without_the_dae_that_it_is_drawn_with(reader: Reader) -> None:
    files: dict[str, str | bytes] = {"a.urdf": looking("a.dae"), "a.dae": dae(0.3)}
    robot = reader.arm(packed(files), "a.zip")

    assert [len(shape.faces) for shape in robot.links["a"].drawn] == [320]
    assert b".dae.plain.stl" in robot.archive
    files["a.dae"] = ENTITY
    assert "cannot be read: a." in reader.arm(packed(files), "a.zip").notes[0]
    assert not reader.lost
    assert not reader.faults


def test_a_robot_is_that_of_its_archive_and_is_not_read_again(
    reader: Reader, monkeypatch: pytest.MonkeyPatch
) -> None:
    ball = '<mesh filename="solid.dae" scale="1 1.1 0.7"/>'
    text = looking("a.dae", text=arm(('<box size="0.1 0.1 0.3"/>', ball)))
    srdf = '<robot name="r"><disable_collisions link1="b" link2="d"/></robot>'
    one, other = dae(0.1), dae(0.3)
    files: dict[str, str | bytes] = {"a.urdf": text, "a.dae": one, "solid.dae": other}
    robot = reader.arm(packed({**files, "a.srdf": srdf, "b.srdf": srdf}), "a.zip")
    kept = robot_from_archive(robot.archive)

    assert robot == kept
    assert (robot.notes, robot.may_touch) == (kept.notes, kept.may_touch)
    pairs = list(zip(_arrays(robot), _arrays(kept), strict=True))
    assert len(pairs) > 30
    for found, wanted in pairs:
        np.testing.assert_array_equal(found, wanted, strict=True)
        assert not found.flags.writeable

    monkeypatch.setattr(robot_files, "_read", None)
    data = {"version": 1, "arm": {"model": "urdf", "urdf": "a.zip", "base_link": "b"}}
    scene = Scene.from_dict(data, {"a.zip": robot}).replace(arm={"base": (1.0, 0.0, 0.0)})
    assert scene.arm.whole_robot is robot
    assert scene.meshes.files == {"a.zip": robot}


def _arrays(value: object) -> Iterator[np.ndarray[Any, Any]]:
    """All arrays in a robot, in order."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, Mapping):
        yield from _arrays([*value.values()])
    elif isinstance(value, list | tuple):
        for one in value:
            yield from _arrays(one)
    elif is_dataclass(value):
        yield from _arrays([getattr(value, one.name) for one in fields(value)])


def test_a_message_is_checked_by_the_class_that_it_is_of() -> None:
    mesh = read_surface(meshes.stl(meshes.box()), "a.stl")
    content = messages.encode({**vars(mesh), "faces": mesh.faces[:, :2].copy()})
    with pytest.raises(ArgumentError, match="faces"):
        messages.decode(content, Surface)
    assert messages.decode(messages.encode(mesh), Surface) == mesh


@pytest.mark.slow
def test_a_dae_whose_parts_double_again_and_again_is_refused(reader: Reader) -> None:
    nodes = "".join(
        f'<node id="n{k}">' + f'<instance_node url="#n{k - 1}"/>' * 2 + "</node>"
        for k in range(1, 40)
    )
    first = dae(0.1).decode().replace('<node id="node0"', '<node id="n0"', 1)
    bomb = re.sub(r"(?s)(<visual_scene [^>]*>)(.*?)(</visual_scene>)", rf"\1\2{nodes}\3", first)
    assert bomb.count("<instance_node") == 78
    with pytest.raises(SceneError, match="at most 500,000 triangles"):
        reader.mesh(bomb.encode(), "a.dae")
    arm = reader.arm(packed({"a.urdf": looking("a.dae"), "a.dae": bomb}), "a.zip")
    assert "cannot be read: a." in arm.notes[0]
    assert not reader.lost


@pytest.mark.parametrize("name", HOSTILE)
def test_a_refusal_is_the_sentence_that_it_is_here(reader: Reader, name: str) -> None:
    content = packed({"r.urdf": HOSTILE[name]})
    with pytest.raises(SceneError) as here:
        robot_from_archive(content)
    with pytest.raises(SceneError) as there:
        reader.arm(content, "r.zip")

    assert there.value.field == here.value.field
    assert there.value.expected == here.value.expected
    assert not reader.lost
    assert not reader.faults


@pytest.mark.parametrize("name", ["a.urdf", "scene.yaml"])
def test_a_file_without_a_name_in_an_archive_is_passed_over(reader: Reader, name: str) -> None:
    text = arm() if name == "a.urdf" else "version: 1"
    content = packed({name: text, "x.txt": "nothing"}).replace(b"x.txt", b"\0.txt")
    if name == "a.urdf":
        assert reader.arm(content, "a.zip").links
    else:
        assert reader.scene(content, "a.zip") == ({"version": 1}, {})
    assert not reader.faults


def test_half_a_letter_and_a_huge_number_are_refused(reader: Reader) -> None:
    for content in (b'{"\\ud800": 1, "\\ud800": 2}', b"[" * 900 + b"]" * 900):
        with pytest.raises(SceneError):
            reader.scene(content, "a.json")
    for content in (b"a: 0x" + b"f" * 9999, b"? [1, 2]\n: 3"):
        with pytest.raises(SceneError):
            reader.scene(content, "a.yaml")
    assert not reader.lost
    assert not reader.faults


@pytest.mark.slow
@pytest.mark.parametrize(("seconds", "patience"), [(0, 90.0), (20, 0.0)], ids=["cpu", "time"])
def test_a_file_that_takes_too_long_is_refused_and_the_next_is_read(
    seconds: int, patience: float
) -> None:
    reader = Reader(seconds=seconds, patience=patience)
    many = trimesh.creation.icosphere(subdivisions=7)  # over a second, the least limit there is
    with pytest.raises(SceneError, match="less time"):
        reader.mesh(meshes.stl((many.vertices, many.faces)), "many.stl")
    assert len(reader.lost) == 1
    assert reader.lost[0] < 0

    reader.seconds, reader.patience = 20, 90.0
    assert len(reader.mesh(file_of(".stl"), "a.stl").faces) == 320
    reader.close()


@pytest.mark.slow
def test_too_much_memory_is_refused_and_the_next_file_is_read() -> None:
    reader = Reader(memory=60_000_000)
    many = trimesh.creation.icosphere(subdivisions=7)
    with pytest.raises(SceneError, match="memory"):
        reader.mesh(meshes.stl((many.vertices, many.faces)), "many.stl")
    assert len(reader.mesh(file_of(".stl"), "a.stl").faces) == 320
    reader.close()


def test_what_is_not_wanted_any_more_is_not_waited_for(reader: Reader) -> None:
    stopped = threading.Event()
    stopped.set()
    with pytest.raises(CancelledError):
        reader.mesh(file_of(".stl"), "a.stl", stopped)


class Held:
    """A process that reads each file for as long as it is not let go."""

    def __init__(self, *_: object) -> None:
        pass

    def read(self, job: ReadingRequest) -> ReadingResult:
        BEGUN.append(job.name)
        until(lambda: job.name in LET_GO)
        return ReadingResult(data=b"{}")

    def kill(self) -> None:
        LET_GO.update(BEGUN)


BEGUN: list[str] = []
LET_GO: set[str] = set()


@pytest.fixture
def held(monkeypatch: pytest.MonkeyPatch) -> Iterator[Reader]:
    """A reader whose files are read until their names are let go, or the test ends."""
    monkeypatch.setattr(running_reader, "started", Held)
    monkeypatch.setattr(running_reader, "answer_of", Held.read)
    monkeypatch.setattr(running_reader, "closed", lambda _: 0)
    monkeypatch.setattr(module, "_LONG", 0.05)
    BEGUN.clear()
    LET_GO.clear()
    reader = Reader()
    atexit.unregister(reader.close)  # it has no process to end
    yield reader
    LET_GO.update(BEGUN, "abcd", (f"{owner}{k}" for owner in "ab" for k in range(9)))


def begin(reader: Reader, *names: str) -> threading.Thread:
    """Read files one after the other in a thread of its own, as a tab does."""

    def read() -> None:
        for name in names:
            reader.scene(b"", name)

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    return thread


@pytest.mark.timeout(20)
def test_who_comes_later_waits_for_one_more_file_of_each_at_most(held: Reader) -> None:
    """With ``AT_ONCE`` files read at a time, in the order in which they came."""
    threads = []
    for owner in "ab":
        threads.append(begin(held, *(f"{owner}{k}" for k in range(9))))
        until(lambda owner=owner: f"{owner}0" in BEGUN)  # type: ignore[misc]
    for number, name in enumerate("cd", 1):
        threads.append(begin(held, name))
        until(lambda number=number: len(held._line) == AT_ONCE + number)  # type: ignore[misc]
    order = ["a0", "b0"]
    for expected, left in (("c", 4), ("d", 4), ("a1", 4), ("b1", 3)):
        until(lambda left=left: len(held._line) == left)  # type: ignore[misc]
        assert order == BEGUN
        LET_GO.add(order[-AT_ONCE])
        order.append(expected)
        until(lambda: len(order) == len(BEGUN))
    LET_GO.update(BEGUN, (f"{owner}{k}" for owner in "ab" for k in range(9)))
    for thread in threads:
        thread.join()
    assert len(BEGUN) == 20


def _occupied(reader: Reader) -> Reader:
    """A reader that others' files keep busy for good."""
    for number in range(AT_ONCE):
        begin(reader, "ab"[number])
    until(lambda: len(BEGUN) == AT_ONCE)
    return reader


@pytest.mark.timeout(20)
def test_a_file_that_waits_for_others_can_be_stopped_and_is_told_once(held: Reader) -> None:
    reader, stopped = _occupied(held), threading.Event()
    told: list[str] = []

    def tell() -> None:
        told.append("others first")
        threading.Timer(0.3, stopped.set).start()

    with pytest.raises(CancelledError):
        reader.mesh(file_of(".stl"), "a.stl", stopped, tell)
    assert told == ["others first"]
    assert len(reader._line) == AT_ONCE


@pytest.mark.timeout(20)
def test_a_file_is_refused_when_others_are_read_for_too_long(held: Reader) -> None:
    reader = _occupied(held)
    reader.patience = 0.2
    with pytest.raises(SceneError, match="the server reads fewer files"):
        reader.scene(b"{}", "a.json")
    assert len(reader._line) == AT_ONCE


def test_readers_leave_half_of_the_memory_to_the_server() -> None:
    assert reading_memory(None) == reading_memory(64 * 10**9)
    for memory in (10**9, 2 * 10**9, 3 * 10**9):
        assert 2 * AT_ONCE * reading_memory(memory) == memory


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nothing is ended for want of memory")
def test_the_reader_is_the_first_to_end_where_memory_runs_out(reader: Reader) -> None:
    reader.mesh(file_of(".stl"), "a.stl")
    (process,) = reader._idle
    score = Path(f"/proc/{process.pid}/oom_score_adj").read_text()
    assert int(score) == 1000


def test_the_process_can_open_and_write_no_file(reader: Reader) -> None:
    reader.mesh(file_of(".stl"), "a.stl")
    (process,) = reader._idle
    for limit in (resource.RLIMIT_NOFILE, resource.RLIMIT_FSIZE):
        assert resource.prlimit(process.pid, limit) == (0, 0)

"""Scene files: opened beside the planning, saved under their names."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

from abi.scene.scene import Scene, load_scene, scene_names
from app.panels.files.file_uploads import FileUploads
from app.panels.files.files import file_stem
from app.reading.reader import Reader
from app.tab.session import Session
from tests.abi import meshes
from tests.abi.robot.robots import arm
from tests.app.fake_tab import FakeTab, notified, send_file, until


@pytest.mark.parametrize("name", scene_names())
def test_a_shipped_scene_is_saved_under_its_name(name: str) -> None:
    assert file_stem(name) == name


@pytest.mark.parametrize(
    ("name", "stem"),
    [
        ("wall.yaml", "wall"),
        ("paper.YML (opened)", "paper"),
        ("/home/someone/my scenes/two pipes.json", "two-pipes"),
        (r"C:\scenes\v1.2.zip", "v1.2"),
        ("Tür & Tor.yaml", "Tür-Tor"),
        ("..", "scene"),
        ("a/b/..yaml", "scene"),
        ("", "scene"),
        ('<>:"|?*', "scene"),
    ],
)
def test_a_file_is_named_after_its_scene(name: str, stem: str) -> None:
    assert file_stem(name) == stem


@pytest.mark.parametrize("name", ["two pipes.yaml", "Tür & Tor.zip (opened)", "..", "v1.2.json"])
def test_a_file_that_is_opened_and_saved_keeps_its_name(name: str) -> None:
    stem = file_stem(name)
    assert file_stem(f"{stem}.zip") == file_stem(f"{stem}.yaml (opened)") == stem


@pytest.fixture
def held(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """Holds back the reading of files until it is set."""
    event, read = threading.Event(), Reader.read

    def wait(*args: Any) -> object:
        assert event.wait(60)
        return read(*args)

    monkeypatch.setattr(Reader, "read", wait)
    return event


def _begin(session: Session, kind: str) -> FileUploads[Any]:
    """Send a file of a kind; what is told of it."""
    if kind == "scene":
        files = session.panels.files
        content = load_scene("sculpture").pack()
        send_file(session, files.upload, "own.zip", content)
        return files.uploads
    model = session.panels.stages.arm.model
    send_file(session, model.upload, "own.urdf", arm().encode())
    return model.uploads


def _is_taken(session: Session, kind: str) -> bool:
    if kind == "scene":
        return session.panels.files.name == "own.zip"
    return session.panels.stages.arm.model.model.value == "own.zip"


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["scene", "arm"])
def test_planning_goes_on_while_a_file_is_read(
    tab: tuple[FakeTab, Session], held: threading.Event, kind: str
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    uploads = _begin(session, kind)
    until(lambda: uploads._stop.visible and uploads._bar.visible)
    assert "reading" in uploads._line.content
    fake.set(session.panels.stages.fields["spline.degree"], 2)
    until(lambda: session.frame.plan.scene.spline.degree == 2)
    assert not _is_taken(session, kind)
    held.set()
    until(lambda: _is_taken(session, kind))
    until(lambda: not uploads._stop.visible)
    if kind == "scene":
        opened = session.panels.files.loaded
        assert opened.start == load_scene("sculpture").start
        until(lambda: session.frame.plan.scene == opened)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["scene", "arm"])
def test_a_file_that_waits_for_those_of_others_says_so(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    _, session = tab
    released, read = threading.Event(), Reader.read

    def wait(reader: Reader, job: Any, stopped: Any, delayed: Callable[[], object]) -> object:
        delayed()
        assert released.wait(60)
        return read(reader, job, stopped, delayed)

    monkeypatch.setattr(Reader, "read", wait)
    until(lambda: session.resting)
    uploads = _begin(session, kind)
    until(lambda: "waiting until the files of others are read" in uploads._line.content)
    released.set()
    until(lambda: _is_taken(session, kind))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["scene", "arm"])
def test_a_file_that_is_stopped_changes_nothing(
    tab: tuple[FakeTab, Session], held: threading.Event, kind: str
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    uploads, before = _begin(session, kind), session.frame.plan.scene
    until(lambda: uploads._stop.visible)
    fake.set(uploads._stop, True)
    until(lambda: not uploads._stop.visible)
    held.set()
    until(lambda: uploads._pending == 0)
    fake.set(session.panels.stages.fields["spline.degree"], 2)
    until(lambda: session.frame.plan.scene == before.replace(spline={"degree": 2}))
    assert not _is_taken(session, kind)


def test_a_scene_is_reset_beside_the_list_and_that_is_undone(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    files = session.panels.files
    fake.set(session.panels.stages.fields["spline.degree"], 2)
    until(lambda: session.frame.plan.scene.spline.degree == 2 and session.resting)
    changed = session.frame.plan.scene
    fake.set(files.reset, True)
    until(lambda: session.frame.plan.scene == load_scene("paper") and session.resting)
    fake.set(session.panels.history.undo, True)
    until(lambda: session.frame.plan.scene == changed)
    assert files.choice.value == "paper"
    # it stands right below the list, before what opens and saves
    assert files.choice.order < files.reset.order < files.upload.order


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["scene", "arm"])
def test_a_file_on_its_way_is_dropped_once_something_else_is_chosen(
    tab: tuple[FakeTab, Session], held: threading.Event, kind: str
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    uploads = _begin(session, kind)
    until(lambda: uploads._stop.visible)
    if kind == "scene":
        fake.set(session.panels.files.choice, "two-boxes")
        until(lambda: session.frame.plan.scene == load_scene("two-boxes"))
    else:
        fake.set(session.panels.stages.arm.model.model, "UR5e")
        until(lambda: session.frame.plan.scene.arm.urdf == "ur5e")
    until(lambda: not uploads._stop.visible)
    held.set()
    until(lambda: uploads._pending == 0 and session.resting)
    assert not _is_taken(session, kind)


@pytest.mark.slow
def test_a_mesh_of_the_scene_before_is_taken_with_a_notice_alone(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, session = tab
    told = notified(monkeypatch, session)
    file = {"shape": "mesh", "file": "wall.stl", "position": [3, 3, 3]}
    scene = Scene.from_dict(
        {"version": 1, "obstacles": [file]}, {"wall.stl": meshes.stl(meshes.bumpy(2))}
    )
    for name, content in (("a.zip", scene.pack()), ("b.zip", scene.pack())):
        send_file(session, session.panels.files.upload, name, content)
        until(lambda name=name: session.panels.files.name == name)  # type: ignore[misc]
    assert told == []
    text = b"version: 1\nobstacles: [{shape: mesh, file: wall.stl, position: [2, 2, 2]}]"
    send_file(session, session.panels.files.upload, "c.yaml", text)
    until(lambda: session.panels.files.name == "c.yaml")
    reason = "wall.stl of this tab was taken, since nothing came with the scene."
    assert told == [("c.yaml names what is not in it", reason)]

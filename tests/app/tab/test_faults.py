"""Faults: the last good plan and the session stay, a sentence tells, and files are whole."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import msgspec
import pytest
import zstandard
from websockets.exceptions import ConnectionClosed

from abi.atomic_file import replace_file
from app.cli.output import write_text
from app.server.server import Server
from app.tab.session import Session
from app.ui import notices as module
from tests.app.fake_tab import FakeTab, opened, until


@pytest.fixture
def notices(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    told: list[str] = []
    monkeypatch.setattr(module, "notify_refusal", lambda _, title, text: told.append(text))
    return told


def _fail(error: Exception) -> Callable[..., Any]:
    def fail(*_: object, **__: object) -> Any:
        raise error

    return fail


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stage", "error", "words"),
    [
        ("_exclude", MemoryError(), "not enough memory"),
        ("_fit_bspline", MemoryError(), "not enough memory"),
        ("_build_graph", RuntimeError("of our own"), "a fault of its own"),
        ("_profiles", ZeroDivisionError(), "a fault of its own"),
    ],
)
def test_a_stage_that_breaks_keeps_the_last_plan_and_the_session(
    tab: tuple[FakeTab, Session], notices: list[str], stage: str, error: Exception, words: str
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    good = session.plan
    tool = session._planner.live._planner._tool
    whole = getattr(tool, stage)
    setattr(tool, stage, _fail(error))
    fake.drag(session.panels.obstacles.gizmos[0], [3.0, 3.0, 2.5])
    until(lambda: bool(notices))
    assert words in notices[0]
    assert session.plan is good
    assert type(error).__name__ in str(session._fault)
    until(lambda: not session.frame.current)  # nothing of it is proven beside the dragged box

    # told once, not at every frame of the playback
    pause = threading.Event()
    pause.wait(0.2)
    assert len(notices) == 1

    setattr(tool, stage, whole)
    fake.drag(session.panels.obstacles.gizmos[0], [3.0, 3.0, 2.0])
    until(lambda: session.plan.scene.obstacles[0].position == (3.0, 3.0, 2.0))  # type: ignore[union-attr]
    assert session.plan is not None
    assert session.plan.error is None


@pytest.mark.slow
def test_going_back_after_a_fault_shows_the_last_plan_as_it_is(
    tab: tuple[FakeTab, Session], notices: list[str]
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    good, speed = session.plan, session.panels.stages.fields["motion.speed"]
    planner = session._planner.live._planner
    before, whole = speed.value, planner._tool._profiles
    planner._tool._profiles = _fail(RuntimeError())  # type: ignore[assignment]
    fake.set(speed, before + 1)
    until(lambda: bool(notices))
    planner._tool._profiles = whole
    fake.set(speed, before)
    until(lambda: session.resting and not session._broken and session.frame.current)
    assert session.plan is good


@pytest.mark.slow
def test_a_scene_that_breaks_a_stage_is_not_the_one_listed(
    tab: tuple[FakeTab, Session], notices: list[str]
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    good, planner = session.plan, session._planner.live._planner
    whole = planner._tool._fit_bspline
    planner._tool._fit_bspline = _fail(RuntimeError())  # type: ignore[assignment]
    files, speed = session.panels.files, session.panels.stages.fields["motion.speed"]
    fake.set(files.choice, "two-boxes")
    until(lambda: bool(notices))
    until(lambda: files.choice.value == "paper" and session.frame.current)
    assert session.plan is good
    # nor do the other panels show any of it
    planner._tool._fit_bspline = whole
    fake.set(speed, 3.0)
    until(lambda: session.resting and session.frame.plan.scene.motion.speed == 3.0)
    assert files.name == "paper"
    assert session.frame.plan.scene.obstacles == good.scene.obstacles  # type: ignore[union-attr]


def test_a_tab_that_is_cut_in_the_middle_of_a_drag_leaves_nothing_behind(server: Server) -> None:
    fake, session = opened(server)
    gizmo = session.panels.obstacles.gizmos[0]
    owner = gizmo._impl.api._owner_id
    fake.send(
        {"type": "TransformControlsDragStartMessage", "name": gizmo._impl.name, "owner": owner}
    )
    for step in range(20):
        fake.drag(gizmo, [3.0, 3.0, 3.0 - 0.01 * step])
    fake.cut()
    until(lambda: session.client.client_id not in server.sessions)
    until(lambda: not session._worker._thread.is_alive())


@pytest.mark.slow
def test_sigterm_tells_the_tabs_and_ends_with_0() -> None:
    command = [sys.executable, "-m", "app", "serve", "--port", "0", "--no-open"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    url = next(word for word in process.stdout.readline().split() if word.startswith("http"))
    texts: list[str] = []
    fake = _ReadingTab(url, texts)
    try:
        until(lambda: any("stage" in text for text in texts))
    except AssertionError:
        process.kill()
        raise AssertionError(f"{len(texts)} messages, log: {process.communicate()[1]}") from None
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=30)
    until(lambda: any("The server has stopped" in text for text in texts))
    fake.close()
    assert process.returncode == 0
    assert "Traceback" not in err
    assert [line.split()[3:5] for line in err.splitlines()] == [
        ["tab", "opened"],
        ["tab", "closed"],
    ]


class _ReadingTab(FakeTab):
    """A tab that keeps what it is sent, as text."""

    def __init__(self, url: str, texts: list[str]) -> None:
        self._texts = texts
        super().__init__(url)

    def _read(self) -> None:
        try:
            for raw in self._socket:
                assert isinstance(raw, bytes)
                size = int.from_bytes(raw[8:16], "little")
                inner = zstandard.ZstdDecompressor().decompress(raw[16 : 16 + size])
                self._texts.append(str(msgspec.msgpack.decode(inner)["messages"]))
        except ConnectionClosed:
            return


def test_a_full_disk_leaves_the_old_file_whole_and_no_half_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "plan.json"
    target.write_text("old")
    monkeypatch.setattr(os, "fsync", _fail(OSError(28, "No space left on device")))
    with pytest.raises(OSError, match="No space left"):
        replace_file(target, b"new")
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only Linux has a full device")
def test_a_plan_that_cannot_be_written_ends_with_a_sentence() -> None:
    with pytest.raises(click.ClickException, match="no space left on device"):
        write_text(Path("/dev/full"), "{}")
    assert Path("/dev/full").is_char_device()

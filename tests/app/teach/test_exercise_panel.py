"""A student's file in the page: checked whenever it is saved, with its counterexample."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.panels.teach.exercise import ExercisePanel
from app.server.server import start
from app.state.appearance import PLAIN
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, until

_GREEDY = "def priority(g, h):\n    return h\n"
_RIGHT = "def priority(g, h):\n    return g + h\n"


def panel(session: Session) -> ExercisePanel:
    assert session._view.exercise is not None
    return session._view.exercise


def told(session: Session) -> str:
    return panel(session)._text.content


@pytest.mark.slow
def test_a_file_is_checked_when_it_is_saved_and_its_case_opens(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(_GREEDY)
    server = start(port=0, scene="paper", look=PLAIN, exercise=file)
    try:
        fake = FakeTab(server.url)
        until(lambda: len(server.sessions) == 1)
        session = next(iter(server.sessions.values()))
        until(lambda: session.plan is not None and "is waiting with a smaller" in told(session))
        own = session.scene

        fake.set(panel(session).open, True)
        until(lambda: session.frame.theatre is not None and len(session.frame.theatre.race) == 2)
        assert session.frame.theatre is not None
        (_, yours), (_, right) = session.frame.theatre.race
        case = panel(session)._shown
        assert case is not None
        assert yours.step == right.step == case.parting + 1
        assert yours.trace.order[: yours.step - 1].tolist() == right.closed[:-1].tolist()
        assert yours.current != right.current
        assert yours.done
        assert right.trace.order[-1] == right.trace.arcs.goal

        file.write_text(_RIGHT)
        until(lambda: "All 20 hidden scenes are right" in told(session))
        assert not panel(session).open.visible
        fake.set(panel(session).back, True)
        until(lambda: session.scene == own and session.frame.theatre is None)

        file.write_text("def priority(g, h)\n")
        until(lambda: "line 1" in told(session))
        file.write_text("def priority(g, h):\n    raise ValueError('<b>bold</b>')\n")
        until(lambda: "&lt;b&gt;bold" in told(session))
        file.unlink()
        until(lambda: "can be read" in told(session))
    finally:
        server.stop()

from __future__ import annotations

import base64
import json
import math
import re
import zlib
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, reject
from hypothesis import strategies as st

from abi import assets
from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.scene.scene import load_scene, scene_names
from abi.scene.scene_file import MAX_JSON_BYTES
from app.camera.view import View
from app.guard.guarded_server import MAX_MESSAGE
from app.guard.values import MAX_TEXT
from app.server.server import Server
from app.state import tab_state
from app.state.tab_state import LONGEST_LINK, MAX_PROGRESS, TabState, encoder
from app.tab.browser_storage import TabStorage
from app.tab.session import Session
from app.ui import notices
from tests.app.fake_tab import FakeTab, heard, opened, until

MESHES = MeshSource(folder=assets.path("scenes"))


@pytest.mark.parametrize("name", scene_names())
def test_a_state_comes_back_as_it_was(name: str) -> None:
    state = TabState(
        name,
        load_scene(name),
        View((1.0, 2.0, 3.0), (0.0, 0.5, 0.0), (0.0, 0.0, 1.0)),
        time=1.25,
        playing=False,
        shown=frozenset({"arm", "edges"}),
        dark=True,
    )
    text = state.encode()
    assert len(text) < LONGEST_LINK
    assert set(text) <= set("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_")
    assert TabState.decode(text, MESHES) == state


@pytest.fixture
def packed(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """Stretches that are compressed, in order."""
    noted: list[bytes] = []
    deflate = tab_state._deflate

    def note(data: bytes, end: int) -> bytes:
        noted.append(data)
        return deflate(data, end)

    monkeypatch.setattr(tab_state, "_deflate", note)
    return noted


def test_a_scene_that_stays_is_packed_once(packed: list[bytes]) -> None:
    encode = encoder()
    forest, paper = load_scene("forest"), load_scene("paper")
    for number, scene in enumerate((forest, forest, paper, paper, forest)):
        state = TabState("any", scene, time=float(number))
        text = encode(state)
        assert TabState.decode(text, MESHES) == state
        assert text == encoder()(state)
    scenes = [text for text in packed if text.startswith(b'{"scene"')]
    assert len(scenes) == 3 + 5  # the encoder's own, and those of a new one each time


@given(st.text(max_size=200))
def test_no_text_is_taken_for_a_state_by_mistake(text: str) -> None:
    with pytest.raises(SceneError):
        TabState.decode(text, MESHES)


_PLAIN = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=6,
)


@pytest.mark.slow
@given(st.fixed_dictionaries(dict.fromkeys(("name", "view", "time", "shown", "dark"), _PLAIN)))
def test_what_is_damaged_beside_the_scene_is_left_out(parts: dict[str, Any]) -> None:
    data = {"version": 1, "scene": {"version": 1}, **parts}
    packed = zlib.compress(json.dumps(data, default=str).encode())
    try:
        state = TabState.decode(base64.urlsafe_b64encode(packed).decode(), MESHES)
    except SceneError:  # JSON knows no infinity
        reject()
    assert state.scene.obstacles == ()
    assert math.isfinite(state.time)
    assert state.time >= 0


def test_a_text_that_unpacks_to_much_is_refused() -> None:
    packed = zlib.compress(b" " * 50_000_000)
    with pytest.raises(SceneError, match="damaged"):
        TabState.decode(base64.urlsafe_b64encode(packed).decode(), MESHES)


def test_a_tab_shows_what_its_page_remembers(server: Server) -> None:
    """Also where the report is late, after the first plan."""
    scene = load_scene("two-boxes").replace(spline={"degree": 3})
    view = View((9.0, -9.0, 9.0), (3.0, 3.0, 3.0), (0.0, 0.0, 1.0))
    state = TabState("two-boxes", scene, view, time=0.5, playing=False, shown=frozenset({"arm"}))
    fake, session = opened(server)
    fake.set(
        session._memory._box, json.dumps({"state": state.encode(), "query": {}, "dark": False})
    )
    until(lambda: session.plan is not None and session.plan.scene == scene)
    until(lambda: session.frame.time == 0.5)
    assert session.panels.files.choice.value == "two-boxes"
    assert session.panels.layer_switches.shown() == {"arm"}
    assert session.client.camera.position == pytest.approx(view.position)
    fake.set(session.panels.files.reset, True)
    until(lambda: session.plan is not None and session.plan.scene == load_scene("two-boxes"))
    fake.close()
    until(lambda: not server.sessions)


@pytest.mark.slow
@pytest.mark.parametrize(
    "report", ["", "{", "[]", '{"state": 3}', '{"state": "x", "query": [], "dark": 0}']
)
def test_a_report_of_nonsense_changes_nothing(tab: tuple[FakeTab, Session], report: str) -> None:
    fake, session = tab
    fake.set(session._memory._box, report + " ")
    fake.set(session.panels.stages.fields["spline.degree"], 3)
    until(lambda: session.plan.scene.spline.degree == 3)  # type: ignore[union-attr]
    assert session.plan is not None
    assert session.plan.scene.obstacles == load_scene("paper").obstacles


def test_every_state_that_is_written_can_be_reported() -> None:
    """One too long would be lost at a reload; the page says how long one is that it cannot send."""
    script = assets.path("page", "page.js").read_text(encoding="utf-8")
    found = re.search(r"LONGEST: ([0-9_]+),", script)
    assert found is not None
    longest = int(found[1])
    # as base64 of what no packing makes shorter
    assert longest >= (MAX_JSON_BYTES + 10_000) * 4 / 3
    assert longest + 4 * MAX_PROGRESS < MAX_TEXT < MAX_MESSAGE / 2


def test_a_state_that_is_too_long_to_come_back_is_told(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    told: list[str] = []
    monkeypatch.setattr(notices, "notify_refusal", lambda client, *words, **_: told.extend(words))
    fake.set(session._memory._box, json.dumps({"state": "", "oversize": 3_100_000}))
    until(lambda: len(told) == 2)
    assert told[0] == "Not brought back"
    assert "3,100,000 letters" in told[1]
    assert session._fault is None


def test_only_what_changed_is_kept(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, session = tab
    session.close()  # its worker keeps states, too
    texts = heard(monkeypatch, "remember")
    memory = TabStorage(session.client, session.wake)
    state = TabState("paper", load_scene("paper"))
    memory.keep(state, now=True)  # before the page has said what it remembers, which may be more
    assert texts == []
    memory._box.value = "{}"  # type: ignore[misc]
    assert memory.report() is not None
    memory.keep(state)
    memory.keep(state, now=True)
    memory.keep(TabState("paper", load_scene("paper"), time=1.0))
    memory.keep(TabState("paper", load_scene("paper"), time=2.0), now=True)
    assert [TabState.decode(text, MESHES).time for text in texts] == [0.0, 2.0]
    memory._box.remove()


def _with_before() -> TabState:
    view = View((1.0, 2.0, 3.0), (0.0, 0.5, 0.0), (0.0, 0.0, 1.0))
    before = TabState("two-boxes", load_scene("two-boxes"), view, shown=frozenset({"arm"}))
    return TabState("two-boxes", load_scene("paper"), time=0.5, before=before, figure=3)


def test_what_was_before_a_lesson_comes_back_too_but_not_by_a_link() -> None:
    state = _with_before()
    assert TabState.decode(state.encode(), MESHES) == state
    link = state.alone().encode()
    assert link == TabState("two-boxes", load_scene("paper"), time=0.5).encode()
    assert TabState.decode(link, MESHES).before is None


def test_what_was_before_is_packed_once(packed: list[bytes]) -> None:
    encode, state = encoder(), _with_before()
    text = encode(state)
    packed.clear()
    assert encode(state) == text
    assert len(packed) == 1
    later = encode(state.alone())
    assert later == state.alone().encode()


def test_the_figure_shown_last_comes_back() -> None:
    encode, state = encoder(), _with_before()
    for figure in (3, 5, 0, 1):
        shown = replace(state, figure=figure)
        assert TabState.decode(encode(shown), MESHES) == shown


@pytest.mark.parametrize("before", [{}, [], 3, {"scene": 1}, {"scene": {"version": 1, "start": 7}}])
def test_a_damaged_state_before_is_left_out(before: object) -> None:
    data = {"version": 1, "scene": {"version": 1}, "figure": 2, "before": before}
    packed = zlib.compress(json.dumps(data).encode())
    state = TabState.decode(base64.urlsafe_b64encode(packed).decode(), MESHES)
    assert state.before is None
    assert state.figure == 0


def test_before_a_state_is_no_other_before_it() -> None:
    inner = {"version": 1, "scene": {"version": 1}}
    outer = {"version": 1, "scene": {"version": 1}, "before": {**inner, "before": inner}}
    for figure in (-1, 1e300, True, "2", None):
        packed = zlib.compress(json.dumps({**outer, "figure": figure}).encode())
        state = TabState.decode(base64.urlsafe_b64encode(packed).decode(), MESHES)
        assert state.before is not None
        assert state.before.before is None
        assert state.figure == 0


def test_a_state_before_that_is_too_much_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    state = _with_before()
    room = len(state.scene.model_dump_json()) + 1000
    monkeypatch.setattr(tab_state, "MAX_JSON_BYTES", room)
    back = TabState.decode(state.encode(), MESHES)
    assert back == state.alone()


@pytest.mark.slow
@pytest.mark.parametrize(
    "view",
    [
        [1e30, 1e30, 1e30, 0, 0, 0, 0, 0, 1],
        [1e-300, 0, 0, 0, 0, 0, 0, 0, 1],
        [9, -9, 9, 3, 3, 3, 0, 0, 1e-320],
        "somewhere",
    ],
)
def test_a_link_with_a_camera_that_sees_nothing_says_so_and_shows_its_scene(
    view: object, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = load_scene("two-boxes").replace(spline={"degree": 3})
    data = {"version": 1, "name": "two-boxes", "scene": scene.to_dict(), "view": view}
    text = base64.urlsafe_b64encode(zlib.compress(json.dumps(data).encode())).decode()
    told: list[str] = []
    stayed: list[bool] = []

    def tell(client: object, *words: str, stays: bool = False) -> None:
        told.extend(words)
        stayed.append(stays)

    monkeypatch.setattr(notices, "notify_warning", tell)
    fake, session = _reloaded(server, text)
    until(lambda: session.plan is not None and session.plan.scene == scene and session.resting)
    assert told[0] == "Part of the link is left out"
    assert "nothing can be seen" in told[1]
    assert stayed == [True]  # a page that is still being drawn shows it, too
    assert session._fault is None
    assert View.of_camera(session.client.camera) is not None
    fake.close()
    until(lambda: not server.sessions)


def _reloaded(server: Server, text: str) -> tuple[FakeTab, Session]:
    """A tab whose page remembers ``text``."""
    fake, session = opened(server)
    fake.set(session._memory._box, json.dumps({"state": text, "query": {}, "dark": False}))
    return fake, session


def test_after_a_reload_a_figure_still_leads_back(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = _with_before()
    assert state.before is not None
    fake, session = _reloaded(server, state.encode())
    until(lambda: session.scene == state.scene and session.resting)
    kept = session.state()
    assert kept.before == state.before
    assert kept.figure == 3
    fake.set(session.panels.figures.back, True)
    until(lambda: session.plan is not None and session.plan.scene == state.before.scene)  # type: ignore[union-attr]
    assert session.client.camera.position == pytest.approx(state.before.view.position)  # type: ignore[union-attr]
    assert session.panels.layer_switches.shown() == {"arm"}
    assert session.state().before is None
    fake.close()
    until(lambda: not server.sessions)


@pytest.mark.slow
def test_after_a_reload_a_lesson_still_leads_back(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine = load_scene("two-boxes").replace(spline={"degree": 3})
    fake, session = _reloaded(server, TabState("two-boxes", mine).encode())
    until(lambda: session.plan is not None and session.plan.scene == mine and session.resting)
    lessons = session.panels.lessons
    until(lambda: len(lessons.choice.options) > 1)
    fake.set(lessons.choice, lessons.choice.options[1])
    until(lambda: session.resting and session.plan.scene == load_scene("paper"))  # type: ignore[union-attr]
    text = session.state().encode()
    fake.close()
    until(lambda: not server.sessions)

    fake, session = _reloaded(server, text)
    until(lambda: session.panels.lessons.progress.chosen and session.resting)
    fake.set(session.panels.lessons.choice, session.panels.lessons.choice.options[0])
    until(lambda: session.plan is not None and session.plan.scene == mine)
    fake.close()
    until(lambda: not server.sessions)

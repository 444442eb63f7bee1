"""The notice of how far the compilation is: the same in all tabs, and gone at the end."""

from __future__ import annotations

import math
import re
import threading
from types import SimpleNamespace
from typing import Any, cast

import pytest

from abi import compiling
from abi.planner.live_planner import LivePlanner
from abi.scene.scene import load_scene
from app.server import warm_up
from app.server.warm_up import WarmUp, _words
from app.shared.shared_plans import SharedPlans


class Tab:
    """Takes the place of a client, and keeps its notices."""

    def __init__(self) -> None:
        self.notices: list[Any] = []

    def add_notification(self, title: str, body: str, **_: object) -> Any:
        notice = SimpleNamespace(title=title, body=body)
        notice.remove = lambda: self.notices.remove(notice)
        self.notices.append(notice)
        return notice


@pytest.mark.parametrize("left", [0.0, 3.0, 10.0, 11.0, 89.0, 91.0, 600.0])
def test_the_time_left_is_told_in_round_numbers(left: float) -> None:
    words = compiling._time_left(0.5, left)  # as long again as it has taken
    [number], minutes = re.findall(r"\d+", words), "minutes" in words
    told = int(number) * (60 if minutes else 1)
    assert math.isclose(told, left, abs_tol=30 if minutes else 10)
    assert told > 0


def test_nothing_is_told_of_a_time_that_is_not_known() -> None:
    assert not re.search(r"\d", " ".join(_words(None, "")))
    assert "40 %" in _words(0.4, "30 s")[1].replace("40%", "40 %")


def test_all_tabs_are_told_how_far_it_is_until_it_is_done(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first, second, ready = Tab(), Tab(), threading.Event()
    states = [(0.1, "90 s"), (0.6, "40 s"), (None, "")]
    shares, times = zip(*states, strict=True)
    coming, left, told = iter(shares), iter(times), []

    def wait(_: float) -> bool:
        told.append([[notice.title for notice in tab.notices] for tab in (first, second)])
        if len(told) == 2:
            work.add(cast(Any, second))
        return len(told) == 4

    monkeypatch.setattr(warm_up, "PLAN_TIMEOUT", 0.0)
    monkeypatch.setattr(warm_up, "prepare_picture", lambda: None)
    monkeypatch.setattr(warm_up, "loaded", lambda: None)
    monkeypatch.setattr(compiling, "begin", lambda spare: ready.wait())
    monkeypatch.setattr(compiling, "wait", wait)
    monkeypatch.setattr(compiling, "share_done", lambda: next(coming))
    monkeypatch.setattr(compiling, "time_left", lambda: next(left))
    for name in ("_plan_opening", "_load", "_call_kernels"):
        monkeypatch.setattr(WarmUp, name, lambda *_: None)
    work = WarmUp(load_scene("paper"), SharedPlans())
    work.add(cast(Any, first))
    ready.set()
    work.thread.join()
    titles = [_words(*state)[0] for state in states]
    assert told == [[[], []], [[titles[0]], []], [[titles[1]]] * 2, [[titles[2]]] * 2]
    assert not first.notices + second.notices


@pytest.mark.parametrize(
    ("name", "first"), [("sculpture", "compiler"), ("kitchen-ur5e", "compiler"), ("paper", "plan")]
)
def test_what_is_slow_without_the_compiler_is_not_planned_before_that_begins(
    name: str, first: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[str] = []

    def plan(_: object, scene: object) -> Any:
        begun.append("plan")
        raise InterruptedError

    monkeypatch.setattr(warm_up, "prepare_picture", lambda: None)
    monkeypatch.setattr(warm_up, "loaded", lambda: None)
    monkeypatch.setattr(compiling, "begin", lambda *_, **__: begun.append("compiler"))
    monkeypatch.setattr(LivePlanner, "__call__", plan)
    monkeypatch.setattr(threading, "excepthook", lambda _: None)  # of the plan that does not come
    WarmUp(load_scene(name), SharedPlans()).thread.join()
    assert begun[0] == first

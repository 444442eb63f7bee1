"""Details lag behind a drag only in a crowd, never for long, and not once the hand rests."""

from __future__ import annotations

from dataclasses import replace

import pytest

from abi.planner.plan import Plan
from abi.scene.scene import load_scene
from app.layers import details
from app.layers.details import LONGEST, PAUSE, lagging
from app.state.frame import Frame


class Clock:
    """A clock that is set by hand."""

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        return self.now


class Recorder:
    """A layer that notes what it is asked to draw."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []

    def __call__(self, frame: Frame) -> None:
        self.frames.append(frame)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(details, "time", clock)
    return clock


@pytest.fixture
def dragged() -> Frame:
    return Frame(Plan(load_scene("two-boxes")), interactive=True)


def _never() -> bool:
    return False


def test_alone_a_tab_draws_every_detail_of_every_frame(clock: Clock, dragged: Frame) -> None:
    layer = Recorder()
    alone = lagging([layer], lambda: 0, _never)
    for _ in range(5):
        alone(replace(dragged))
    assert len(layer.frames) == 5


@pytest.mark.parametrize(("waiting", "pause"), [(2, 2 * PAUSE), (1000, LONGEST)])
def test_in_a_crowd_details_pause_but_never_for_long(
    clock: Clock, dragged: Frame, waiting: int, pause: float
) -> None:
    layer = Recorder()
    crowded = lagging([layer], lambda: waiting, _never)
    crowded(dragged)
    clock.now += 0.9 * pause
    crowded(replace(dragged))
    assert layer.frames == [dragged]
    clock.now += 0.2 * pause
    crowded(last := replace(dragged))
    assert layer.frames == [dragged, last]


def test_in_a_crowd_a_drag_begins_without_details(clock: Clock, dragged: Frame) -> None:
    layer, waiting = Recorder(), 3
    crowded = lagging([layer], lambda: waiting, _never)
    crowded(still := replace(dragged, interactive=False))
    clock.now += 1000
    crowded(dragged)
    assert layer.frames == [still]
    clock.now += 1.1 * waiting * PAUSE
    crowded(dragged)
    assert layer.frames == [still, dragged]


@pytest.mark.parametrize(
    "change", [{"interactive": False}, {"shown": frozenset({"edges"})}, {"mesh_view": "surface"}]
)
def test_what_is_asked_for_and_the_last_frame_do_not_wait(
    clock: Clock, dragged: Frame, change: dict[str, object]
) -> None:
    layer = Recorder()
    crowded = lagging([layer], lambda: 1000, _never)
    crowded(dragged)
    crowded(other := replace(dragged, **change))  # type: ignore[arg-type]
    assert layer.frames == [dragged, other]


def test_once_another_choice_is_made_the_rest_waits_for_its_frame(
    clock: Clock, dragged: Frame
) -> None:
    layers = [Recorder(), Recorder(), Recorder()]
    chosen = iter([False, True, False, False, False])
    crowded = lagging(layers, lambda: 1000, lambda: next(chosen))
    crowded(dragged)
    assert [layer.frames for layer in layers] == [[dragged], [], []]
    crowded(last := replace(dragged))
    assert [layer.frames for layer in layers] == [[dragged, last], [last], [last]]

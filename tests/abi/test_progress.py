"""A computation ends at the next kernel once its result is not wanted, in its own thread alone."""

from __future__ import annotations

import threading

import pytest

from abi import load_scene, progress
from abi.planner.planner import Planner
from abi.progress import CancelledError, watched_by


class _Watch:
    """Hears what is done, and cancels at a word."""

    def __init__(self, last: str) -> None:
        self.heard: list[str] = []
        self._last = last

    def cancelled(self) -> bool:
        return self._last in self.heard

    def told(self, doing: str) -> None:
        self.heard.append(doing)


def _check(passed: threading.Event) -> None:
    progress.check()
    passed.set()


@pytest.mark.parametrize("last", ["making the mesh", "searching", "fitting curves"])
def test_a_plan_ends_where_it_is_cancelled_and_can_be_made_again(last: str) -> None:
    scene, planner = load_scene("two-boxes"), Planner(compile=False)
    watch = _Watch(last)
    with pytest.raises(CancelledError), watched_by(watch.cancelled, watch.told):
        planner(scene)
    assert watch.heard[-1] == last
    assert planner(scene).to_dict()["path"] == Planner(compile=False)(scene).to_dict()["path"]


def test_a_plan_that_is_wanted_tells_its_stages_in_order() -> None:
    watch = _Watch("never")
    with watched_by(watch.cancelled, watch.told):
        plan = Planner(compile=False)(load_scene("paper"))
    assert plan.error is None
    assert watch.heard == [
        "reading obstacles and arm",
        "making the mesh",
        "testing the mesh's edges",
        "searching",
        "fitting curves",
        "moving the arm",
    ]


def test_only_the_thread_that_is_watched_is_cancelled() -> None:
    passed = threading.Event()
    with watched_by(lambda: True):
        other = threading.Thread(target=_check, args=(passed,))
        other.start()
        other.join()
        with watched_by(lambda: False):
            progress.check()
        with pytest.raises(CancelledError):
            progress.check()
    progress.check()
    assert passed.is_set()


def test_a_wait_for_another_thread_ends_too() -> None:
    event, asked = threading.Event(), [0]

    def cancelled() -> bool:
        asked[0] += 1
        return asked[0] > 2

    with pytest.raises(CancelledError), watched_by(cancelled):
        progress.wait(event)
    event.set()
    progress.wait(event)

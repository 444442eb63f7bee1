"""A few restarts; ``make restarts`` is all of them."""

from __future__ import annotations

import pytest
from playwright.sync_api import Browser

from benchmarks import restarts


@pytest.mark.slow
def test_nothing_is_lost_when_the_server_is_killed_under_an_edit(
    chromium: Browser, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(restarts, "FREEZE", 1.0)
    found = restarts.measure(chromium, kills=1, reloads=0, freezes=1)
    assert (found["kills"], found["reloads"], found["freezes"]) == (1, 0, 1)
    assert found["lost"] == 0
    assert found["misplaced"] == 0
    assert found["empty_plots"] == 0


def test_figures_of_a_run_that_ends_early_are_of_what_was_done() -> None:
    tally = restarts.Tally()
    assert tally.figures()["lost"] == 0
    tally.add("kill", 2.0, back=True, placed=True, plotted=True)
    tally.add("kill", 5.0, back=False, placed=False, plotted=True)
    figures = tally.figures()
    assert (figures["kills"], figures["reloads"], figures["lost"]) == (2, 0, 1)
    assert figures["misplaced"] == 1
    assert (figures["empty_plots"], figures["worst_s"]) == (0, 5.0)

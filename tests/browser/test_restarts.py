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
    found = restarts.measure(chromium, kills=3, reloads=1, freezes=1)
    assert (found["kills"], found["reloads"], found["freezes"]) == (3, 1, 1)
    assert found["lost"] == 0
    assert found["empty_plots"] == 0

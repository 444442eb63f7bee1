from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.process import logs
from app.server.server import Server, start
from app.state.appearance import PLAIN
from app.tab import browser_storage
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, opened, until

_HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    # where the browser has the other processor, a tab's threads may be later than any patience
    for item in items:
        if _HERE in item.path.parents and {"server", "tab"} & set(
            getattr(item, "fixturenames", ())
        ):
            item.add_marker(pytest.mark.flaky(reruns=1))


@pytest.fixture(scope="session", autouse=True)
def no_report() -> None:
    """Do not wait for what a page reports: no fake tab does."""
    browser_storage.TIMEOUT = 0.0


@pytest.fixture(autouse=True)
def quiet() -> Iterator[None]:
    """Nobody's log goes on into the next test."""
    yield
    logging.getLogger().removeHandler(logs._TERMINAL)
    for name in logs._LOGGERS:
        logging.getLogger(name).setLevel(logging.NOTSET)


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    running = start(port=0, scene="paper", look=PLAIN)
    yield running
    running.stop()


@pytest.fixture
def tab(server: Server) -> Iterator[tuple[FakeTab, Session]]:
    fake, session = opened(server)
    yield fake, session
    number = session.client.client_id
    fake.close()
    until(lambda: number not in server.sessions)

"""Compiled kernels for all tests; those that test kernels as Python say so."""

from __future__ import annotations

import gc
import os
from collections.abc import Generator
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

import abi
from app.process.scratch import remove_abandoned, scratch_folder
from tests.thorough import EXAMPLES
from tests.workers import BROWSERS, ByFile, in_order

_GIVES_WAY = pytest.StashKey[bool]()

# How long an example takes says more of the machine than of the code. What stays on is the check
# that most examples are not filtered out: a property that assumes what it is about must meet it.
_OFF = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.large_base_example]
settings.register_profile(
    "any machine", settings(), deadline=None, suppress_health_check=_OFF, max_examples=EXAMPLES
)
settings.load_profile("any machine")


def pytest_make_parametrize_id(val: object) -> str | None:
    """Short names of cases: archives hold the time, and workers must agree on a test's name."""
    if isinstance(val, bytes):
        return f"{len(val)} bytes"
    if isinstance(val, str) and len(val) > 60:
        return f"{val[:40]} and more"
    return None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    in_order(items)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Search for garbage among what tests make, not among what they import, which stays."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        # far more seldom than usual: nearly all that tests make is gone with its last name
        gc.set_threshold(50_000, 20, 100)
        gc.enable()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """One worker a processor, and one more for each browser, which mostly wait."""
    return (os.cpu_count() or 1) + BROWSERS * ("not browser" not in config.option.markexpr)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> ByFile:
    return ByFile(config, log)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Let workers that compute give way to those with a browser, which draws for a person's eye."""
    if not hasattr(item.config, "workerinput") or item.get_closest_marker("browser") is not None:
        return
    if not item.config.stash.get(_GIVES_WAY, False):
        item.config.stash[_GIVES_WAY] = True
        os.nice(5)


def pytest_configure(config: pytest.Config) -> None:
    # what is uploaded goes into no user's cache
    if "ABI_STORE" not in os.environ:
        remove_abandoned()
        folder = scratch_folder()
        os.environ["ABI_STORE"] = f"{folder.name}/uploads"
        config.add_cleanup(folder.cleanup)
    # once, before the workers start, which then load what was kept
    if not config.option.collectonly:
        abi.compile()

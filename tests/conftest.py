"""Compiled kernels for all tests; those that test kernels as Python say so."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

import abi
from app.process.scratch import ScratchFolder, remove_abandoned

_EXAMPLES = Path(__file__).parent / "examples"

# How long an example takes says more of the machine than of the code. What stays on is the check
# that most examples are not filtered out: a property that assumes what it is about must meet it.
_OFF = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.large_base_example]
settings.register_profile("any machine", settings(), deadline=None, suppress_health_check=_OFF)
settings.load_profile("any machine")


def pytest_make_parametrize_id(val: object) -> str | None:
    """Short names of cases: archives hold the time, and workers must agree on a test's name."""
    if isinstance(val, bytes):
        return f"{len(val)} bytes"
    if isinstance(val, str) and len(val) > 60:
        return f"{val[:40]} and more"
    return None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """First those of examples, which take longest one by one: nobody is to wait for the last."""
    items.sort(key=lambda item: item.path.parent != _EXAMPLES)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """One worker a processor, and one more where workers have browsers and mostly wait."""
    return (os.cpu_count() or 1) + ("not browser" not in config.option.markexpr)


def pytest_configure(config: pytest.Config) -> None:
    # what is uploaded goes into no user's cache
    if "ABI_STORE" not in os.environ:
        remove_abandoned()
        folder = ScratchFolder()
        os.environ["ABI_STORE"] = str(folder.path / "uploads")
        config.add_cleanup(folder.close)
    # once, before the workers start, which then load what was kept
    if not config.option.collectonly:
        abi.compile()

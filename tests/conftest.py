"""Compiled kernels for all tests; those that test kernels as Python say so."""

from __future__ import annotations

import pytest
from hypothesis import settings

import abi

# how long an example takes says more of the machine than of the code
settings.register_profile("any machine", settings(), deadline=None)
settings.load_profile("any machine")


def pytest_configure(config: pytest.Config) -> None:
    # once, before the workers start, which then load what was kept
    if not config.option.collectonly:
        abi.compile()

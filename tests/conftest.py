"""Compiled kernels for all tests; those that test kernels as Python say so."""

from __future__ import annotations

import pytest

import abi


def pytest_configure(config: pytest.Config) -> None:
    # once, before the workers start, which then load what was kept
    if not config.option.collectonly:
        abi.compile()

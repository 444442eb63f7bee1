"""Compiled kernels for all tests; those that test kernels as Python say so."""

from __future__ import annotations

import os
import tempfile

import pytest
from hypothesis import settings

import abi

# how long an example takes says more of the machine than of the code
settings.register_profile("any machine", settings(), deadline=None)
settings.load_profile("any machine")


def pytest_make_parametrize_id(val: object) -> str | None:
    """Short names of cases: archives hold the time, and workers must agree on a test's name."""
    if isinstance(val, bytes):
        return f"{len(val)} bytes"
    if isinstance(val, str) and len(val) > 60:
        return f"{val[:40]} and more"
    return None


def pytest_configure(config: pytest.Config) -> None:
    # what is uploaded goes into no user's cache
    os.environ.setdefault("ABI_STORE", tempfile.mkdtemp(prefix="abi-store-"))
    # once, before the workers start, which then load what was kept
    if not config.option.collectonly:
        abi.compile()

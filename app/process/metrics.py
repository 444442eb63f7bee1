"""Figures of a running server, in the text format of Prometheus."""

from __future__ import annotations

import functools
import os
from collections.abc import Mapping
from pathlib import Path

from prometheus_client import (
    CONTENT_TYPE_LATEST,
    REGISTRY,
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    generate_latest,
    multiprocess,
)

_STATM = Path("/proc/self/statm")
_SECONDS = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30)

TABS = Gauge("abi_tabs", "Tabs that are open.", multiprocess_mode="livesum")
SESSIONS = Counter("abi_sessions", "Tabs opened since the start.")
PLANS = Histogram("abi_plan_seconds", "Time of a plan.", buckets=_SECONDS)
STAGE_SECONDS = Histogram(
    "abi_stage_seconds", "Time of a stage, when it ran.", ["stage"], buckets=_SECONDS
)
UPDATES = Histogram(
    "abi_update_seconds", "Time from an input to its plan being sent.", buckets=_SECONDS
)
MEMORY = Gauge(
    "abi_memory_bytes", "Resident memory of the server's processes.", multiprocess_mode="livesum"
)
FAULTS = Counter("abi_faults", "Faults of the visualiser's own that a tab met.")
REFUSED_MESSAGES = Counter("abi_refused_messages", "Messages not read.", ["reason"])
REFUSED_REQUESTS = Counter("abi_refused_requests", "Requests refused.", ["status"])


def observe_plan(seconds: float, before: Mapping[str, float], after: Mapping[str, float]) -> None:
    """Count a plan, and each stage that ran for it.

    Args:
        seconds: time of the whole plan.
        before: time of each stage when it last ran for the plan before, [ms].
        after: the same for this plan; equal where the stage did not run again.
    """
    PLANS.observe(seconds)
    for stage, milliseconds in after.items():
        if milliseconds > 0 and milliseconds != before.get(stage):
            _stage(stage).observe(milliseconds / 1e3)


def measure_memory() -> None:
    """Record this process's memory; each of several processes reports only its own.

    Where the system does not tell, as elsewhere than on Linux, the figure stays 0.
    """
    if _STATM.exists():
        MEMORY.set(int(_STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE"))


@functools.cache
def _stage(name: str) -> Histogram:
    """Histogram of one stage's times, kept because looking it up is slow."""
    return STAGE_SECONDS.labels(name)


def text() -> tuple[str, str]:
    """All figures as text, and their content type."""
    measure_memory()
    registry = REGISTRY
    if "PROMETHEUS_MULTIPROC_DIR" in os.environ:
        registry = CollectorRegistry()
        multiprocess.MultiProcessCollector(registry)  # type: ignore[no-untyped-call]
    return generate_latest(registry).decode(), CONTENT_TYPE_LATEST

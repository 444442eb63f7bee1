"""Figures of a server, its versions, and the text for a bug report."""

from __future__ import annotations

import os
import re
import sys
import urllib.request
from importlib.metadata import requires, version
from pathlib import Path

import pytest
from prometheus_client import REGISTRY
from prometheus_client.parser import text_string_to_metric_families

from abi.scene.scene import Scene, load_scene
from abi.scene.scene_file import parse_bytes
from app.panels.files.bug_report import bug_report, describe_fault
from app.process import metrics
from app.process.versions import version_text, versions
from app.server.server import Server
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, until


def _figures(server: Server) -> dict[str, float]:
    with urllib.request.urlopen(f"{server.url}/metrics", timeout=30) as answer:
        assert answer.headers.get_content_type() == "text/plain"
        text = answer.read().decode()
    return {
        sample.name + "".join(f" {value}" for value in sample.labels.values()): sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


def test_figures_follow_what_a_tab_does(server: Server, tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    before = _figures(server)
    assert before["abi_tabs"] >= 1
    fake.set(session.panels.stages.fields["motion.speed"], 3.1)
    until(lambda: session.plan.scene.motion.speed == 3.1)  # type: ignore[union-attr]
    until(lambda: session.resting)
    after = _figures(server)

    assert after["abi_plan_seconds_count"] > before["abi_plan_seconds_count"]
    assert after["abi_update_seconds_count"] > before["abi_update_seconds_count"]
    for stage in ("timing", "arm"):
        name = f"abi_stage_seconds_count {stage}"
        assert after[name] > before[name]


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells it")
def test_memory_is_that_of_the_process() -> None:
    metrics.text()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    resident = pages * os.sysconf("SC_PAGE_SIZE")
    assert REGISTRY.get_sample_value("abi_memory_bytes") == pytest.approx(resident, rel=0.05)


def test_a_stage_counts_once_for_each_time_it_ran() -> None:
    def count(stage: str) -> float:
        value = REGISTRY.get_sample_value("abi_stage_seconds_count", {"stage": stage})
        return value or 0.0

    metrics.observe_plan(0.1, {}, {"a": 1.0, "b": 0.0})
    metrics.observe_plan(0.1, {"a": 1.0, "b": 0.0}, {"a": 1.0, "b": 2.0})
    assert (count("a"), count("b")) == (1, 1)


def test_versions_are_those_that_are_installed() -> None:
    found = versions()
    assert found["viser"] == version("viser") == "1.1.1"
    assert version_text().startswith("abi, version ")
    assert all(value in version_text() for value in found.values())


def test_versions_are_of_what_is_needed_to_run() -> None:
    needed = {
        re.split(r"[^\w-]", requirement, maxsplit=1)[0]
        for requirement in requires("abi-visualiser") or ()
        if "extra ==" not in requirement
    }
    assert versions().keys() - {"abi", "Python", "system", "cores"} <= needed


def test_a_bug_report_has_versions_times_scene_and_fault(tab: tuple[FakeTab, Session]) -> None:
    _, session = tab
    report = bug_report(session.frame, "KeyError: 'x'")
    assert version_text() in report
    assert "KeyError: 'x'" in report
    scene = report.partition("## Scene\n\n```\n")[2].partition("```")[0]
    assert Scene.from_dict(parse_bytes(scene.encode(), "scene.yaml")) == load_scene("paper")


def test_the_button_sends_it_as_a_file(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    sent: list[tuple[str, bytes]] = []
    monkeypatch.setattr(
        session.client, "send_file_download", lambda name, text, **_: sent.append((name, text))
    )
    fake.set(session.panels.bug_report, True)
    until(lambda: bool(sent))
    assert sent[0][0] == "abi-bug-report.md"
    assert b"## Versions" in sent[0][1]
    assert not session.panels.bug_report.value


def test_a_fault_is_told_by_kind_and_place_without_the_machine_s_folders() -> None:
    try:
        Scene.from_dict({"version": 1}).mesh.nothing  # type: ignore[attr-defined]  # noqa: B018
    except AttributeError as error:
        text = describe_fault(error)
    assert text.startswith("AttributeError: ")
    assert "tests/app/process/test_metrics.py:" in text
    assert "/" not in text.replace("tests/app/process/test_metrics.py", "")

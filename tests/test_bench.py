"""The benchmarks say what they leave out, and measure up to what the program takes."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from abi import compiling
from abi.obstacles.triangle_mesh.mesh_reader import MAX_FACES
from benchmarks import arm, crowds, run, shapes
from benchmarks.report import Row


@pytest.fixture(autouse=True)
def uncompiled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiling, "compile", lambda: None)


def test_a_campaign_without_ompl_says_that_its_rows_are_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(arm, "campaign", lambda *_: [])
    monkeypatch.setattr(arm, "figures", lambda _: [{"method": "whole arm"}])
    monkeypatch.setattr(sys, "argv", ["arm", "0", "--results", str(tmp_path / "arm.jsonl")])
    arm.main()
    assert "OMPL is not installed" in capsys.readouterr().out.splitlines()[0]


def test_crowds_of_every_number_are_planned_with_meshes_among_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: set[tuple[int, bool]] = set()

    def measure(counts: Sequence[int], meshes: float = 0.0) -> list[Row]:
        asked.update((count, meshes > 0) for count in counts)
        return []

    monkeypatch.setattr(crowds, "measure", measure)
    run.PARTS["crowds"]((), 1)
    assert asked == {(count, meshes) for count in crowds.COUNTS for meshes in (False, True)}


def test_shapes_go_up_to_the_largest_mesh_that_is_taken() -> None:
    assert max(shapes.TRIANGLES) == MAX_FACES

from __future__ import annotations

import csv
import errno
import importlib.util
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest

from abi.errors import AbiError
from abi.planner.planner import plan
from abi_sweep import plots, workers
from abi_sweep.journal import Journal
from abi_sweep.row import Row
from abi_sweep.study import Study, varied
from abi_sweep.sweep import JOURNAL, sweep
from abi_sweep.table import summary, write
from tests.thorough import THOROUGH

STUDY = Study.from_dict(
    {
        "version": 1,
        "scenes": ["paper", "no-way", {"boxes": 3, "seeds": 6}],
        "vary": {
            "mesh.pitch": [1.2, 0.9, 0.7],
            "mesh.lattice": ["bcc", "delaunay"],
            "arm.avoid": [False],
        },
    }
)


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    return sweep(STUDY)


def untimed(rows: list[Row]) -> list[Row]:
    return [{name: row[name] for name in row if not name.endswith("_ms")} for row in rows]


def test_rows_are_the_plans(rows: list[Row]) -> None:
    assert len(rows) == STUDY.size
    for row in rows[::5]:
        settings = {name: row[name] for name in STUDY.vary}
        data = plan(varied(STUDY.scene(row["scene"], row["seed"]), settings)).to_dict()
        assert row["complete"] == (data["error"] is None)
        for name in ("path", "taut", "bspline", "quadratic"):
            assert row[name] == (data[name] and data[name]["length"])
        for name in ("bspline", "quadratic"):
            assert row[f"{name}_clearance"] == (data[name] and data[name]["clearance"])
            assert row[f"{name}_proven"] == (data[name] and data[name]["certified"])
        assert row["total_ms"] > 0
        assert row["abi"]
        gaps = [row[f"{name}_gap"] for name in ("path", "taut", "bspline", "quadratic")]
        assert all(gap is None or gap > -1e-9 for gap in gaps)
    assert {row["error"] for row in rows if row["scene"] == "no-way"} == {"no_path"}


@pytest.mark.skipif(not THOROUGH, reason="those of a scheduler get and send the same")
def test_two_dask_workers_find_the_same() -> None:
    # each of the two processes loads all that a plan needs
    few = Study.from_dict({"version": 1, "scenes": ["no-way", {"boxes": 3, "seeds": 3}]})
    assert untimed(sweep(few, workers=2)) == untimed(sweep(few))


@pytest.mark.slow
def test_the_workers_of_a_scheduler_find_the_same(rows: list[Row]) -> None:
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2, processes=False, protocol="tcp", dashboard_address="127.0.0.1:0"
    ) as one:
        assert untimed(sweep(STUDY, scheduler=one.scheduler_address)) == untimed(rows)


@pytest.mark.slow
def test_a_study_goes_on_where_it_was_stopped(rows: list[Row], tmp_path: Path) -> None:
    def stop(done: int, of: int) -> None:
        if done >= 18:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(STUDY, tmp_path, progress=stop)
    journal = tmp_path / JOURNAL
    kept = journal.read_text().splitlines()
    assert 18 <= len(kept) < STUDY.size
    with journal.open("a") as file:
        file.write(kept[0][:40])  # as it is cut off in the middle of a line

    steps: list[int] = []
    assert untimed(sweep(STUDY, tmp_path, progress=lambda done, of: steps.append(done))) == untimed(
        rows
    )
    assert steps[0] == len(kept)
    lines = [json.loads(line) for line in journal.read_text().splitlines()]
    assert len(lines) == len({line["key"] for line in lines}) == STUDY.size


def test_a_changed_study_plans_only_what_is_new(tmp_path: Path) -> None:
    def study(pitches: list[float]) -> Study:
        return Study.from_dict({"version": 1, "scenes": ["paper"], "vary": {"mesh.pitch": pitches}})

    (before,) = sweep(study([1.2]), tmp_path)
    first, second = sweep(study([1.0, 1.2]), tmp_path)
    assert second == before
    assert first["mesh.pitch"] == 1.0
    assert len((tmp_path / JOURNAL).read_text().splitlines()) == 2


def test_rows_of_another_version_do_not_count(tmp_path: Path) -> None:
    study = Study.from_dict({"version": 1, "scenes": ["paper"]})
    (row,) = sweep(study, tmp_path)
    journal = tmp_path / JOURNAL
    journal.write_text(json.dumps({**row, "abi": "0.0.1", "path": 1.0}) + "\n")
    (again,) = sweep(study, tmp_path)
    assert untimed([again]) == untimed([row])


def test_a_full_disk_ends_with_a_sentence_and_keeps_what_was_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(AbiError, match="no space left on device"):
        sweep(STUDY, tmp_path)
    monkeypatch.undo()
    assert len(Journal(tmp_path / JOURNAL).rows) <= 20


@pytest.mark.parametrize("content", ["nonsense\n", "[]\n", '{"scene": "paper"}\n'])
def test_a_file_that_is_no_journal_is_refused(content: str, tmp_path: Path) -> None:
    (tmp_path / JOURNAL).write_text(content)
    with pytest.raises(AbiError, match="no row of a study in line 1"):
        sweep(STUDY, tmp_path)


def test_without_dask_a_sentence_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(AbiError, match="needs Dask") as caught:
        sweep(STUDY, workers=2)
    assert "abi-visualiser[sweep]" in caught.value.hint


@pytest.mark.slow
@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nowhere", "ftp://127.0.0.1:1"])
def test_a_scheduler_that_does_not_answer_is_named(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workers, "_PATIENCE", "500ms")
    with pytest.raises(AbiError, match="does not answer") as caught:
        sweep(STUDY, scheduler=address)
    assert address in caught.value.message


def test_tables_hold_every_value(rows: list[Row], tmp_path: Path) -> None:
    for name in ("plans.csv", "plans.parquet"):
        write(rows, tmp_path / name)
    assert pyarrow.parquet.read_table(tmp_path / "plans.parquet").to_pylist() == rows
    with (tmp_path / "plans.csv").open(newline="") as file:
        read = list(csv.DictReader(file))
    assert read == [{n: "" if v is None else str(v) for n, v in row.items()} for row in rows]


def test_the_summary_is_of_the_rows(rows: list[Row]) -> None:
    table = summary(rows, ["mesh.lattice"])
    assert [line["mesh.lattice"] for line in table] == ["bcc", "delaunay"]
    for line in table:
        group = [row for row in rows if row["mesh.lattice"] == line["mesh.lattice"]]
        assert line["plans"] == len(group)
        gaps = sorted(row["path_gap"] for row in group if row["path_gap"] is not None)
        assert line["path gap [%]"] == pytest.approx(100 * float(np.median(gaps)))
        complete = sum(row["error"] is None for row in group)
        assert line["complete [%]"] == pytest.approx(100 * complete / len(group))


@pytest.mark.slow
def test_lines_of_a_plot_are_medians(rows: list[Row], tmp_path: Path) -> None:
    written = plots.write_plots(rows, STUDY.axes, tmp_path)
    assert [path.name for path in written] == ["gaps.svg", "clearances.svg", "times.svg"]
    assert all(path.read_text().rstrip().endswith("</svg>") for path in written)
    figure: Any = plots._figure(rows, STUDY.axes, plots._FIGURES["gaps"])
    for line, lattice in zip(figure.axes[0].lines, ("bcc", "delaunay"), strict=True):
        expected = [
            100 * np.median([row["path_gap"] for row in group])
            for pitch in (1.2, 0.9, 0.7)
            if (
                group := [
                    row
                    for row in rows
                    if (row["mesh.pitch"], row["mesh.lattice"]) == (pitch, lattice)
                    and row["path_gap"] is not None
                ]
            )
        ]
        np.testing.assert_allclose(line.get_ydata(), expected)


def test_a_plot_that_cannot_be_written_is_a_sentence_and_the_old_one_stays_whole(
    rows: list[Row], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "gaps.svg").write_text("old")
    (tmp_path / "clearances.svg").mkdir()
    with pytest.raises(AbiError, match=r"clearances\.svg' cannot be written \(is a directory\)"):
        plots.write_plots(rows[:6], STUDY.axes, tmp_path)
    assert (tmp_path / "gaps.svg").read_text() != "old"

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    (tmp_path / "gaps.svg").write_text("old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(AbiError, match="no space left on device"):
        plots.write_plots(rows[:6], STUDY.axes, tmp_path)
    assert (tmp_path / "gaps.svg").read_text() == "old"
    assert {path.name for path in tmp_path.iterdir()} == {"gaps.svg", "clearances.svg"}


def test_plots_without_matplotlib_are_left_out(
    rows: list[Row], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert plots.write_plots(rows, STUDY.axes, tmp_path) == []
    with pytest.raises(AbiError, match="needs pyarrow"):
        write(rows, tmp_path / "plans.parquet")

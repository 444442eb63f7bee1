"""The paper's figures are the same in every format, and the table fits where it is read."""

from __future__ import annotations

import csv
import io
import re

import pytest

from abi import assets
from abi.explain.paper.comparison import PaperComparison
from abi.explain.paper.reproduction import compare
from app.cli.reproduce import as_csv, as_markdown, as_table

Rows = list[list[str]]
SIGNS = {"✓": "holds", "≈": "depends on the mesh", "✗": "does not hold"}


@pytest.fixture(scope="module")
def rows() -> tuple[PaperComparison, ...]:
    return compare()


def cells(rows: tuple[PaperComparison, ...]) -> Rows:
    return [[one.section, one.subject, one.printed, one.ours, one.verdict] for one in rows]


def read_table(text: str) -> Rows:
    """Rows of a table whose cells go on in lines without a sign, without any spaces."""
    read: Rows = []
    for line in text.splitlines():
        if not line.startswith("│"):
            continue
        parts = [part.replace(" ", "") for part in line.split("│")[1:-1]]
        if parts[-1]:
            read.append(parts)
        else:
            read[-1] = [a + b for a, b in zip(read[-1], parts, strict=True)]
    return read


@pytest.mark.slow
def test_every_figure_is_in_every_format(rows: tuple[PaperComparison, ...]) -> None:
    given = cells(rows)
    assert list(csv.reader(io.StringIO(as_csv(rows))))[1:] == given
    lines = as_markdown(rows).splitlines()[2:]
    split = [re.split(r"(?<!\\)\|", line)[1:-1] for line in lines]
    assert [[cell.strip().replace(r"\|", "|") for cell in line] for line in split] == given
    table = read_table(as_table(rows))
    section = ""
    for line, row in zip(table, given, strict=True):
        section = line[0] or section
        assert section == row[0].replace(" ", "")
        assert line[1:-1] == [cell.replace(" ", "") for cell in row[1:-1]]
        assert SIGNS[line[-1]] == row[-1]


@pytest.mark.slow
def test_a_table_in_a_file_has_80_columns(rows: tuple[PaperComparison, ...]) -> None:
    assert max(map(len, as_table(rows).splitlines())) <= 80


@pytest.mark.slow
def test_lessons_say_in_how_many_scenes_nodes_alone_fail(
    rows: tuple[PaperComparison, ...],
) -> None:
    (count,) = {one for row in rows for one in re.findall(r"\d+ of \d+ random", row.ours)}
    for name in ("02-graph.yaml", "paper.md"):
        assert f"{count} scenes" in assets.path("lessons", name).read_text(encoding="utf-8")

"""``abi reproduce``: the paper's figures beside ours."""

from __future__ import annotations

import csv
import io
import itertools
from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter
from types import MappingProxyType
from typing import TYPE_CHECKING

import click

from app.cli.output import print_text

if TYPE_CHECKING:
    from abi.explain.paper.comparison import PaperComparison

_FILE_WIDTH = 80  # characters of a table that is written to a file
_SIGNS = {"holds": "✓", "depends on the mesh": "≈", "does not hold": "✗"}
_HEADER = ("where", "what", "printed", "ours", "verdict")


def as_table(rows: Sequence[PaperComparison]) -> str:
    """Format a table as wide as the terminal, or 80 columns without one."""
    from rich.console import Console
    from rich.table import Table

    table = Table(*_HEADER[:-1], "")
    for section, comparisons in itertools.groupby(rows, attrgetter("section")):
        table.add_section()
        for number, row in enumerate(comparisons):
            title = "" if number else section
            table.add_row(title, row.subject, row.printed, row.ours, _SIGNS[row.verdict])
    console = Console()
    if not console.is_terminal:
        console.width = _FILE_WIDTH
    with console.capture() as captured:
        console.print(table)
        console.print("   ".join(f"{sign} {verdict}" for verdict, sign in _SIGNS.items()))
    return captured.get().rstrip("\n")


def as_markdown(rows: Sequence[PaperComparison]) -> str:
    """Format a table as Markdown, one line a row."""
    lines = [_HEADER, ("---",) * len(_HEADER), *map(_cells, rows)]
    escaped = ([cell.replace("|", r"\|") for cell in cells] for cells in lines)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in escaped)


def as_csv(rows: Sequence[PaperComparison]) -> str:
    """Format a table as comma-separated values, one line a row."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([_HEADER, *map(_cells, rows)])
    return text.getvalue().rstrip("\n")


FORMATS: Mapping[str, Callable[[Sequence[PaperComparison]], str]] = MappingProxyType(
    {"table": as_table, "markdown": as_markdown, "csv": as_csv}
)
"""Formatters of the comparison by name."""


@click.command(short_help="Set the paper's numbers beside ours, computed anew.")
@click.option(
    "--format",
    "format_name",
    type=click.Choice(tuple(FORMATS)),
    default="table",
    show_default=True,
    help="How they are written.",
)
def reproduce(format_name: str) -> None:
    """Compare the paper's figures and Table I with our own, computed anew."""
    from abi.explain.paper.reproduction import compare

    print_text(FORMATS[format_name](compare()))


def _cells(row: PaperComparison) -> tuple[str, ...]:
    return row.section, row.subject, row.printed, row.ours, row.verdict

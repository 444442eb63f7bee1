"""``abi reproduce``: the paper's figures beside ours."""

from __future__ import annotations

import itertools
from operator import attrgetter

import click

from app.cli.output import print_text

_FILE_WIDTH = 150  # characters of a table that is written to a file


@click.command(short_help="Set the paper's numbers beside ours, computed anew.")
def reproduce() -> None:
    """Set the paper's figures and Table I beside ours, computed anew, as a table."""
    from rich.console import Console
    from rich.table import Table

    from abi.paper.reproduction import compare

    signs = {"holds": "✓", "depends on the mesh": "≈", "does not hold": "✗"}
    table = Table("where", "what", "printed", "ours", "")
    for section, comparisons in itertools.groupby(compare(), attrgetter("section")):
        table.add_section()
        for number, row in enumerate(comparisons):
            title = "" if number else section
            table.add_row(title, row.subject, row.printed, row.ours, signs[row.verdict])
    console = Console()
    if not console.is_terminal:
        console.width = max(console.width, _FILE_WIDTH)
    with console.capture() as captured:
        console.print(table)
        console.print("   ".join(f"{sign} {verdict}" for verdict, sign in signs.items()))
    print_text(captured.get().rstrip("\n"))

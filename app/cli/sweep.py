"""``abi sweep``: many plans on all cores or on a cluster, as a table and plots."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from abi_sweep.row import Row

_ROUNDING = 1e-9
"""Magnitude below which a number in the printed table is rounding error."""


@click.command(short_help="Plan many scenes under many settings, as a table.")
@click.argument("study", type=click.Path(path_type=Path))
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder for what is found.  [default: the study's name]",
)
@click.option("--workers", type=click.IntRange(1, 1024), help="Processes.  [default: all cores]")
@click.option("--scheduler", help="Address of a Dask scheduler, whose workers plan instead.")
@click.option(
    "--table",
    "table_format",
    default="csv",
    show_default=True,
    type=click.Choice(["csv", "parquet"]),
    help="Format of the table.",
)
def sweep(
    study: Path, out: Path | None, workers: int | None, scheduler: str | None, table_format: str
) -> None:
    """Plan every scene of the file STUDY under all its settings: lengths, gaps, clearances, times.

    Writes a table with a row a plan, and plots. What is found is kept as it comes: the same command
    goes on where it was stopped, and plans only what is new once the study is changed.

    Exit code 0: all is planned, whether or not each scene has a plan; 2: bad input.
    """
    from abi_sweep import plots, table
    from abi_sweep.study import load_study
    from abi_sweep.sweep import sweep as plan_study

    if workers is not None and scheduler is not None:
        raise click.UsageError("--workers and --scheduler exclude each other.")
    plan = load_study(study)
    folder = out or Path(study.stem)
    with _progress(folder) as told:
        rows = plan_study(plan, folder, workers, scheduler, told)
    fields = (plan.axes or ("scene",))[:2]
    path = folder / f"plans.{table_format}"
    table.write(rows, path)
    print_table(table.summary(rows, fields))
    for written in (path, *plots.write_plots(rows, fields, folder)):
        click.echo(f"written: {written}")


@contextlib.contextmanager
def _progress(folder: Path) -> Iterator[Callable[[int, int], None]]:
    """Progress bar on the terminal with the time left; Ctrl+C says how to resume."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    bar = Progress(
        "plans",
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
    )
    line = bar.add_task("plans", total=None)
    try:
        yield functools.partial(_advance, bar, line)
    except KeyboardInterrupt:
        click.echo(f"Stopped; {folder} keeps what is planned, the same command goes on.", err=True)
        raise click.Abort from None
    finally:
        if bar.live.is_started:  # stopping prints an end of line
            bar.stop()


def _advance(bar: Progress, line: TaskID, done: int, of: int) -> None:
    """Advance the bar, which appears once all scenes have been read."""
    bar.start()
    bar.update(line, completed=done, total=of)


def print_table(rows: Sequence[Row]) -> None:
    """Print rows with the same columns."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    names = list(rows[0])
    shown = Table(*map(escape, names))  # rich takes [ms] for markup
    for row in rows:
        shown.add_row(*(escape(_text(row[name])) for name in names))
    console = Console()
    if not console.is_terminal:
        console.width = 150
    console.print(shown)


def _text(value: object) -> str:
    if value is None:
        return "–"
    if isinstance(value, float):
        value = value if abs(value) > _ROUNDING else 0.0
        return f"{value:,.0f}" if value >= 1000 else f"{value:.3g}"
    return str(value)

"""Planning of a study, from its cases to its rows."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from abi_sweep.journal import Journal
from abi_sweep.row import Row
from abi_sweep.study import Study
from abi_sweep.task import tasks
from abi_sweep.workers import rows_of

JOURNAL = "rows.jsonl"
"""Name of the journal in a study's folder."""


def sweep(
    study: Study,
    folder: Path | None = None,
    workers: int | None = 1,
    scheduler: str | None = None,
    progress: Callable[[int, int], object] = lambda done, of: None,
) -> list[Row]:
    """Plan every case of a study; rows in the study's order.

    Args:
        study: what to plan.
        folder: folder in which rows are stored as they come; plans that are there are not made
            again. None stores nothing.
        workers: number of processes on this machine; None for one per core.
        scheduler: address of a Dask scheduler whose workers plan instead.
        progress: called with the number of plans made so far and the total.

    Raises:
        AbiError: a scene or a setting is wrong, the folder cannot be written, or there are no
            workers.
    """
    journal = None if folder is None else Journal(folder / JOURNAL)
    rows: dict[str, Row] = {} if journal is None else journal.rows
    heads, waiting = tasks(study, rows.__contains__)
    made = sum(head["key"] in rows for head in heads)
    progress(made, len(heads))
    for found in rows_of(waiting, workers, scheduler):
        if journal is not None:
            journal.add(found)
        rows.update((row["key"], row) for row in found)
        made += len(found)
        progress(made, len(heads))
    return [{**head, **rows[head["key"]]} for head in heads]

"""Processes that plan a study's tasks: this one, one per core of this machine, or a cluster's.

The last two use Dask, which the extra ``sweep`` installs.
"""

from __future__ import annotations

import contextlib
import importlib.util
import itertools
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from typing import Any

from abi import compiling
from abi.errors import AbiError
from abi_sweep.row import Row
from abi_sweep.task import SweepTask, run

_AHEAD = 4
"""Tasks that wait for each worker's thread."""
_PATIENCE = "15s"


def rows_of(
    tasks: Sequence[SweepTask], workers: int | None, scheduler: str | None
) -> Iterator[list[Row]]:
    """Rows of each task, in the order in which they are done.

    Args:
        tasks: the tasks to plan.
        workers: number of processes on this machine; None for one per core, 1 for this one alone.
        scheduler: address of a Dask scheduler whose workers plan instead.

    Raises:
        AbiError: Dask is missing, the scheduler does not answer, or a worker keeps dying.
    """
    count = workers or os.cpu_count() or 1
    if scheduler is None and (count == 1 or len(tasks) < 2):
        return map(run, tasks)
    if importlib.util.find_spec("distributed") is None:
        raise AbiError(
            "A study on more than one core needs Dask, which is not installed.",
            "pip install 'abi-visualiser[sweep]' brings it; --workers 1 does without.",
        )
    return _distributed(tasks, min(count, len(tasks)), scheduler)


def _distributed(
    tasks: Sequence[SweepTask], count: int, scheduler: str | None
) -> Iterator[list[Row]]:
    """Rows of tasks planned by Dask; only as many are sent ahead as keep the workers busy."""
    from distributed import KilledWorker, as_completed

    with _client(count, scheduler) as client:
        waiting = iter(tasks)
        ahead = _AHEAD * max(sum(client.nthreads().values()), 1)
        running = as_completed(
            client.submit(run, task, pure=False) for task in itertools.islice(waiting, ahead)
        )
        try:
            for done in running:
                yield done.result()
                for task in itertools.islice(waiting, 1):
                    running.add(client.submit(run, task, pure=False))
        except KilledWorker:
            raise AbiError(
                "A worker died again and again, for want of memory perhaps.",
                "What was planned is kept; fewer workers need less.",
            ) from None
        except (OSError, CancelledError):
            raise AbiError(
                "The scheduler is gone.", "What was planned is kept; the same command goes on."
            ) from None


@contextlib.contextmanager
def _client(count: int, scheduler: str | None) -> Iterator[Any]:
    from distributed import Client, LocalCluster

    if scheduler is not None:
        with _connected(scheduler) as client:
            yield client
        return
    compiling.compile()  # once, for all of them
    # over TLS: whoever may talk to a scheduler may run what they like
    cluster = LocalCluster(
        n_workers=count,
        threads_per_worker=1,
        security=True,
        dashboard_address="127.0.0.1:0",
        silence_logs=50,
    )
    with cluster, Client(cluster) as client:
        yield client


def _connected(scheduler: str) -> Any:
    from distributed import Client

    try:
        client = Client(scheduler, timeout=_PATIENCE)
        if client.nthreads():
            return client
        client.close()
    except (OSError, ValueError) as error:
        reason = (str(error) or type(error).__name__).splitlines()[0]
        raise AbiError(
            f"--scheduler {scheduler!r} does not answer ({reason}).",
            "Expected the address that dask scheduler prints, such as tcp://10.0.0.1:8786.",
        ) from None
    raise AbiError(
        f"The scheduler at {scheduler!r} has no workers.",
        "Start some: dask worker ADDRESS --nthreads 1, with abi-visualiser installed.",
    )

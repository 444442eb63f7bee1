"""Tables of a study: all rows as CSV or Parquet, and a short summary."""

from __future__ import annotations

import csv
import importlib.util
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from abi.errors import AbiError
from abi_sweep.result_file import write_result
from abi_sweep.row import Row

FORMATS = ("csv", "parquet")


def write(rows: Sequence[Row], path: Path) -> None:
    """Write the rows, whole or not at all; the ending of ``path`` gives the format.

    Raises:
        AbiError: the file cannot be written, or the library for Parquet is not installed.
    """
    write_result(path, _parquet(rows) if path.suffix == ".parquet" else _csv(rows))


def summary(rows: Sequence[Row], fields: Sequence[str]) -> list[Row]:
    """One row per value of ``fields``: numbers, shares [%], medians of gaps [%] and times [ms].

    Rows keep the order in which their values first occur; no value is None.
    """
    return [
        {
            **dict(zip(fields, values, strict=True)),
            "plans": len(group),
            "complete [%]": share(group, "complete"),
            "B-spline proven [%]": share(group, "bspline_proven"),
            "path gap [%]": _percent(quantile(group, "path_gap", 0.5)),
            "taut gap [%]": _percent(quantile(group, "taut_gap", 0.5)),
            "B-spline gap [%]": _percent(quantile(group, "bspline_gap", 0.5)),
            "time [ms]": quantile(group, "total_ms", 0.5),
            "p95 [ms]": quantile(group, "total_ms", 0.95),
        }
        for values, group in grouped(rows, fields).items()
    ]


def grouped(rows: Sequence[Row], fields: Sequence[str]) -> dict[tuple[str, ...], list[Row]]:
    """Rows by the values of some fields, in the order in which the values first occur."""
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(str(row[field]) for field in fields), []).append(row)
    return groups


def quantile(rows: Sequence[Row], column: str, part: float) -> float | None:
    """Quantile of a column among the rows that have it; None without any."""
    found = [row[column] for row in rows if row.get(column) is not None]
    return float(np.quantile(found, part)) if found else None


def share(rows: Sequence[Row], column: str) -> float:
    """Percentage of the rows in which a column is true."""
    return 100 * sum(row.get(column) is True for row in rows) / len(rows)


def columns(rows: Sequence[Row]) -> list[str]:
    """Names of all columns, in the order in which they first occur."""
    return list(dict.fromkeys(name for row in rows for name in row))


def _csv(rows: Sequence[Row]) -> bytes:
    text = io.StringIO()
    writer = csv.DictWriter(text, columns(rows), lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: _plain(value) for name, value in row.items()} for row in rows)
    return text.getvalue().encode()


def _parquet(rows: Sequence[Row]) -> bytes:
    if importlib.util.find_spec("pyarrow") is None:
        raise AbiError(
            "A Parquet file needs pyarrow, which is not installed.",
            "pip install 'abi-visualiser[sweep]' brings it; --table csv does without.",
        )
    import pyarrow
    import pyarrow.parquet

    names = columns(rows)
    table = pyarrow.table({name: [_plain(row.get(name)) for row in rows] for name in names})
    sink = io.BytesIO()
    pyarrow.parquet.write_table(table, sink)
    return sink.getvalue()


def _plain(value: Any) -> Any:
    """The value, lists and mappings as JSON."""
    return json.dumps(value) if isinstance(value, list | tuple | dict) else value


def _percent(part: float | None) -> float | None:
    return None if part is None else 100 * part

"""Journal of a study: the rows so far, one per line, from which a stopped study resumes."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from abi.errors import AbiError
from abi_sweep.result_file import unwritable
from abi_sweep.row import Row, versions


class Journal:
    """Rows in a file of JSON lines, to which rows are only appended.

    Attributes:
        rows: rows by the key of their plan; those of another version of ABI are ignored.
    """

    def __init__(self, path: Path) -> None:
        """Read what is there; a line that was cut off when a study was stopped is dropped.

        Raises:
            AbiError: the file cannot be read or made, or is none of a study.
        """
        self.path = path
        self.rows: dict[str, Row] = {}
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            content = path.read_bytes() if path.exists() else b""
            whole = content.rfind(b"\n") + 1
            if whole < len(content):
                os.truncate(path, whole)
        except OSError as error:
            raise unwritable(self.path, error) from None
        for number, line in enumerate(content[:whole].splitlines(), start=1):
            row = self._row(number, line)
            if row.get("abi") == versions()["abi"]:
                self.rows[row["key"]] = row

    def add(self, rows: Sequence[Row]) -> None:
        """Write rows and wait until they are on the disk.

        Raises:
            AbiError: they cannot be written; the study can be resumed later.
        """
        lines = "".join(f"{json.dumps(row, allow_nan=False)}\n" for row in rows)
        try:
            with self.path.open("ab") as file:
                file.write(lines.encode())
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise unwritable(self.path, error) from None
        self.rows.update((row["key"], row) for row in rows)

    def _row(self, number: int, line: bytes) -> Row:
        try:
            row: Any = json.loads(line)
            if isinstance(row, dict) and isinstance(row["key"], str):
                return row
        except (ValueError, KeyError, RecursionError):
            pass
        raise AbiError(
            f"{str(self.path)!r} has no row of a study in line {number}.",
            "Remove the file, or name another folder.",
        )

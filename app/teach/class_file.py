"""File that preserves a class beyond the server's end, and the table of its results."""

from __future__ import annotations

import contextlib
import hashlib
from pathlib import Path

import msgspec

from abi.atomic_file import replace_file
from abi.user_cache import user_cache
from app.teach.class_table import table
from app.teach.poll import Record

_BOM = "\ufeff"
"""Byte order mark by which spreadsheets recognise UTF-8."""


class ClassFile:
    """File of a class's record, and of its results if they are kept."""

    def __init__(self, record: Path, results: Path | None = None) -> None:
        """Use a file for the record; with ``results``, the record is kept beside that table."""
        self._record, self._results = record, results

    @classmethod
    def beside(cls, results: Path) -> ClassFile:
        """The record's file beside the table of results."""
        return cls(results.with_name(f"{results.name}.record"), results)

    @classmethod
    def of_secret(cls, secret: str) -> ClassFile:
        """The record's file for a teacher's secret, in the user's cache.

        Raises:
            OSError: this user has no such folder.
        """
        folder = user_cache() / "classes"
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        return cls(folder / hashlib.sha256(secret.encode()).hexdigest()[:24])

    def read(self) -> Record:
        """Read the record; an empty one if it is missing or damaged."""
        try:
            return msgspec.json.decode(self._record.read_bytes(), type=Record)
        except (OSError, ValueError, msgspec.MsgspecError):
            return Record()

    def write(self, record: Record) -> None:
        """Write record and table.

        Raises:
            OSError: they cannot be written.
        """
        replace_file(self._record, msgspec.json.encode(record))
        if self._results is not None:
            text = _BOM + table(record.asked, record.words)
            replace_file(self._results, text.encode())

    def end(self) -> None:
        """Delete the record, unless the results are kept."""
        if self._results is None:
            with contextlib.suppress(OSError):
                self._record.unlink()

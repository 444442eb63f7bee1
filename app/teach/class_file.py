"""Files that preserve a class beyond the server's end: its record, and the table of its results."""

from __future__ import annotations

import hashlib
from pathlib import Path

import msgspec

from abi.atomic_file import replace_file
from abi.user_cache import user_cache
from app.teach.class_table import table
from app.teach.poll import Record

_BOM = "\ufeff"
"""Byte order mark by which spreadsheets recognise UTF-8."""


def record_beside(results: Path) -> Path:
    """The record's file beside a table of results."""
    return results.with_name(f"{results.name}.record")


def record_of_secret(secret: str) -> Path:
    """The record's file for a teacher's secret, in the user's cache.

    Raises:
        OSError: this user has no such folder.
    """
    folder = user_cache() / "classes"
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    return folder / hashlib.sha256(secret.encode()).hexdigest()[:24]


def read_record(file: Path) -> Record:
    """Read a record; an empty one if it is missing or damaged."""
    try:
        return msgspec.json.decode(file.read_bytes(), type=Record)
    except (OSError, ValueError, msgspec.MsgspecError):
        return Record()


def write_record(file: Path, record: Record, results: Path | None) -> None:
    """Write a record and, where its results are kept, their table.

    Raises:
        OSError: they cannot be written.
    """
    replace_file(file, msgspec.json.encode(record))
    if results is not None:
        text = _BOM + table(record.asked, record.words)
        replace_file(results, text.encode())

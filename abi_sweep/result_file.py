"""Files of what a study found, each whole or not there."""

from __future__ import annotations

from pathlib import Path

from abi.atomic_file import replace_file
from abi.errors import AbiError


def write_result(path: Path, content: bytes) -> None:
    """Write a file in one step; one that was there stays whole on failure.

    Raises:
        AbiError: it cannot be written.
    """
    try:
        replace_file(path, content)
    except OSError as error:
        raise unwritable(path, error) from None


def unwritable(path: Path, error: OSError) -> AbiError:
    """The sentence for a file that cannot be written."""
    reason = (error.strerror or "not writable").lower()
    return AbiError(f"{str(path)!r} cannot be written ({reason}).")

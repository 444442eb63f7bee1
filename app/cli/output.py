"""Output of a command, on the terminal or into a file."""

from __future__ import annotations

import codecs
import errno
import io
import os
import sys
from pathlib import Path

import click

_NOT_WRITTEN = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF)
"""Errors of writing to an open file, whose messages do not name it."""


_SPELLED = "abi.spelled"
"""Name of our error handler for characters that the output cannot encode."""
_SYSTEMS = ("strict", "surrogateescape", "backslashreplace")
"""Error handlers that the system chooses by default."""
_SPELLINGS = {
    "✓": "+",
    "✗": "x",
    "≈": "~",
    "×": "x",
    "·": ".",
    "°": " deg",
    "²": "2",
    "³": "3",
    "…": "...",
    "½": "1/2",
    "≤": "<=",
    "≥": ">=",
    "→": "->",
    "±": "+-",
    "π": "pi",
    "σ": "sigma",
    **dict.fromkeys("−–—", "-"),
}
"""Replacements for our symbols where the output cannot encode them."""


def print_text(text: str) -> None:
    """Print ``text``; a closed pipe is not an error."""
    if sys.__stdout__ is None:
        raise click.ClickException("The output cannot be printed (standard output is closed).")
    try:
        print(text, flush=True)
    except BrokenPipeError:
        _discard()
    except OSError as error:
        raise click.ClickException(lost_output(error)) from None


def ensure_streams() -> None:
    """Make the standard streams accept any character.

    A closed one gets a place to write to; whoever must print checks it. One of another encoding
    than UTF-8 gets signs that it does not have spelled, and other letters as their numbers.
    """
    codecs.register_error(_SPELLED, _spelled)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        elif isinstance(stream, io.TextIOWrapper) and stream.errors in _SYSTEMS:
            stream.reconfigure(errors=_SPELLED)


def _spelled(error: UnicodeError) -> tuple[str | bytes, int]:
    """Replacement of the first character that cannot be encoded, and where to continue."""
    assert isinstance(error, UnicodeEncodeError)
    letter = error.object[error.start]
    if "\udc80" <= letter <= "\udcff":  # stands for a byte of a file's name that is no text
        return letter.encode("utf-8", "surrogateescape"), error.start + 1
    spelling = _SPELLINGS.get(letter) or letter.encode("ascii", "backslashreplace").decode()
    return spelling, error.start + 1


def lost_output(error: OSError) -> str:
    """Sentence on why the printed output is lost; empty if the error has another cause."""
    if error.filename is not None or error.errno not in _NOT_WRITTEN:
        return ""
    _discard()
    return f"The output cannot be printed ({cause(error, 'not writable')})."


def _discard() -> None:
    """Discard unwritten output, which Python would otherwise try to write at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def write_text(path: Path, text: str) -> None:
    """Write ``text`` to the file of ``--out``, as a whole or not at all."""
    from abi.atomic_file import replace_file  # the method takes a second to load

    try:
        replace_file(path, f"{text}\n".encode())
    except OSError as error:
        reason = cause(error, "not writable")
        raise click.ClickException(f"--out: {str(path)!r} cannot be written ({reason}).") from None


def cause(error: OSError, default: str) -> str:
    """Cause of an error in a few words; ``default`` where the system names none."""
    return (error.strerror or default).lower()

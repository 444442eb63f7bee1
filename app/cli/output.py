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
"""Errors of writing into a file that is open, which do not name it."""


_SPELLED = "abi.spelled"
"""Name of our way to encode letters that the output does not have."""
_SYSTEMS = ("strict", "surrogateescape", "backslashreplace")
"""Ways to encode them that the system takes unless somebody asks for another."""
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
"""How signs of ours are written where the output has only others."""


def print_text(text: str) -> None:
    """Print ``text``; a reader that has closed the pipe is no fault."""
    if sys.__stdout__ is None:
        raise click.ClickException("The output cannot be printed (standard output is closed).")
    try:
        print(text, flush=True)
    except BrokenPipeError:
        _discard()
    except OSError as error:
        raise click.ClickException(lost_output(error)) from None


def ensure_streams() -> None:
    """Make standard streams take whatever is printed.

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
    """What stands for the first letter that cannot be encoded, and where to go on."""
    assert isinstance(error, UnicodeEncodeError)
    letter = error.object[error.start]
    if "\udc80" <= letter <= "\udcff":  # stands for a byte of a file's name that is no text
        return letter.encode("utf-8", "surrogateescape"), error.start + 1
    spelling = _SPELLINGS.get(letter) or letter.encode("ascii", "backslashreplace").decode()
    return spelling, error.start + 1


def lost_output(error: OSError) -> str:
    """Sentence on why what is printed is lost; empty if the error comes from anything else."""
    if error.filename is not None or error.errno not in _NOT_WRITTEN:
        return ""
    _discard()
    return f"The output cannot be printed ({cause(error, 'not writable')})."


def _discard() -> None:
    """Drop what is left of the output, since Python would try to write it at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def write_text(path: Path, text: str) -> None:
    """Write ``text`` into the file that ``--out`` names, whole or not at all."""
    from abi.atomic_file import replace_file  # the method takes a second to load

    try:
        replace_file(path, f"{text}\n".encode())
    except OSError as error:
        reason = cause(error, "not writable")
        raise click.ClickException(f"--out: {str(path)!r} cannot be written ({reason}).") from None


def cause(error: OSError, default: str) -> str:
    """Cause of an error in a few words; ``default`` where the system names none."""
    return (error.strerror or default).lower()

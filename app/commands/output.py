"""Output of a command, on the terminal or into a file."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import click


def print_text(text: str) -> None:
    """Print ``text``; a reader that has closed the pipe is no fault."""
    try:
        click.echo(text)
        sys.stdout.flush()
    except BrokenPipeError:
        # the reader has closed the pipe, as head does; Python would flush once more at its end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        reason = cause(error, "not writable")
        raise click.ClickException(f"The plan cannot be printed ({reason}).") from None


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

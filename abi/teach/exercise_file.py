"""Python files of exercises: finding the functions in one, and writing the beginning of one."""

from __future__ import annotations

import ast
import textwrap
from collections.abc import Sequence
from pathlib import Path

from abi.errors import ArgumentError
from abi.teach.catalogue import exercises
from abi.teach.exercise import Exercise

_WIDTH = 90


def exercises_in(file: Path) -> tuple[Exercise, ...]:
    """The exercises whose functions a file defines, in the order of the stages, without running it.

    Raises:
        ArgumentError: the file cannot be read, is no Python, or has no function of an exercise.
    """
    try:
        tree = ast.parse(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError):
        raise ArgumentError("file", str(file), "a Python file that can be read") from None
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        place = f"line {error.lineno}: " if isinstance(error, SyntaxError) else ""
        wanted = f"a Python file without errors; {place}{error}"
        raise ArgumentError("file", str(file), wanted) from None
    defined: set[str] = set()
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ImportFrom, ast.Import)):
            names = [node] if isinstance(node, ast.FunctionDef) else node.names
            defined |= {getattr(one, "asname", None) or one.name for one in names}
        elif isinstance(node, ast.Assign):
            defined |= {one.id for one in node.targets if isinstance(one, ast.Name)}
    found = tuple(one for name, one in exercises().items() if name in defined)
    if not found:
        wanted = f"a file with a function of that name: {', '.join(exercises())}"
        raise ArgumentError("file", str(file), wanted)
    return found


def beginning(asked: Sequence[Exercise]) -> str:
    """Text of a file with the tasks of exercises as comments, and functions to complete."""
    parts = []
    for one in asked:
        title = one.title if one.title.endswith("?") else f"{one.title}."
        task = textwrap.wrap(f"{title} {one.task}", _WIDTH)
        parts.append("\n".join(f"# {line}" for line in task) + "\n" + one.starter.strip() + "\n")
    text = "\n\n".join(parts)
    imports = [line for line in text.splitlines() if line.startswith("import ")]
    body = "\n".join(line for line in text.splitlines() if not line.startswith("import "))
    head = "\n".join(dict.fromkeys(imports))
    return f"{head}\n\n\n{body.strip()}\n".lstrip()

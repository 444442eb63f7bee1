"""A name means one thing, and what is documented can be read alone."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]


@cache
def _modules() -> dict[str, ast.Module]:
    files = [path for folder in ("abi", "app") for path in sorted((ROOT / folder).rglob("*.py"))]
    return {
        path.relative_to(ROOT).as_posix(): ast.parse(path.read_text(encoding="utf-8"))
        for path in files
    }


def _classes() -> Iterator[tuple[str, str]]:
    for file, tree in _modules().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                yield node.name, file


def test_no_two_classes_have_the_same_name() -> None:
    files = defaultdict(list)
    for name, file in _classes():
        files[name].append(file)
    assert len(files) > 300
    assert {name: those for name, those in files.items() if len(those) > 1} == {}


def test_a_docstring_can_be_read_without_its_neighbours() -> None:
    texts = [
        (file, ast.get_docstring(node) or "")
        for file, tree in _modules().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
    ]
    assert len(texts) > 2000
    assert [one for one in texts if one[1].startswith(("The same", "As before", "Of a "))] == []

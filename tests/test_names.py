"""A name means one thing, and what is documented can be read alone."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

Documented = ast.Module | ast.ClassDef | ast.FunctionDef


def _documented() -> Iterator[tuple[str, Documented]]:
    """Every module, class and function, and its file."""
    for folder in ("abi", "abi_sweep", "app"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            file = path.relative_to(ROOT).as_posix()
            waiting: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
            while waiting:
                node = waiting.pop()
                if isinstance(node, Documented):
                    yield file, node
                # expressions hold none of them, and most of a file
                children = ast.iter_child_nodes(node)
                waiting += [child for child in children if not isinstance(child, ast.expr)]


@pytest.mark.slow
def test_no_two_classes_have_the_same_name_and_a_docstring_can_be_read_without_its_neighbours() -> (
    None
):
    files, texts = defaultdict(list), []
    for file, node in _documented():
        texts.append((file, ast.get_docstring(node) or ""))
        if isinstance(node, ast.ClassDef):
            files[node.name].append(file)
    assert len(files) > 300
    assert {name: those for name, those in files.items() if len(those) > 1} == {}
    assert len(texts) > 2000
    assert [one for one in texts if one[1].startswith(("The same", "As before", "Of a "))] == []

"""Every public name that takes arrays to a kernel checks them first: read from the source."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import abi

pytestmark = pytest.mark.slow
ROOT = Path(abi.__file__).parent
ARRAYS = ("FloatArray", "IntArray", "BoolArray", "ByteArray", "ArrayLike", "NDArray")

_MADE = "def __post_init__"

RESULTS = {
    *("ArmClearance", "ArmMotion", "Certificate", "ChainJointPath", "Edges"),
    *(
        "JointRates",
        "JointSearch",
        "LimitsKept",
        "Reason",
        "SearchResult",
    ),
    *("SearchResult", "SearchTrace", "Shells", "Solid", "TautPath"),
}
"""Dataclasses that hold what was computed: who hands their arrays on has them checked again."""
EXACT = {"ExactMesh"}
"""Those checked in exact numbers."""


@cache
def modules() -> dict[str, ast.Module]:
    """The source of all modules but the kernels'."""
    return {
        path.relative_to(ROOT).with_suffix("").as_posix(): ast.parse(path.read_text("utf-8"))
        for path in ROOT.rglob("*.py")
        if not path.stem.endswith("_kernels")
    }


def has_array(annotation: ast.expr | None) -> bool:
    return annotation is not None and any(one in ast.unparse(annotation) for one in ARRAYS)


def kernels_of(module: ast.Module) -> set[str]:
    """Names of the kernels that a module imports, and of the modules they are in."""
    found = set()
    for node in ast.walk(module):
        if isinstance(node, ast.ImportFrom) and node.module:
            of_kernels = node.module.endswith("_kernels")
            found |= {
                one.asname or one.name
                for one in node.names
                if (of_kernels and one.name.islower()) or one.name.endswith("_kernels")
            }
    return found


def calls(function: ast.FunctionDef) -> Iterator[str]:
    """First names of what a function calls: f of f(x), and self.f or m of m.f(x)."""
    for node in ast.walk(function):
        if isinstance(node, ast.Call):
            name = ast.unparse(node.func)
            yield name if name.startswith("self.") else name.partition(".")[0]


def functions(module: ast.Module) -> Iterator[tuple[str, str, ast.FunctionDef]]:
    """Class, name as it is called within the module, and source of each function."""
    for node in module.body:
        if isinstance(node, ast.FunctionDef):
            yield "", node.name, node
        elif isinstance(node, ast.ClassDef):
            for one in node.body:
                if isinstance(one, ast.FunctionDef):
                    yield node.name, f"self.{one.name}", one


def unchecked_functions(module: ast.Module) -> Iterator[str]:
    """Public functions that take arrays and reach a kernel, but check nothing on the way."""
    kernels = kernels_of(module)
    if not kernels:
        return
    known = {name: source for _, name, source in functions(module)}
    for owner, name, source in functions(module):
        given = [*source.args.args, *source.args.kwonlyargs]
        is_public = not owner.startswith("_") and not source.name.startswith("_")
        if not is_public or not any(has_array(one.annotation) for one in given):
            continue
        # what it calls of its own module is looked at, too, if it is private
        reached, waiting = {name}, [name]
        while waiting:
            below = {one for one in calls(known[waiting.pop()]) if one in known} - reached
            waiting += (private := [one for one in below if "_" in (one[0], one[5:6])])
            reached |= set(private)
        called = {one for part in reached for one in calls(known[part])}
        if called & kernels and "arguments" not in called:
            yield f"{owner}.{name}".removeprefix(".").replace("self.", "")


def unchecked_classes(module: ast.Module) -> Iterator[str]:
    """Public dataclasses with arrays that check none of them as they are made."""
    for node in module.body:
        if not isinstance(node, ast.ClassDef) or node.name.startswith("_"):
            continue
        fields = [one.annotation for one in node.body if isinstance(one, ast.AnnAssign)]
        is_dataclass = any("dataclass" in ast.unparse(one) for one in node.decorator_list)
        made = [ast.unparse(one) for one in node.body if ast.unparse(one).startswith(_MADE)]
        checks = any("arguments." in one for one in made)
        if is_dataclass and any(map(has_array, fields)) and not checks:
            yield node.name


def test_public_functions_check_arrays_before_kernels_read_them() -> None:
    found = {path: [*unchecked_functions(module)] for path, module in modules().items()}
    assert {path: names for path, names in found.items() if names} == {}


def test_dataclasses_with_arrays_check_them_or_are_known_to_hold_results() -> None:
    found = {name for module in modules().values() for name in unchecked_classes(module)}
    assert found == RESULTS | EXACT


def test_a_function_without_a_check_is_found() -> None:
    text = """
from abi.search.search_kernels import best_first

def wanted(points: FloatArray) -> None:
    _inner(points)

def _inner(points: FloatArray) -> None:
    best_first(points)

def checked(points: FloatArray) -> None:
    best_first(arguments.points("points", points))
"""
    assert [*unchecked_functions(ast.parse(text))] == ["wanted"]

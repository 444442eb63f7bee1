"""The workflows run what there is, on what the package allows, with actions that cannot change."""

from __future__ import annotations

import re
import shlex
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from packaging.specifiers import SpecifierSet
from ruamel.yaml import YAML

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / ".github" / "workflows"
FILES = sorted(FOLDER.glob("*.yml"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
ACTION = re.compile(r"uses: (\S+)@(\S+)(?: # (v\d+\.\d+\.\d+))?$", re.MULTILINE)


def _jobs(file: Path) -> dict[str, Any]:
    return dict(YAML(typ="safe", pure=True).load(file)["jobs"])


def _commands() -> Iterator[str]:
    """Every command that a step or a row of a matrix names."""
    for file in FILES:
        for job in _jobs(file).values():
            yield from (step["run"] for step in job["steps"] if "run" in step)
            matrix = job.get("strategy", {}).get("matrix", {})
            yield from matrix.get("command", [])
            yield from (row["command"] for row in matrix.get("include", []) if "command" in row)


def test_every_action_is_pinned_by_its_hash_with_one_version_beside_it() -> None:
    pins: dict[str, set[tuple[str, str]]] = {}
    for file in FILES:
        text = file.read_text(encoding="utf-8")
        found = ACTION.findall(text)
        assert len(found) == text.count("uses:")
        for action, pin, version in found:
            assert re.fullmatch("[0-9a-f]{40}", pin), action
            assert version, action
            pins.setdefault(action, set()).add((pin, version))
    assert pins
    assert {action: len(versions) for action, versions in pins.items()} == dict.fromkeys(pins, 1)


def test_tests_run_on_the_oldest_python_allowed_and_on_every_later_one() -> None:
    allowed = SpecifierSet(PROJECT["requires-python"])
    matrix = _jobs(FOLDER / "ci.yml")["test"]["strategy"]["matrix"]
    minors = [int(version.removeprefix("3.")) for version in matrix["python"]]
    assert f"3.{minors[0] - 1}" not in allowed
    assert minors == list(range(minors[0], minors[-1] + 1))
    assert {version in allowed for version in matrix["python"]} == {True}
    others = {row["python"] for row in matrix["include"]}
    assert others == {matrix["python"][0], matrix["python"][-1]}


@pytest.mark.parametrize("command", sorted(set(_commands())))
def test_every_command_is_there(command: str) -> None:
    program, *arguments = shlex.split(command)
    if program == "make":
        target = arguments[0].replace("${{", "").split()[0]
        makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
        assert re.search(rf"^[\w -]*{re.escape(target)}[\w -]*:", makefile, re.MULTILINE)
    elif program == ".venv/bin/python":
        module = ROOT.joinpath(*arguments[1].split("."))
        assert arguments[0] == "-m"
        assert arguments[1] == "hatchling" or module.with_suffix(".py").is_file()
    elif program.startswith(("tools/", ".ci/")):
        assert (ROOT / program).stat().st_mode & 0o111
    else:
        assert program in {"gh", "${{"}


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_workflow_may_only_read_and_every_job_ends(file: Path) -> None:
    assert YAML(typ="safe", pure=True).load(file)["permissions"] == {"contents": "read"}
    assert all(job["timeout-minutes"] <= 60 for job in _jobs(file).values())
    writing = [name for name, job in _jobs(file).items() if "permissions" in job]
    assert writing == (["publish"] if file.stem == "release" else [])

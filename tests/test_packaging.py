"""Each way to install or to try the program says what ``pyproject.toml`` says."""

from __future__ import annotations

import importlib
import json
import re
import shlex
import subprocess
import tomllib
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name
from ruamel.yaml import YAML

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
RUNS = SpecifierSet(PROJECT["requires-python"])


def _text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def _bounds(requirements: list[str]) -> dict[str, SpecifierSet]:
    """Specifiers by the name of the package."""
    found = [Requirement(one) for one in requirements]
    return {canonicalize_name(one.name): one.specifier for one in found}


@pytest.mark.parametrize(("name", "target"), PROJECT["scripts"].items())
def test_every_command_runs_a_function(name: str, target: str) -> None:
    module, _, function = target.partition(":")
    assert callable(getattr(importlib.import_module(module), function))


def test_a_command_is_named_as_the_package_so_that_uvx_and_pipx_run_it() -> None:
    assert PROJECT["scripts"][PROJECT["name"]] == PROJECT["scripts"]["abi"]
    named = re.findall(r"`(?:uvx|uvx --from \.|pipx run) (\w\S*)`", _text("docs/install.md"))
    assert len(named) == 3
    assert set(named) == {PROJECT["name"]}


class TestConda:
    recipe: Any = YAML(typ="safe", pure=True).load(ROOT / "conda" / "recipe.yaml")

    def test_names_version_licence_and_commands_of_the_package(self) -> None:
        assert self.recipe["package"] == {key: PROJECT[key] for key in ("name", "version")}
        about = self.recipe["about"]
        assert about["license"] == PROJECT["license"]
        assert about["summary"] == PROJECT["description"]
        assert (ROOT / about["license_file"]).is_file()
        points = dict(one.split(" = ") for one in self.recipe["build"]["python"]["entry_points"])
        assert points == PROJECT["scripts"]

    def test_asks_for_the_packages_and_bounds_that_pip_asks_for(self) -> None:
        needed = _bounds([one.replace(" ", "", 1) for one in self.recipe["requirements"]["run"]])
        assert needed.pop("python") == RUNS
        assert needed == _bounds(PROJECT["dependencies"])

    def test_builds_with_what_the_build_needs_and_the_oldest_python(self) -> None:
        host = _bounds(
            [
                one.replace(" ", "==", 1) if "*" in one else one.replace(" ", "")
                for one in self.recipe["requirements"]["host"]
            ]
        )
        build = tomllib.loads(_text("pyproject.toml"))["build-system"]["requires"]
        assert _bounds(build).items() <= host.items()
        assert str(host["python"]) == "==3.11.*"


class TestBinder:
    def test_installs_this_checkout_with_extras_that_there_are(self) -> None:
        lines = _text(".binder/requirements.txt").splitlines()
        (asked,) = [line for line in lines if not line.startswith("#")]
        extras = re.fullmatch(r"\.\[(\w+)\]", asked)
        assert extras
        assert "jupyter-server-proxy" in _bounds(EXTRAS[extras[1]])

    def test_has_a_python_that_the_package_allows(self) -> None:
        version = _text(".binder/runtime.txt").strip().removeprefix("python-")
        assert version in RUNS

    @pytest.mark.parametrize("name", ["postBuild", "start"])
    def test_its_scripts_can_be_run(self, name: str) -> None:
        script = ROOT / ".binder" / name
        assert script.stat().st_mode & 0o111
        subprocess.run(["bash", "-n", script], check=True)

    def test_kernels_are_those_for_the_processor_that_it_starts_on(self) -> None:
        script = ROOT / ".binder" / "start"
        seen = subprocess.run([script, "env"], capture_output=True, text=True, check=True).stdout
        told = [line for line in seen.splitlines() if line.startswith("NUMBA_CPU_NAME=")]
        assert told == ["NUMBA_CPU_NAME=generic"]
        assert f"export {told[0]}\n" in _text(".binder/postBuild")


class TestDevcontainer:
    settings = json.loads((ROOT / ".devcontainer" / "devcontainer.json").read_text("utf-8"))

    def test_its_image_is_described_here_and_has_a_python_that_the_package_allows(self) -> None:
        image = _text(f".devcontainer/{self.settings['build']['dockerfile']}")
        (version,) = re.findall(r"^FROM python:([\d.]+)-slim$", image, re.MULTILINE)
        assert version in RUNS
        assert f"USER {self.settings['remoteUser']}\n" in image

    def test_its_commands_are_targets_of_the_makefile(self) -> None:
        for command in ("postCreateCommand", "postAttachCommand"):
            make, target, *_ = shlex.split(self.settings[command])
            assert make == "make"
            assert re.search(rf"^{target}:", _text("Makefile"), re.MULTILINE)

    def test_it_shows_the_port_that_the_server_takes(self) -> None:
        from app.cli.serve import serve

        (port,) = self.settings["forwardPorts"]
        assert port == serve.make_context("serve", []).params["port"]
        assert set(self.settings["portsAttributes"]) == {str(port)}


def test_the_notebook_installs_the_package_where_it_is_missing() -> None:
    cells = json.loads(_text("examples/notebook/tour.ipynb"))["cells"]
    first = next(cell for cell in cells if cell["cell_type"] == "code")
    (asked,) = re.findall(r"%pip install --quiet (\S+)", "".join(first["source"]))
    wanted = Requirement(asked)
    assert wanted.name == PROJECT["name"]
    assert "matplotlib" in set().union(*(_bounds(EXTRAS[extra]) for extra in wanted.extras))

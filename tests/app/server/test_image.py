"""The Dockerfile line by line: what can be run outside a container is run as the image runs it."""

from __future__ import annotations

import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from app.cli.serve import serve
from tests.app.fake_tab import FakeTab, until
from tests.ports import free_port

ROOT = Path(__file__).parents[3]


def _instructions() -> list[tuple[str, str]]:
    """Names and arguments of the Dockerfile's instructions, those of one line on one."""
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    whole = "\n".join(line for line in text.splitlines() if not line.startswith("#"))
    lines = re.sub(r"\\\n\s*", "", whole).splitlines()
    return [(line.split()[0], line.partition(" ")[2].strip()) for line in lines if line]


def _all(name: str) -> list[str]:
    return [rest for instruction, rest in _instructions() if instruction == name]


def _environment() -> dict[str, str]:
    """Values that the last ENV sets, without the folders that only the image has."""
    pairs = (pair.partition("=") for pair in _all("ENV")[-1].split())
    return {name: value for name, _, value in pairs if name != "PATH"}


def _command() -> list[str]:
    command: list[str] = json.loads(_all("CMD")[-1])
    return command


def _health_check(port: int) -> int:
    """Exit code of the image's health check, asking ``port``."""
    program, *arguments = json.loads(_all("HEALTHCHECK")[0].partition("CMD ")[2])
    assert program == "python"
    asked = [argument.replace(":8080/", f":{port}/") for argument in arguments]
    return subprocess.run([sys.executable, *asked], stderr=subprocess.DEVNULL).returncode


def test_only_instructions_that_are_looked_at_here_are_used() -> None:
    known = {"FROM", "RUN", "ENV", "WORKDIR", "COPY", "USER", "EXPOSE", "STOPSIGNAL"}
    assert {name for name, _ in _instructions()} == known | {"HEALTHCHECK", "CMD"}


def test_what_is_copied_is_there_and_has_all_that_is_built() -> None:
    ignored = (ROOT / ".dockerignore").read_text().splitlines()
    assert ignored[0] == "*"
    sent = {line[1:] for line in ignored if line.startswith("!")}
    assert all((ROOT / name).exists() for name in sent)
    copied = [rest.split() for rest in _all("COPY")]
    assert ["requirements.lock", "."] in copied
    assert [".", "."] in copied
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wheel = project["tool"]["hatch"]["build"]["targets"]["wheel"]
    needed = {*wheel["packages"], *wheel["force-include"], project["project"]["readme"]}
    needed.add(wheel["hooks"]["custom"]["path"])
    assert needed | {*project["project"]["license-files"], "requirements.lock"} <= sent


def test_python_and_locked_packages_fit_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    least = project["project"]["requires-python"].removeprefix(">=")
    assert {rest.split()[0] for rest in _all("FROM")} == {f"python:{least}-slim"}
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    names = re.findall(r"^([a-z0-9._-]+)==", lock, re.MULTILINE)
    blocks = re.split(r"^(?=[a-z0-9._-]+==)", lock, flags=re.MULTILINE)[1:]
    assert len(blocks) == len(names)
    assert all("--hash=sha256:" in block for block in blocks)  # --require-hashes
    assert {"hatchling", "editables"} <= {*names}  # --no-build-isolation


def test_it_runs_as_a_user_without_rights_and_is_stopped_as_the_command_expects() -> None:
    names = [name for name, _ in _instructions()]
    assert names.index("USER") < names.index("CMD")
    (user,) = _all("USER")
    # a Space runs as 1000, whatever the image says
    assert any(f"--uid 1000 {user}" in line for line in _all("RUN"))
    assert _all("STOPSIGNAL") == ["SIGTERM"]
    assert _all("EXPOSE") == ["8080"]


def test_its_wheel_brings_compiled_kernels() -> None:
    assert any(line.startswith("ABI_READY_KERNELS=1 pip install") for line in _all("RUN"))


def _nothing_is_written() -> None:
    # as on a file system that is read-only or full: not a byte goes into any file
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))


@pytest.fixture
def image() -> Iterator[tuple[subprocess.Popen[str], int, str]]:
    """The image's command with neither capabilities nor a place to write: process, port, link."""
    port = free_port()
    program, *arguments = [word.replace("8080", str(port)) for word in _command()]
    assert program == "abi"
    drop = ["--bounding-set=-all", "--inh-caps=-all"] if os.geteuid() == 0 else []
    limits = ["setpriv", "--no-new-privs", *drop] if shutil.which("setpriv") else []
    process = subprocess.Popen(
        [*limits, sys.executable, "-m", "app", *arguments],
        cwd=ROOT,
        env={**os.environ, **_environment(), "PYTHONDONTWRITEBYTECODE": "1"},
        preexec_fn=_nothing_is_written,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    link = next(word for word in process.stdout.readline().split() if word.startswith("http"))
    yield process, port, link
    process.kill()
    process.communicate()


@pytest.mark.slow
def test_its_command_serves_without_capabilities_and_without_writing(
    image: tuple[subprocess.Popen[str], int, str],
) -> None:
    process, port, link = image
    status = Path(f"/proc/{process.pid}/status")
    if status.exists():
        fields = dict(
            line.split(":\t") for line in status.read_text().splitlines() if ":\t" in line
        )
        assert int(fields["CapEff"], 16) == 0
        assert fields["NoNewPrivs"] == "1"
    until(lambda: _health_check(port) == 0)
    token = link.partition("token=")[2]
    tab = FakeTab(f"http://127.0.0.1:{port}", {"Authorization": f"Bearer {token}"})
    until(lambda: tab.received > 100_000)  # the page's scene with a plan
    tab.close()
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 0
    assert "Traceback" not in err
    assert _health_check(port) != 0


def test_a_space_asks_at_the_images_port_and_its_variables_are_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    text = (ROOT / "hosting" / "space" / "README.md").read_text(encoding="utf-8")
    _, front, body = text.split("---\n", 2)
    fields = YAML(typ="safe", pure=True).load(front)
    assert fields["sdk"] == "docker"
    assert fields["license"] == "apache-2.0"
    assert len(fields["short_description"]) <= 60
    command = _command()
    assert str(fields["app_port"]) == command[command.index("--port") + 1]
    values = dict(re.findall(r"^\| `(ABI_\w+)` \| `([^`]+)`", body, re.MULTILINE))
    for name, value in values.items():
        monkeypatch.setenv(name, value)
    params = serve.make_context("serve", command[2:]).params
    assert params["origin"] == (values["ABI_ORIGIN"],)
    assert params["embed_in"] == (values["ABI_EMBED_IN"],)
    assert params["no_token"] is True

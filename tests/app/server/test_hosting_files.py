"""The files for hosting say what the program understands."""

from __future__ import annotations

import shlex
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import click
import pytest
from ruamel.yaml import YAML

from app.cli.serve import serve
from app.jupyter import server

ROOT = Path(__file__).parents[3]


def _parsed(arguments: list[str]) -> dict[str, object]:
    assert arguments[0] == "serve"
    return serve.make_context("serve", list(arguments[1:])).params


def test_compose_starts_replicas_that_share_a_token_behind_nginx() -> None:
    text = (ROOT / "compose.yaml").read_text(encoding="utf-8")
    services = YAML(typ="safe", pure=True).load(text)["services"]
    command = [
        word.replace("${ABI_ORIGIN:-", "").rstrip("}") for word in services["abi"]["command"]
    ]
    params = _parsed(command[1:])
    assert params["origin"] == ("http://localhost:8000",)
    assert services["abi"]["deploy"]["replicas"] > 1
    assert services["abi"]["read_only"]
    assert services["abi"]["cap_drop"] == ["ALL"]
    assert "ABI_TOKEN" in services["abi"]["environment"]
    store = services["abi"]["environment"]["ABI_STORE"]
    assert services["abi"]["volumes"] == [f"uploads:{store}"]
    image = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    assert f"USER abi\nWORKDIR {Path(store).parent}\n" in image
    assert f"RUN mkdir {Path(store).name}\n" in image
    (volume,) = services["proxy"]["volumes"]
    assert (ROOT / volume.split(":")[0]).is_file()


def test_the_image_starts_a_command_that_there_is() -> None:
    lines = (ROOT / "Dockerfile").read_text(encoding="utf-8").splitlines()
    command = YAML(typ="safe", pure=True).load(lines[-1].removeprefix("CMD "))
    assert _parsed(command[1:])["host"] == "0.0.0.0"
    (check,) = (line for line in lines if "/healthz" in line)
    code = YAML(typ="safe", pure=True).load(check.strip().removeprefix("CMD "))[2]
    compile(code, "the health check", "exec")
    assert not any(line.startswith("USER root") for line in lines)


def test_jupyter_starts_the_visualiser_and_keeps_the_token_to_itself() -> None:
    point = EntryPoint("abi", "app.jupyter:server", "jupyter_serverproxy_servers")
    first, second = point.load()(), server()
    command = first["command"]
    assert command[0] == sys.executable
    assert _parsed([word.replace("{port}", "8123") for word in command[3:]])["port"] == 8123
    token = first["environment"]["ABI_TOKEN"]
    assert first["request_headers_override"] == {"Authorization": f"Bearer {token}"}
    assert token not in shlex.join(command)
    assert token != second["environment"]["ABI_TOKEN"]  # type: ignore[index]
    assert f'abi = "{point.value}"' in (ROOT / "pyproject.toml").read_text(encoding="utf-8")


def test_two_ways_to_say_the_token_exclude_each_other() -> None:
    with pytest.raises(click.UsageError, match="exclude each other"):
        serve.main(["--token", "a", "--no-token", "--no-open"], standalone_mode=False)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--teach", "a", "--token", "a"], "must differ from --token"),
        (["--teach", ""], "--teach must have 1 to 200 characters"),
    ],
)
def test_a_teachers_secret_that_would_be_none_is_refused(
    arguments: list[str], sentence: str
) -> None:
    with pytest.raises(click.UsageError, match=sentence):
        serve.main(["--classroom", "--no-open", *arguments], standalone_mode=False)

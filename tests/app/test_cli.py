from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from abi.scene import scene_names
from app.__main__ import main


def run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *args: str
) -> tuple[int, str, str]:
    monkeypatch.setattr(sys, "argv", ["abi", *args])
    try:
        main()
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else 0
    else:
        code = 0
    out, err = capsys.readouterr()
    return code, out, err


def test_plan_prints_a_complete_plan(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = run(monkeypatch, capsys, "plan")

    assert (code, err) == (0, "")
    assert json.loads(out)["error"] is None


def test_plan_list_names_the_scenes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = run(monkeypatch, capsys, "plan", "--list")

    assert code == 0
    assert tuple(out.split()) == scene_names()


def test_no_plan_still_writes_the_json_and_exits_3(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    target = tmp_path / "plan.json"
    code, out, err = run(monkeypatch, capsys, "plan", "no-way", "--out", str(target))

    assert (code, out) == (3, "")
    assert json.loads(target.read_text())["error"]["kind"] == "no_path"
    assert len(err.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("plan", "nowhere"), "paper"),
        (("plan", "missing.yaml"), "missing.yaml"),
        (("plan", "--out", "/nowhere/at/all.json"), "all.json"),
        (("plan", "--fast"), "--fast"),
        (("serve", "--port", "99999"), "port"),
        (("serve", "nowhere", "--no-open"), "nowhere"),
        (("--port", "x"), "port"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    args: tuple[str, ...],
    words: str,
) -> None:
    code, out, err = run(monkeypatch, capsys, *args)

    assert (code, out) == (2, "")
    assert words in err
    assert len(err.strip().splitlines()) == 1


def test_a_broken_scene_file_names_the_field(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text("version: 1\nmesh: {pitch: -3}\n")
    code, _, err = run(monkeypatch, capsys, "plan", str(path))

    assert code == 2
    assert "mesh.pitch" in err
    assert "-3" in err


def test_the_installed_command_answers() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "app", "plan", "thin-plate"], capture_output=True, text=True
    )

    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["path"]["length"] > 5.2

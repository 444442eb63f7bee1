from __future__ import annotations

import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "examples"
SCRIPTS = sorted(FOLDER.glob("*.py"))
ARGUMENTS = {"10_page_of_your_own.py": ["--once"]}


@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_runs_and_prints_numbers(
    script: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", [str(script), *ARGUMENTS.get(script.name, [])])

    runpy.run_path(str(script), run_name="__main__")

    out, err = capsys.readouterr()
    assert len(re.findall(r"\d", out)) >= 5
    assert err == ""


@pytest.mark.slow
def test_runs_as_a_command_from_any_folder(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(SCRIPTS[0])], cwd=tmp_path, capture_output=True, text=True, check=True
    )

    assert "shipped scenes: paper" in done.stdout
    assert done.stderr == ""
    assert list(tmp_path.iterdir()) == []


def test_are_numbered_without_gaps_and_told_in_one_sentence() -> None:
    assert [script.name[:2] for script in SCRIPTS] == [f"{k + 1:02}" for k in range(len(SCRIPTS))]
    for script in SCRIPTS:
        title, line, _, sentence = script.read_text(encoding="utf-8").split("\n")[1:5]
        assert line == "=" * len(title)
        assert re.fullmatch(r"[A-Z][^.]*[\w`]\.", sentence), (script.name, sentence)

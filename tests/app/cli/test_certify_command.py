"""``abi certify``: exit codes, sentences and a certificate that ``abi verify`` accepts."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from app.cli.certify import certify
from app.cli.verify import verify

pytestmark = pytest.mark.slow
HEAD = ",".join(
    ["time", "shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"]
    + [f"wrist_{k}_joint" for k in (1, 2, 3)]
)
ROWS = "0,2.0,-1.6,1.2,-1.2,-1.57,0\n2,0.8,-1.6,1.2,-1.2,-1.57,0\n"


def written(folder: Path, text: str) -> str:
    file = folder / "swing.csv"
    file.write_text(text)
    return str(file)


def test_a_clear_motion_has_a_certificate_that_is_accepted(tmp_path: Path) -> None:
    out = tmp_path / "verdict.json"
    motion = written(tmp_path, f"{HEAD}\n{ROWS}")
    found = CliRunner().invoke(certify, [motion, "--robot", "ur5e", "--out", str(out)])
    assert found.exit_code == 0
    assert found.output.startswith("Proven clear")
    assert json.loads(out.read_text())["verdict"] == "clear"
    checked = CliRunner().invoke(verify, [str(out)])
    assert checked.exit_code == 0
    assert "motion: proven" in checked.output


def test_a_motion_that_touches_ends_with_3(tmp_path: Path) -> None:
    motion = written(tmp_path, f"{HEAD}\n0,0,0.5,0,0,0,0\n1,0,1.2,0,0,0,0\n")
    scene = tmp_path / "floor.yaml"
    scene.write_text(
        "version: 1\nunit: m\nworkspace: {min: [-1, -1, 0], max: [1, 1, 1]}\n"
        "start: [0, 0, 0]\ngoal: [1, 1, 1]\nmesh: {pitch: 0.5}\n"
    )
    args = [motion, "--robot", "ur5e", "--scene", str(scene), "--json"]
    found = CliRunner().invoke(certify, args)
    assert found.exit_code == 3
    data = json.loads(found.output)
    assert (data["verdict"], data["obstacle"]) == ("touches", "floor")


def test_a_budget_that_ends_leaves_it_undecided(tmp_path: Path) -> None:
    rows = "\n".join(f"{k},{2 - k / 2000},-1.6,1.2,-1.2,-1.57,{k % 2}" for k in range(2000))
    motion = written(tmp_path, f"{HEAD}\n{rows}\n")
    args = [motion, "--robot", "ur5e", "--budget", "1000", "--json"]
    found = CliRunner().invoke(certify, args)
    assert found.exit_code == 4
    assert "More tries" in json.loads(found.output)["undecided"][0]["would_decide"]


@pytest.mark.parametrize(
    "state",
    [
        "elbow_joint",
        "elbow_joint=x",
        "=1",
        "elbow_joint=1_0",
        "elbow_joint=0,elbow_joint=1.2",
        "elbow_joint=nan",
    ],
)
def test_a_start_state_that_is_none_is_refused(tmp_path: Path, state: str) -> None:
    motion = written(tmp_path, f"{HEAD}\n{ROWS}")
    found = CliRunner().invoke(certify, [motion, "--robot", "ur5e", "--start", state])
    assert found.exit_code != 0

"""Random robots in random files are read whole and in place; the benchmark reads thousands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from abi import assets
from abi.errors import SceneError
from abi.robot.urdf.robot_files import SHIPPED, packed, unpacked
from benchmarks.public_files import compare, compare_robot, rows_of
from benchmarks.robot_campaign import check, measure
from tests.abi.robot.robots import OWN, arm, joint, link, urdf
from tests.random_archives import RobotFile, random_file


@pytest.mark.parametrize("seed", range(4))
def test_random_files_are_read_as_they_are_written(seed: int) -> None:
    found = measure(3, seed)
    assert found["files"] == 3
    assert found["links"] >= 9


def test_a_smaller_or_displaced_surface_is_noticed() -> None:
    made = next(
        one
        for seed in range(20)
        if (one := random_file(np.random.default_rng(seed))).name == "r.zip"
    )
    files = unpacked(made.content)
    (mesh,) = (name for name in files if name.lower().endswith("part.stl") and "visual" not in name)
    smaller = np.frombuffer(files[mesh], dtype=np.uint8).copy()
    smaller[84 + 12 : 84 + 16] = 0  # the first corner's x
    broken = packed({**files, mesh: smaller.tobytes()})
    random = np.random.default_rng(0)
    check(made, random, capsules=False)
    with pytest.raises(AssertionError, match=r"r\.zip"):
        check(RobotFile(made.name, broken, made.robot), random, capsules=False)
    del files[mesh]
    files = {name: one for name, one in files.items() if not name.lower().endswith(".stl")}
    with pytest.raises(SceneError, match="a file that came with the URDF"):
        check(RobotFile(made.name, packed(files), made.robot), random, capsules=False)


def test_files_of_packages_are_counted_by_what_comes_of_them(tmp_path: Path) -> None:
    folder = tmp_path
    for name, text in OWN.items():
        (folder / f"{name}.urdf").write_text(text)
    (folder / "wrong.urdf").write_text(arm(('upper="2"', 'upper="two"')))
    outcomes = {Path(one.file).stem: one for one in compare(folder, states=30)}
    assert {name: outcomes[name].outcome for name in OWN} == dict.fromkeys(OWN, "read")
    assert outcomes["sliding"].by[0] == "yourdfpy"
    assert outcomes["linkage"].by == ("its numbers",)
    assert "expected a number" in outcomes["wrong"].why
    (row,) = rows_of(outcomes.values())
    assert {"all": 4, "read": 3, "refused": 1, "different": 0}.items() <= row.items()


@pytest.mark.parametrize("name", SHIPPED)
def test_all_links_of_shipped_arms_are_where_another_reader_has_them(name: str) -> None:
    folder = assets.path("urdf")
    outcome = compare_robot(folder / name / f"{name}.urdf", folder, states=20)
    assert outcome.by[0] == "yourdfpy", outcome.why


def test_a_link_that_is_called_anew_is_where_another_reader_has_it_by_its_own_name(
    tmp_path: Path,
) -> None:
    text = urdf(link("floor"), link("b"), joint("j", "floor", "b"))
    (tmp_path / "a.urdf").write_text(text)
    outcome = compare_robot(tmp_path / "a.urdf", tmp_path, states=3)
    assert outcome.outcome == "read", outcome.why

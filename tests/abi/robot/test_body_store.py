"""Bodies that were kept are those that are made, to the bit; what is damaged is made again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.bodies import body_store, link_bodies
from abi.robot.bodies.link_bodies import Body
from abi.robot.urdf.link import Link
from abi.robot.urdf.robot_files import load_robot

LINK = load_robot("panda", MeshSource()).links["panda_hand"]


def made_again(link: Link) -> tuple[Body, ...]:
    """The bodies, asked for as by a new process."""
    link_bodies.link_bodies.cache_clear()
    return link_bodies.link_bodies(link)


def numbers(bodies: tuple[Body, ...]) -> list[bytes]:
    return [link_bodies._packed(body).tobytes() for body in bodies]


def test_bodies_are_made_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    made = numbers(made_again(LINK))
    (file,) = body_store._folder().iterdir()

    def fail(link: Link, fit: object) -> tuple[Body, ...]:
        raise AssertionError(link.name)

    with monkeypatch.context() as without:
        without.setattr(link_bodies, "_fitted", fail)
        kept = made_again(LINK)
        assert numbers(kept) == made
        assert not any(body.points.flags.writeable for body in kept)
        other = replace(LINK.shapes[0], vertices=LINK.shapes[0].vertices * (1 + 1e-15))
        with pytest.raises(AssertionError):
            made_again(replace(LINK, shapes=(other, *LINK.shapes[1:])))

    for damaged in (b"", file.read_bytes()[:-1], bytes(50)):
        file.write_bytes(damaged)
        assert numbers(made_again(LINK)) == made
    assert len(file.read_bytes()) > 100


def test_a_folder_that_cannot_be_written_costs_time_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "abi-visualiser").write_bytes(b"a file, not a folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert numbers(made_again(LINK)) == numbers(link_bodies._fitted(LINK, "quick"))


def test_the_oldest_files_make_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(body_store, "_MOST", 4)
    for number in range(9):
        body_store.keep(f"{number}", [np.array([float(number)])])
    found = [body_store.find(f"{number}") for number in range(9)]
    assert found[-1] is not None
    assert found[-1][0] == [8.0]
    assert sum(one is not None for one in found) <= 4

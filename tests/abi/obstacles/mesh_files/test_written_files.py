"""Random files of every format against the surfaces that their writers know."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.mesh_files import WRITERS, campaign, outcome
from benchmarks.written_shapes import Written


@pytest.mark.slow
def test_every_file_is_read_into_its_surface_or_refused() -> None:
    for name, found in campaign(12).items():
        assert found["faults"] == [], name
        assert found["read"] > 0, name


@pytest.mark.parametrize("name", WRITERS)
def test_a_surface_that_is_not_the_true_one_is_a_fault(name: str) -> None:
    written = _plain(name)
    moved = written.surface + np.array([0, 0, 0.01]) * np.ptp(written.surface)
    for wrong, words in (
        (replace(written, surface=np.concatenate([written.surface, moved])), "is off|is missing"),
        (replace(written, surface=written.surface[:-1]), "is off|off its surface"),
        (replace(written, surface=moved), "is missing"),
        (replace(written, surface=written.surface[:, ::-1]), "volume"),
        (replace(written, metres=0.3), "unit"),
        (replace(written, left_out=True), "notes"),
        (replace(written, refused=True), "cannot be read"),
    ):
        with pytest.raises(AssertionError, match=words):
            outcome(wrong)


def _plain(name: str) -> Written:
    """The first file of a format that is read without a rest."""
    seeds = (random.Random(f"{name} {number}") for number in range(100))
    files = (WRITERS[name](chance) for chance in seeds)
    return next(one for one in files if not one.refused and outcome(one) == "read")

"""A small campaign over scenes of triangle meshes; ``benchmarks.mesh_scenes`` runs a large one."""

from __future__ import annotations

import pytest

from benchmarks import mesh_scenes


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_no_sample_refutes_a_path_or_a_certificate_among_meshes(seed: int) -> None:
    assert mesh_scenes.check(seed) in ("planned", "no plan")

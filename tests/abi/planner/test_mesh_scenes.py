"""A small campaign over scenes of triangle meshes; ``benchmarks.mesh_scenes`` runs a large one."""

from __future__ import annotations

import pytest

import abi
from abi import load_scene
from abi.arm_planning.world.paper_arm_distance_kernels import capsules_near_meshes
from abi.curves.clearance.certify_curve_kernels import separate_from_mesh
from abi.curves.clearance.curve_clearance_kernels import measure_curve_near_meshes
from abi.obstacles.obstacle_set_kernels import polyline_distances_near_meshes
from abi.search.taut.tighten_near_meshes_kernels import tightened
from benchmarks import mesh_scenes, plan_records
from tests.thorough import of_each_kind


@pytest.mark.slow
@pytest.mark.parametrize("seed", of_each_kind(range(4), 0, 1))
def test_no_sample_refutes_a_path_or_a_certificate_among_meshes(seed: int) -> None:
    assert mesh_scenes.check(seed) in ("planned", "no plan")


@pytest.mark.slow
def test_a_plan_is_the_same_while_what_asks_about_meshes_runs_as_python(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    abi.compile()
    scene = load_scene("sculpture")
    compiled = plan_records.record("sculpture", scene)
    kernels = (
        *(tightened, polyline_distances_near_meshes, measure_curve_near_meshes),
        *(separate_from_mesh, capsules_near_meshes),
    )
    for kernel in kernels:
        monkeypatch.setattr(kernel, "_run", kernel.interpret)
    before = {kernel: kernel.need for kernel in kernels}
    assert not plan_records.differences(compiled, plan_records.record("sculpture", scene))
    assert all(kernel.need > before[kernel] for kernel in kernels)

"""Triangle meshes of every kind as obstacles: uploaded, dragged, and kept clear of."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

import abi
from abi.obstacles.mesh_shape import MeshShape
from app.mesh_picture import MOST_DRAWN
from app.numbers import format_lower_bound
from app.session import Session
from tests.abi import meshes
from tests.browser import drawn
from tests.browser.page import Page

ADD = "Add a mesh (STL, OBJ, GLB …)"
# What is dragged, the note it comes with, and whether its middle is inside.
KINDS = {
    "soup": (meshes.soup(150, seed=3, size=0.9), "The surface has holes", False),
    "bunny-like": (meshes.bumpy(6), "81,920 triangles", True),
    "flipped": (meshes.inverted(meshes.bumpy(4)), "The surface was inside out", True),
}


def _add(page: Page, session: Session, name: str, mesh: meshes.Mesh) -> str:
    """Upload a mesh in the place of the cube; the name of its gizmo."""
    page.click("Scene")
    _delete(page, session)
    page.upload(ADD, f"{name}.stl", meshes.stl(mesh))
    page.until(lambda: len(session.plan.scene.obstacles) == 1, "the mesh")  # type: ignore[union-attr]
    page.until(lambda: len(drawn.obstacles(page)) == 1, "its gizmo")
    (gizmo,) = drawn.obstacles(page)
    page.node(f"{gizmo}/body")
    assert page.triangles(f"{gizmo}/body") == len(mesh[1])
    return gizmo


def _delete(page: Page, session: Session) -> None:
    """Delete the cube."""
    page.choose("change", "Delete")
    page.until(lambda: session.plan.scene.obstacles == (), "the cube to go")  # type: ignore[union-attr]
    # its size goes, too, and what is below moves up: a press on its way would miss
    page.until(lambda: drawn.obstacles(page) == [], "its gizmo to go")
    page.settle()


def _is_planned_here(page: Page, session: Session, gizmo: str) -> None:
    """Wait until the page shows a plan around the obstacle where its gizmo is now."""

    def arrived() -> bool:
        assert session.plan is not None
        (obstacle,) = session.plan.scene.obstacles
        here = page.position(gizmo)
        return np.allclose(here, obstacle.position, atol=1e-5) and drawn.shows(page, session.plan)

    page.until(arrived, "the plan for where the mesh is")


def _nearest(curve: drawn.Points, mesh: meshes.Mesh, place: tuple[float, float, float]) -> float:
    """Distance of points (n, 3) to a mesh moved to ``place``, from points all over the mesh: never
    less than it is."""
    vertices, faces = mesh
    corners = (vertices + place)[faces]
    rng = np.random.default_rng(0)
    chosen = corners[rng.integers(len(faces), size=40_000)]
    inside = np.einsum("nk,nki->ni", rng.dirichlet((1, 1, 1), len(chosen)), chosen)
    surface = np.concatenate([corners.reshape(-1, 3), inside])
    distance, _ = cKDTree(surface).query(curve)
    return float(distance.min())


@pytest.mark.parametrize("kind", KINDS)
def test_a_mesh_works_as_an_obstacle_while_it_is_dragged(
    page: Page, session: Session, kind: str
) -> None:
    mesh, note, solid = KINDS[kind]
    gizmo = _add(page, session, kind, mesh)
    page.reads(note)
    page.settle()
    places = [page.position(gizmo)]
    plans = [session.plan]

    def midway() -> None:
        _is_planned_here(page, session, gizmo)
        places.append(page.position(gizmo))
        plans.append(session.plan)

    page.drag_arrow(gizmo, 1, 1.2, midway)
    midway()
    along = [place[1] - places[0][1] for place in places]
    assert along == pytest.approx([0, 0.6, 1.2], abs=0.15)

    for place, plan in zip(places, plans, strict=True):
        assert plan is not None
        assert plan.error is None
        assert plan.bspline is not None
        (middle,) = plan.scene.obstacles[0].signed_distance(np.array([place]))
        assert (middle < 0) == solid
        asked = plan.scene.spline.clearance
        assert plan.bspline.clearance.certified
        assert plan.bspline.clearance.distance >= asked
        curve = plan.bspline.curve(np.linspace(0, 1, 2000))
        assert _nearest(curve, mesh, place) >= asked
    # The page's own line, at the mesh's last place.
    shown = drawn.chain(page.points("/curve/bspline"))
    assert _nearest(shown, mesh, page.position(gizmo)) >= asked - drawn.SINGLE
    assert plan is not None
    assert plan.bspline is not None
    page.click("Result")
    page.reads(f"{format_lower_bound(plan.bspline.clearance.distance)} ✓")
    assert drawn.same(plan, abi.plan(plan.scene))
    assert page.complaints() == []


@pytest.mark.slow
def test_a_large_mesh_can_be_stopped_and_is_drawn_with_fewer_triangles(
    page: Page, session: Session
) -> None:
    mesh = meshes.bumpy(7)
    content = meshes.stl(mesh)
    page.click("Scene")
    page.upload(ADD, "first.stl", content)
    page.reads("first.stl: on its way")
    page.reads("first.stl: reading and repairing")
    page.click("Stop reading")
    stop = page.tab.get_by_text("Stop reading")
    page.until(lambda: not any(one.is_visible() for one in stop.all()), "the button to go")
    page.until(lambda: session.panels.editor.uploads._pending == 0, "the file to be let be")
    page.until(lambda: session.resting, "the tab to rest")
    assert session.plan is not None
    assert len(session.plan.scene.obstacles) == 1
    assert len(drawn.obstacles(page)) == 1

    page.upload(ADD, "second.stl", content)
    page.until(lambda: len(session.plan.scene.obstacles) == 2, "the mesh")  # type: ignore[union-attr]
    page.reads("327,680 triangles")
    page.reads("It is planned with all of them and drawn with fewer.")
    page.until(lambda: len(drawn.obstacles(page)) == 2, "its gizmo")
    gizmo = drawn.obstacles(page)[-1]
    page.node(f"{gizmo}/body")
    assert 10_000 < page.triangles(f"{gizmo}/body") <= MOST_DRAWN
    added = session.plan.scene.obstacles[-1]
    assert isinstance(added, MeshShape)
    assert len(added.triangles()) == len(mesh[1])
    assert page.complaints() == []


def test_what_is_no_mesh_is_refused_and_one_in_millimetres_is_asked_about(
    page: Page, session: Session
) -> None:
    good = session.plan
    page.click("Scene")
    whole = meshes.stl(meshes.box((30, 30, 30)))
    page.upload(ADD, "cut off.stl", whole[:-10])
    page.reads("cut_off.stl is not added")
    page.reads("It has arrived.")
    assert "successfully" not in page.text()
    assert session.plan is good
    assert len(drawn.obstacles(page)) == 1

    _delete(page, session)
    page.upload(ADD, "far too large.stl", meshes.stl(meshes.box((200, 200, 200))))
    page.reads("It was fitted to the workspace.")
    page.click("Original size: 200 cm")
    page.reads("is the file in mm?")
    page.click("Yes, read it in mm")
    page.until(lambda: session.plan.scene.obstacles[0].unit == "mm", "the unit")  # type: ignore[union-attr]


def test_several_files_are_added_apart_and_saved_with_the_scene(
    page: Page, session: Session
) -> None:
    page.click("Scene")
    vertices, faces = meshes.bumpy(2)
    files = {
        "gear.stl": meshes.stl((0.6 * vertices, faces)),
        "letter.stl": b"Dear student,",
        "speck.stl": meshes.stl(meshes.box((0.02, 0.01, 0.01))),
    }
    page.upload_all(ADD, files)
    page.reads("letter.stl is not added")
    page.until(lambda: len(session.plan.scene.obstacles) == 3, "both meshes")  # type: ignore[union-attr]
    assert session.plan is not None
    scene = session.plan.scene
    corners = [obstacle.bounds() for obstacle in scene.obstacles]
    for i, (low, high) in enumerate(corners):
        assert (high - low).max() > 0.3
        for below, above in corners[:i]:
            assert ((low > above) | (high < below)).any()
    names = session.panels.editor.choice.options
    assert sorted(name.partition(" · ")[2] for name in names) == ["box", "gear.stl", "speck.stl"]
    page.tick("show edges", True)
    page.until(lambda: len(drawn.obstacles(page)) == 3, "all gizmos")
    page.node(f"{drawn.obstacles(page)[-1]}/edges")

    with page.tab.expect_download() as download:
        page.click("Save this scene")
    name = download.value.suggested_filename
    content = download.value.path().read_bytes()
    assert name == "scene.zip"
    page.until(lambda: page.tab.get_by_text("Uploading").count() == 0, "the notices to end")
    page.choose("change", "Delete")
    page.until(lambda: len(session.plan.scene.obstacles) == 2, "one less")  # type: ignore[union-attr]
    page.upload("Open a scene file…", name, content)
    page.until(lambda: len(session.plan.scene.obstacles) == 3, "all again")  # type: ignore[union-attr]
    for one, other in zip(session.plan.scene.obstacles, scene.obstacles, strict=True):
        assert one.position == other.position

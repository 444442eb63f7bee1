"""Triangle meshes of every kind as obstacles: uploaded, dragged, and kept clear of."""

from __future__ import annotations

import os
import signal

import numpy as np
import pytest
from scipy.spatial import cKDTree

import abi
from abi.obstacles.mesh_shape import MeshShape
from app.drawing import mesh_picture
from app.panels.obstacles import mesh_note
from app.reading import running_reader
from app.reading.reading import ReadingRequest, ReadingResult
from app.reading.running_reader import RunningReader
from app.tab.session import Session
from app.ui.numbers import format_lower_bound
from tests.abi import meshes
from tests.browser import drawn
from tests.browser.page import Page
from tests.thorough import of_each_kind

DROP = """files => {
  const dropped = new DataTransfer();
  for (const [name, bytes] of files) {
    const content = bytes === null ? new Uint8Array(50_000_001) : Uint8Array.from(bytes);
    dropped.items.add(new File([content], name));
  }
  const drop = {dataTransfer: dropped, bubbles: true, cancelable: true};
  document.body.dispatchEvent(new DragEvent("drop", drop));
}"""
# A file that is on its way, of which only the first of two parts comes until ABI_REST is called.
HALF = """([label, bytes]) => {
  const button = [...document.querySelectorAll("button")].find(each => each.textContent === label);
  const file = {source_component_uuid: button.id, transfer_uuid: crypto.randomUUID()};
  const send = message => window.__viserMutable.sendMessage({...file, ...message});
  const whole = Uint8Array.from(bytes), half = whole.length >> 1;
  const part = (part_index, content) => send({type: "FileTransferPart", part_index, content});
  send({type: "FileTransferStartUpload", filename: "half.stl", mime_type: "", part_count: 2,
        size_bytes: whole.length});
  part(0, whole.slice(0, half));
  window.ABI_REST = () => part(1, whole.slice(half));
}"""
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
    page.choose("edit", "Delete")
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


@pytest.mark.parametrize("kind", of_each_kind(KINDS, "soup", "flipped"))
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


_READ = running_reader.answer_of


def _read_in_a_process_that_stands_still(
    process: RunningReader, job: ReadingRequest
) -> ReadingResult | None:
    os.kill(process.pid, signal.SIGSTOP)
    return _READ(process, job)


@pytest.mark.slow
def test_a_large_mesh_can_be_stopped_and_is_drawn_with_fewer_triangles(
    page: Page, session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    page.click("Scene")
    page.tab.evaluate(HALF, [ADD, list(meshes.stl(meshes.bumpy(2)))])
    page.reads("half.stl: on its way")
    page.tab.evaluate("window.ABI_REST()")
    page.until(lambda: len(session.plan.scene.obstacles) == 2, "the small mesh")  # type: ignore[union-attr]

    monkeypatch.setattr(mesh_picture, "MOST_DRAWN", 15_000)
    monkeypatch.setattr(mesh_note, "MOST_DRAWN", 15_000)
    mesh = meshes.bumpy(5)
    content = meshes.stl(mesh)
    with pytest.MonkeyPatch.context() as reading:
        reading.setattr(running_reader, "answer_of", _read_in_a_process_that_stands_still)
        page.upload(ADD, "first.stl", content)
        page.reads("reading and repairing")
        page.click("Stop reading")
        stop = page.tab.get_by_text("Stop reading")
        page.until(lambda: not any(one.is_visible() for one in stop.all()), "the button to go")
        page.until(lambda: session.panels.editor.uploads._pending == 0, "the file to be let be")
    page.until(lambda: session.resting, "the tab to rest")
    assert session.plan is not None
    assert len(session.plan.scene.obstacles) == 2
    assert len(drawn.obstacles(page)) == 2

    page.upload(ADD, "second.stl", content)
    page.until(lambda: len(session.plan.scene.obstacles) == 3, "the mesh")  # type: ignore[union-attr]
    page.reads("20,480 triangles")
    page.reads("Planning uses all of them; the picture shows fewer.")
    page.until(lambda: len(drawn.obstacles(page)) == 3, "its gizmo")
    gizmo = drawn.obstacles(page)[-1]
    page.node(f"{gizmo}/body")
    assert 2_000 < page.triangles(f"{gizmo}/body") <= 15_000
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
    page.until(lambda: "Uploading" not in page.text(), "no word but that of the refusal")
    assert "successfully" not in page.text()
    assert session.plan is good
    assert len(drawn.obstacles(page)) == 1

    _delete(page, session)
    page.upload(ADD, "far too large.stl", meshes.stl(meshes.box((200, 200, 200))))
    page.reads("It was scaled to fit the workspace.")
    page.choose("file's unit", "m")
    page.until(lambda: session.plan.scene.obstacles[0].unit == "m", "the unit")  # type: ignore[union-attr]
    (mesh,) = session.plan.scene.obstacles  # type: ignore[union-attr]
    low, high = mesh.bounds()
    assert float(max(high - low)) == pytest.approx(2.0, rel=0.01)  # a third of the workspace
    page.choose("file's unit", "its own unit")
    page.until(lambda: session.plan.scene.obstacles[0].unit is None, "no unit")  # type: ignore[union-attr]
    page.click("Original size: 200 cm")
    page.reads("is the file in mm?")
    page.click("Yes, read it in mm")
    page.until(lambda: session.plan.scene.obstacles[0].unit == "mm", "the unit")  # type: ignore[union-attr]


_LENGTHENED = """notice => {
  notice.querySelector(".mantine-Notification-description").textContent += " word".repeat(500);
  return notice.scrollHeight <= notice.clientHeight;
}"""


def test_notices_of_many_refused_files_stay_in_the_window(page: Page) -> None:
    page.click("Scene")
    titles = page.tab.locator(".mantine-Notification-title", has_text="is not added")
    for number in range(6):
        page.upload(ADD, f"cut off {number}.stl", meshes.stl(meshes.box((2, 2, 2)))[:-10])
        page.until(lambda: titles.count() == number + 1, "one notice more")  # noqa: B023
    root = page.tab.locator(".mantine-Notifications-root", has_text="is not added")
    size = page.tab.viewport_size
    assert size is not None
    box = root.bounding_box()
    assert box is not None
    assert box["y"] + box["height"] <= size["height"]
    told = root.locator(".mantine-Notification-root").last
    assert told.evaluate(_LENGTHENED), "a long notice is cut"
    # each of them is reached and closed there, and the page stays where it is
    closes = root.locator(".mantine-Notification-root", has_text="is not added").get_by_role(
        "button"
    )
    while closes.count():
        left = closes.count()
        closes.last.click()
        page.until(lambda: closes.count() < left, "one notice less")  # noqa: B023
        assert (
            page.tab.evaluate("document.scrollingElement.scrollTop + document.body.scrollTop") == 0
        )


def test_the_same_wrong_file_is_told_of_once(page: Page) -> None:
    page.click("Scene")
    notice = page.tab.locator(".mantine-Notification-root", has_text="twice.yaml is not opened")
    wrong = b"version: 1\nobstacles: [{shape: bx}]\n"
    page.upload("Open a scene file…", "twice.yaml", wrong)
    notice.wait_for()
    notice.evaluate("first => window.abiFirst = first")
    page.upload("Open a scene file…", "twice.yaml", wrong)
    page.until(lambda: not page.tab.evaluate("window.abiFirst.isConnected"), "the first to go")
    assert notice.count() == 1
    # another fault of the same file is another notice
    page.upload("Open a scene file…", "twice.yaml", b"version: 7\n")
    page.until(lambda: notice.count() == 2, "both notices")
    page.settle()
    assert notice.count() == 2
    while notice.count():
        left = notice.count()
        notice.last.get_by_role("button").click()
        page.until(lambda: notice.count() < left, "one notice less")  # noqa: B023


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
    assert name == "paper.zip"
    page.until(lambda: page.tab.get_by_text("Uploading").count() == 0, "the notices to end")
    page.choose("edit", "Delete")
    page.until(lambda: len(session.plan.scene.obstacles) == 2, "one less")  # type: ignore[union-attr]
    page.upload("Open a scene file…", name, content)
    page.until(lambda: len(session.plan.scene.obstacles) == 3, "all again")  # type: ignore[union-attr]
    for one, other in zip(session.plan.scene.obstacles, scene.obstacles, strict=True):
        assert one.position == other.position


def test_files_dropped_together_are_added_but_for_those_that_are_refused(
    page: Page, session: Session
) -> None:
    page.click("Scene")
    vertices, faces = meshes.bumpy(2)
    files = [
        ("letter.txt", list(b"Dear student,")),
        ("whole.stl", list(meshes.stl((0.5 * vertices, faces)))),
        ("huge.stl", None),
        (
            "box.OBJ",
            list(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4"),
        ),
    ]
    page.tab.evaluate(DROP, files)
    page.reads("letter.txt is not sent")
    page.reads("huge.stl is not sent")
    page.reads("It is larger than 50 MB.")
    page.until(lambda: len(session.plan.scene.obstacles) == 3, "both meshes")  # type: ignore[union-attr]
    # two drops, the second while the first is on its way: neither is lost
    page.tab.evaluate(DROP, files[1:2] * 2)
    page.tab.evaluate(DROP, files[3:])
    page.until(lambda: len(session.plan.scene.obstacles) == 6, "three more")  # type: ignore[union-attr]


def test_a_file_that_cannot_be_read_leaves_the_button_as_it_was(
    page: Page, session: Session
) -> None:
    page.click("Scene")
    content = meshes.stl(meshes.bumpy(2))
    refuse = "() => Promise.reject(new DOMException('', 'NotReadableError'))"
    page.tab.evaluate(f"() => {{ File.prototype.arrayBuffer = {refuse}; }}")
    page.upload(ADD, "gone.stl", content)
    page.reads("gone.stl is not sent")
    assert "on its way" not in page.text()
    assert "Uploading gone.stl" not in page.text()
    page.tab.evaluate("() => { delete File.prototype.arrayBuffer; }")
    page.upload(ADD, "here.stl", content)
    page.until(lambda: len(session.plan.scene.obstacles) == 2, "the mesh")  # type: ignore[union-attr]


def test_a_file_that_stays_away_is_told_of(
    page: Page, session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.ui.page.SILENCE", 0.3)
    page.click("Scene")
    page.tab.evaluate(HALF, [ADD, list(meshes.stl(meshes.bumpy(2)))])
    page.reads("half.stl: nothing more of it comes.")
    assert "on its way" not in page.text()
    page.tab.evaluate("window.ABI_REST()")  # it comes at last
    page.until(lambda: len(session.plan.scene.obstacles) == 2, "the mesh")  # type: ignore[union-attr]
    page.until(lambda: "of it comes" not in page.text(), "the line to go")

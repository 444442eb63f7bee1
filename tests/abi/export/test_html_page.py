from __future__ import annotations

import html
import json
import re
import webbrowser
from typing import Any

import numpy as np
import pytest

import abi
from abi import load_scene, plan
from abi.errors import AbiError
from abi.export import html_page
from abi.planner.arm_words import contact_sentence
from abi.planner.plan import Plan
from abi.planner.planner import Planner

NAMES = ("paper", "sculpture", "no-way")


def data_of(page: bytes) -> Any:
    found = re.search(r'<script id="plan" type="application/json">(.*?)</script>', page.decode())
    assert found is not None
    return json.loads(found[1])


@pytest.mark.parametrize("name", NAMES)
def test_the_page_has_what_the_plan_has(name: str) -> None:
    planned = plan(load_scene(name))
    page = html_page.write(planned, "plan.html")
    data = data_of(page)
    assert len(page) < 2_000_000
    assert b"http" not in page.replace(b"http-equiv", b"")
    assert planned.free is not None
    assert len(data["edges"]) <= html_page.EDGES
    if planned.path is not None:
        assert np.allclose(data["path"], planned.path.points, atol=1e-4)
        assert planned.graph is not None
        first = planned.graph.places(planned.path.order[:1])[0]
        assert np.allclose(data["order"][0], first, atol=1e-4)
    if planned.motion is not None:
        assert planned.arm is not None
        assert np.allclose(data["arm"]["tool"][-1], planned.motion.tool[-1], atol=1e-4)
        assert len(data["arm"]["links"]) == len(data["arm"]["time"])
        assert len(data["arm"]["links"][0]) == len(data["arm"]["radii"])
    names = [step["name"] for step in data["steps"]]
    assert names[0] == "1 Mesh"
    assert (names[-1] == "6 Arm") == (planned.error is None)


def test_obstacles_are_drawn_where_they_are() -> None:
    scene = load_scene("paper").replace(
        obstacles=[
            {
                "shape": "box",
                "size": [1, 2, 1],
                "position": [3, 3, 3],
                "wxyz": [0.9, 0.1, 0.3, 0.2],
            },
            {"shape": "sphere", "radius": 0.4, "position": [1, 5, 1]},
            {"shape": "cylinder", "radius": 0.3, "height": 2, "position": [5, 1, 3]},
            {"shape": "capsule", "radius": 0.3, "height": 1, "position": [1, 1, 5]},
        ]
    )
    for obstacle in scene.obstacles:
        corners = html_page._faces((obstacle,)).reshape(-1, 3)
        assert np.abs(obstacle.signed_distance(corners)).max() < 0.02
        low, high = obstacle.bounds()
        assert np.allclose([corners.min(axis=0), corners.max(axis=0)], [low, high], atol=0.03)


@pytest.mark.slow
def test_a_large_mesh_stays_small() -> None:
    scene = load_scene("paper").replace(mesh={"pitch": 0.2})
    page = html_page.write(Planner(compile=False)(scene, chosen_only=True), "plan.html")
    assert len(page) < 2_000_000


def test_text_cannot_leave_its_element() -> None:
    data = html_page.write(plan(load_scene("no-way")), "plan.html").decode()
    inner = data.split('type="application/json">')[1].split("</script>")[0]
    assert "<" not in inner


def test_nothing_to_show_is_an_error() -> None:
    with pytest.raises(AbiError, match="without a mesh"):
        html_page.write(Plan(load_scene("paper")), "plan.html")


def test_a_notebook_and_a_tab_show_the_page(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setattr(webbrowser, "get", lambda: webbrowser.GenericBrowser("/usr/bin/w3m"))
    monkeypatch.delitem(__import__("sys").modules, "ipykernel", raising=False)
    with pytest.warns(UserWarning, match=r"here, w3m, shows only text\. Open /.*plan\.html in one"):
        abi.show(plan(load_scene("paper")))
    assert opened == []
    monkeypatch.setattr(webbrowser, "get", lambda: webbrowser.GenericBrowser("firefox"))
    assert abi.show(plan(load_scene("paper"))) is None
    assert opened[0].startswith("file:")
    monkeypatch.setitem(__import__("sys").modules, "ipykernel", abi)
    shown: Any = abi.show(plan(load_scene("paper")))
    assert len(opened) == 1
    frame = re.search(r'sandbox="allow-scripts"\s+srcdoc="([^"]*)"', shown._repr_html_())
    assert frame is not None
    assert data_of(html.unescape(frame[1]).encode())["steps"][0]["name"] == "1 Mesh"


def test_an_arm_that_touches_something_is_told_and_red() -> None:
    planned = plan(load_scene("wall-with-window"))
    assert planned.arm_clearance is not None
    assert planned.arm is not None
    assert planned.motion is not None
    contacts = planned.arm_clearance.contacts
    data = data_of(html_page.write(planned, "plan.html"))
    *_, curve, arm = data["steps"]
    assert arm["name"].endswith("✗")
    assert contact_sentence(contacts[0], "cm") in arm["text"]
    assert f"{len(contacts)} contacts" in arm["text"]
    assert "by the tool tip alone" in "".join(step["text"] for step in (curve, data["steps"][-3]))
    links = planned.arm.capsule_links
    for contact in contacts:
        row = min(
            range(len(data["arm"]["time"])),
            key=lambda k: abs(data["arm"]["time"][k] - contact.time),
        )
        red = {links[k] for k in data["arm"]["touching"][row]}
        assert contact.link in red
    assert data["arm"]["touching"][0] == []


def test_the_page_calls_the_arm_clear_only_where_that_is_proven() -> None:
    clear = data_of(html_page.write(plan(load_scene("paper")), "plan.html"))["steps"][-1]
    assert clear["name"] == "6 Arm"
    assert "Proven: every link stays" in clear["text"]
    scene = load_scene("paper").replace(arm={"base": (3.0, -7.0, 0.0)})
    far = data_of(html_page.write(plan(scene), "plan.html"))["steps"][-1]
    assert far["text"].count("cannot reach the curve") == 1
    assert "✗" in far["name"]

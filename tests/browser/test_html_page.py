"""The exported page, played from a file, without a server."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Browser

from abi import load_scene, plan
from abi.export import formats


def test_the_page_plays_without_a_server(chromium: Browser, tmp_path: Path) -> None:
    file = tmp_path / "plan.html"
    planned = plan(load_scene("paper"))
    formats.export(planned, file, "html")
    errors: list[str] = []
    context = chromium.new_context(viewport={"width": 900, "height": 620}, offline=True)
    tab = context.new_page()
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.goto(file.as_uri())
    drawn = {}
    for button in tab.locator("nav button").all():
        button.click()
        name = button.inner_text()
        assert button.get_attribute("aria-current") == "step"
        drawn[name] = tab.evaluate("abiPage.drawn")
        assert drawn[name] > 12
    assert list(drawn) == ["1 Mesh", "2 Graph", "3 Search", "4 B-spline", "5 Quadratic", "6 Arm"]

    tab.get_by_role("button", name="3 Search").click()
    before = tab.evaluate("abiPage.drawn")
    tab.locator("#at").fill("500")
    assert planned.path is not None
    assert tab.locator("#now").inner_text() == f"15 of {planned.path.expanded} nodes"
    half = tab.evaluate("abiPage.drawn")
    assert before < half
    tab.locator("#at").fill("1000")
    assert tab.evaluate("abiPage.drawn") > half
    tab.locator("#at").fill("500")
    assert tab.evaluate("abiPage.drawn") == half

    tab.get_by_role("button", name="6 Arm").click()
    tab.get_by_role("button", name="Play").click()
    tab.wait_for_function("abiPage.share >= 1 && !abiPage.playing")
    assert tab.locator("#now").inner_text().startswith(f"{planned.motion.time[-1]:.2f} s of")  # type: ignore[union-attr]
    turn = tab.evaluate("abiPage.turn")
    tab.mouse.move(400, 300)
    tab.mouse.down()
    tab.mouse.move(460, 310)
    tab.mouse.up()
    assert tab.evaluate("abiPage.turn") != turn
    assert errors == []
    context.close()

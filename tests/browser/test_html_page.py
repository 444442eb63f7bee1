"""Exported pages, played without our server: plans and lessons."""

from __future__ import annotations

import io
import re
import zipfile
from pathlib import Path

from playwright.sync_api import Browser, FrameLocator, Page

from abi import load_scene, plan
from abi.export import formats
from app.teach.exercise_files import exercise_files
from app.teach.lesson import Step
from app.teach.lesson_file import lesson_named
from app.teach.take_home.lesson_page import lesson_page
from app.teach.take_home.scorm import scorm_package


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


_PLATFORM = """<!doctype html><title>platform</title><script>
const values = {}, calls = [];
window.API = {
  LMSInitialize(text) { calls.push("initialize"); return "true"; },
  LMSGetValue(name) { return values[name] || ""; },
  LMSSetValue(name, value) { values[name] = value; return "true"; },
  LMSCommit(text) { calls.push("commit"); return "true"; },
  LMSFinish(text) { calls.push("finish"); return "true"; },
  LMSGetLastError() { return "0"; },
};
</script><iframe src="index.html" style="width: 1000px; height: 600px"></iframe>"""


def test_a_lesson_tells_the_platform_its_score(chromium: Browser) -> None:
    lesson, file = lesson_named("05-quadratic")
    content = scorm_package(file.stem, lesson.title, lesson_page(file.stem, lesson, file.parent))
    with zipfile.ZipFile(io.BytesIO(content)) as package:
        page = package.read("index.html")
    errors: list[str] = []
    context = chromium.new_context(viewport={"width": 1100, "height": 700})
    tab = context.new_page()
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.route("**/*", lambda route: route.abort())  # but for these, nothing is asked for
    tab.route("**/index.html", lambda route: route.fulfill(body=page, content_type="text/html"))
    tab.route("**/", lambda route: route.fulfill(body=_PLATFORM, content_type="text/html"))
    tab.goto("http://platform.test/")
    frame = tab.frame_locator("iframe")
    frame.get_by_text("1 of 3").wait_for()
    assert frame.locator("#next").is_disabled()
    assert "too near" not in frame.locator("main").inner_text()
    for number, step in enumerate(lesson.steps):
        if number == 0:
            frame.locator("#choices button").nth(_right(step) - 1).click()
            frame.get_by_text("✗ No.").wait_for()
            assert frame.locator("#next").is_disabled()
        _pass(frame, step)
        assert tab.frames[1].evaluate("abiPage.drawn") > 12
        status = "completed" if number + 1 == len(lesson.steps) else "incomplete"
        assert tab.evaluate("values['cmi.core.lesson_status']") == status
        if number + 1 < len(lesson.steps):
            frame.locator("#next").click()
            frame.get_by_text(f"{number + 2} of {len(lesson.steps)}").wait_for()
    assert tab.evaluate("values['cmi.core.score.raw']") == "50"  # the first answer counts
    assert tab.evaluate("calls[0]") == "initialize"
    # whoever comes back goes on at the last page
    tab.evaluate("document.querySelector('iframe').contentWindow.location.reload()")
    tab.wait_for_function("calls.includes('finish')")
    frame.get_by_text(f"{len(lesson.steps)} of {len(lesson.steps)}").wait_for()
    assert re.fullmatch(r"\d{4}:\d\d:\d\d", tab.evaluate("values['cmi.core.session_time']"))
    assert errors == []
    context.close()


def test_a_lesson_opened_from_a_file_ends_with_its_exercise(
    chromium: Browser, tmp_path: Path
) -> None:
    lesson, file = lesson_named("02-graph")
    page = tmp_path / "lesson.html"
    page.write_bytes(lesson_page(file.stem, lesson, file.parent))
    context = chromium.new_context(offline=True)
    tab = context.new_page()
    tab.goto(page.as_uri())
    last = lesson.steps[-1]
    for step in lesson.steps:
        _pass(tab, step)
        assert tab.locator("#exercise").is_visible() is (step is last)
        if step is not last:
            tab.locator("#next").click()
    for name, text in exercise_files(last.exercises).items():
        with tab.expect_download() as download:
            tab.get_by_role("link", name=name).click()
        assert download.value.suggested_filename == name
        assert download.value.path().read_text(encoding="utf-8") == text
    tab.reload()
    tab.get_by_role("link", name="mine.py").wait_for()
    context.close()


def _pass(page: Page | FrameLocator, step: Step) -> None:
    """Answer what a page of a lesson asks, or have its task shown."""
    if step.question is not None:
        page.locator("#choices button").nth(_right(step)).click()
        page.get_by_text("✓ Right.").wait_for()
    elif step.task is not None:
        page.locator("#do").click()


def _right(step: Step) -> int:
    """Number of the right answer."""
    assert step.question is not None
    return [one.right for one in step.question.choices].index(True)

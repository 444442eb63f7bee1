"""The search theatre as a student uses it: steps, a guess in the scene, a race."""

from __future__ import annotations

import numpy as np

from app.tab.session import Session
from app.theatre.compared import lettered
from app.theatre.theatre import labels
from tests.browser.page import Page

_CARD = ".abi-node:not([hidden])"


def test_a_node_that_is_pointed_at_tells_g_h_and_f(page: Page, session: Session) -> None:
    page.click("Search")
    page.tick("step through a search", True)
    page.reads("step 0 of")
    page.set_number("step", 12)
    page.reads("step 12 of")
    assert session.frame.theatre is not None
    state = session.frame.theatre.state
    pixels = {
        node: page.pixel("/workspace", state.trace.arcs.points[node].tolist())
        for node in state.open.tolist()
    }
    apart = {
        node: min(
            np.hypot(*np.subtract(pixel, at)) for other, at in pixels.items() if other != node
        )
        for node, pixel in pixels.items()
        if page.is_free(pixel)
    }
    alone = max(apart, key=apart.__getitem__)
    page.tab.mouse.move(*pixels[alone])
    card = page.tab.locator(_CARD)
    page.until(card.is_visible, "the node's numbers")
    for number in labels(state, alone):
        assert number in card.inner_text()
    rings = page.tab.locator(".abi-rings circle:not(.abi-pointed)")
    assert rings.count() == len(state.candidates())
    page.tab.mouse.move(5, 5)  # over a panel
    page.until(lambda: not card.is_visible(), "no node's numbers")

    row = page.tab.locator("tr:has([data-place])").nth(1)
    row.hover()
    page.until(card.is_visible, "the numbers of the row's node")
    for number in labels(state, state.following):
        assert number in card.inner_text()
    assert "abi-pointed" in (row.get_attribute("class") or "")
    page.click("to start")
    page.reads("step 0 of")
    page.tick("step through a search", False)
    page.until(lambda: rings.count() == 0, "no rings")


def test_a_search_is_stepped_guessed_and_raced(page: Page, session: Session) -> None:
    page.click("Search")
    page.tick("step through a search", True)
    page.reads("step 0 of")
    page.tab.keyboard.press("n")  # the box that was ticked leaves the keys to the page
    page.reads("step 1 of")
    page.set_number("step", 12)
    page.reads("step 12 of")
    page.click("1 ▶")
    page.reads("step 13 of")
    page.click("◀ 1")
    page.reads("step 12 of")
    strip = page.tab.locator("#abi-overlay [data-part=lecture]")
    page.until(lambda: "A*: 12 of" in strip.inner_text(), "the buttons over the scene")
    assert not page.tab.locator(".abi-player").is_visible()
    strip.get_by_text("▶").click()
    page.reads("step 13 of")
    strip.get_by_text("◀").click()
    page.reads("step 12 of")
    assert session.frame.theatre is not None
    state = session.frame.theatre.state
    closed = np.reshape(page.props("/theatre/closed")["points"], (-1, 3))
    assert np.allclose(closed, state.trace.arcs.points[state.closed], atol=1e-6)

    page.tick("ask me: which node next?", True)
    page.reads("Which node is visited next?")
    promise = state.promise(state.open)
    free = [
        (float(f), page.pixel("/workspace", state.trace.arcs.points[node].tolist()))
        for node, f in zip(state.open.tolist(), promise, strict=True)
    ]
    wrong = max(one for one in free if page.is_free(one[1]))[1]
    page.tab.mouse.click(*wrong)
    page.reads("Not this one")
    for step, part in ((13, ".abi-letter"), (14, "tr")):
        shown = session.frame.theatre
        state = shown.state
        letters = [k for k, node in lettered(shown).items() if state.may_follow(node)]
        page.tab.locator(f"{part}:has(:text-is('{letters[0]}'))").click()
        page.reads("Right:")
        page.reads(f"step {step} of")
    page.tick("ask me: which node next?", False)
    page.until(lambda: page.tab.locator(".abi-letter").count() == 0, "no letters")

    page.tick("race of three", True)
    page.set_number("step", 40)
    page.reads("Dijkstra: 40 nodes, ")
    page.until(lambda: page.props("/race/1/nodes") is not None, "the second copy")
    page.tick("race of three", False)
    page.tick("step through a search", False)
    page.until(lambda: session.frame.theatre is None, "the theatre closed")
    page.until(page.tab.locator(".abi-player").is_visible, "the arm's player")
    assert strip.inner_text() == ""

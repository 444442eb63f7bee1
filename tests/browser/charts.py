"""Plots over time, as the page has drawn them."""

from __future__ import annotations

import pytest

from tests.browser.page import Page

_ENDS = """() => Object.values(window.__viserTestpoints.uplots).map(({chart}) => chart)
  .filter(chart => chart.over.clientWidth)
  .map(({scales, data}) => [scales.x.min, scales.x.max, data[0][0], data[0].at(-1)])"""

_NUMBERS = """() => Object.values(window.__viserTestpoints.uplots).map(({chart}) => chart)
  .filter(chart => chart.over.clientWidth && chart.series[0].label === "t")
  .map(({axes}) => (axes[1]._values ?? []).filter(text => text !== null && text !== "").length)"""


def ends(page: Page) -> tuple[float, float, float, float]:
    """Range of the first plot, and of its data: from, to, from, to, [s]."""
    page.until(lambda: bool(page.tab.evaluate(_ENDS)), "a plot")
    low, high, first, last = page.tab.evaluate(_ENDS)[0]
    return (low, high, first, last)


def is_whole(page: Page, duration: float) -> bool:
    """Check whether the first plot spans a motion so long, [s], and its data, too."""
    low, high, first, last = ends(page)
    return low == first == 0 and high == last == pytest.approx(duration)


def counts(page: Page) -> list[int]:
    """How many numbers stand beside each plot over time that is seen."""
    return list(page.tab.evaluate(_NUMBERS))

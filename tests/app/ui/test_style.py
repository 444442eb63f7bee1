"""Colours keep apart, for every kind of sight and on both pages."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from abi.search.search import SEARCHES
from app.ui import style

Colours = dict[str, style.Colour]

# Machado, Oliveira and Fernandes 2009, severity 1.0: linear sRGB as such an eye sees it.
SIGHTS = {
    "usual": np.eye(3),
    "deutan": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
    "protan": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "tritan": np.array(
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ]
    ),
}
LINES: Colours = {
    "A*": style.A_STAR,
    "Dijkstra": style.DIJKSTRA,
    "Bellman-Ford": style.BELLMAN_FORD,
    "a fourth search": style.FOURTH_SEARCH,
    "B-spline": style.BSPLINE,
    "quadratic": style.QUADRATIC,
    "shortcut": style.TAUT,
    "joint space": style.JOINT_SPACE,
    "trace": style.TRACE,
    "obstacle": style.OBSTACLE,
    "too close": style.VIOLATION,
}
JOINTS: Colours = {f"q{number + 1}": colour for number, colour in enumerate(style.JOINTS)}
PLOT: Colours = {"tool": style.MARK} | dict(zip("xyz", style.AXES, strict=True))
STEPPED: Colours = {"now": style.MARK, "obstacle": style.OBSTACLE, "nodes": style.MESH}
SCENE: Colours = {
    "workspace": style.WORKSPACE,
    "mesh": style.MESH,
    "excluded": style.EXCLUDED,
    "before": style.FADED,
    "now": style.MARK,
    "visited": style.CLOSED,
    "end": style.POINT,
    **dict(zip("xyz", style.AXES, strict=True)),
}
JUST_TOLD_APART = 2.3
"""Distance in CIELAB that an eye just tells apart side by side; lines need several times it."""
LIGHT: style.Colour = (255, 255, 255)
DARK: style.Colour = (36, 36, 36)

PAGES: tuple[style.Colour, style.Colour] = (LIGHT, (46, 46, 46))
"""Grounds of the panels: the light page's, and the lighter of the dark one's."""


def _linear(colour: style.Colour) -> NDArray[np.float64]:
    part = np.array(colour) / 255
    return np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)


def _lab(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """CIELAB under D65."""
    to_xyz = np.array(
        [
            [0.4124564, 0.3575761, 0.1804375],
            [0.2126729, 0.7151522, 0.0721750],
            [0.0193339, 0.1191920, 0.9503041],
        ]
    )
    xyz = to_xyz @ np.clip(linear, 0, 1) / np.array([0.95047, 1.0, 1.08883])
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def _contrast(a: style.Colour, b: style.Colour) -> float:
    weights = np.array([0.2126, 0.7152, 0.0722])
    low, high = sorted(float(_linear(colour) @ weights) for colour in (a, b))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("sight", SIGHTS)
@pytest.mark.parametrize(
    "colours", [LINES, JOINTS, PLOT, STEPPED], ids=["lines", "joints", "plot", "stepped"]
)
def test_colours_keep_apart_for_every_sight(colours: Colours, sight: str) -> None:
    seen = {name: _lab(SIGHTS[sight] @ _linear(colour)) for name, colour in colours.items()}
    for a, b in itertools.combinations(seen, 2):
        assert np.linalg.norm(seen[a] - seen[b]) > 8 * JUST_TOLD_APART, (a, b)


@pytest.mark.parametrize(
    "colour", [*LINES.values(), *SCENE.values(), *style.JOINTS], ids=[*LINES, *SCENE, *JOINTS]
)
def test_every_line_is_easily_seen_on_the_light_page_and_shows_on_the_dark_one(
    colour: style.Colour,
) -> None:
    assert _contrast(colour, LIGHT) >= 3  # WCAG 2.1, 1.4.11
    assert _contrast(colour, DARK) > 2


@pytest.mark.parametrize("colour", [*style.JOINTS, *PLOT.values()])
def test_thin_lines_of_plots_are_easily_seen_on_both_pages(colour: style.Colour) -> None:
    for ground in (LIGHT, DARK):
        assert _contrast(colour, ground) >= 3  # WCAG 2.1, 1.4.11


@pytest.mark.parametrize("signs", [style.GOOD, style.BAD])
def test_signs_can_be_read_on_both_pages(signs: tuple[style.Colour, style.Colour]) -> None:
    for sign, ground in zip(signs, PAGES, strict=True):
        assert _contrast(sign, ground) >= 4.5


def test_every_search_has_a_colour_of_its_own() -> None:
    assert set(style.ALGORITHMS) == set(SEARCHES), "SEARCH_COLOURS has too few colours"


def test_bluish_lines_that_are_seen_at_once_differ_in_more_than_their_colour() -> None:
    assert "taut" in style.DASHES
    assert not {"a_star", "quadratic", "bspline"} & set(style.DASHES)
    (short, _), (long, _) = style.DASHES["dijkstra"], style.DASHES["taut"]
    assert long > 2 * short
    assert "gradient" in style.swatch(style.TAUT, "taut")
    assert "gradient" not in style.swatch(style.A_STAR, "a_star")

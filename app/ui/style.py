"""Colours, widths and names: one colour for one thing, in scene, tables and plots.

The colours stay distinct for the common kinds of colour blindness. Lines have a contrast of 3 to 1
on white and are visible on near black. No colour carries a meaning alone: dashes, widths, signs and
words go with them.
"""

from __future__ import annotations

from abi.search.search import SEARCHES

Colour = tuple[int, int, int]

A_STAR: Colour = (128, 139, 240)
DIJKSTRA: Colour = (189, 141, 0)
BELLMAN_FORD: Colour = (25, 119, 84)
FOURTH_SEARCH: Colour = (156, 146, 138)
BSPLINE: Colour = (237, 67, 174)
QUADRATIC: Colour = (86, 66, 223)
TAUT: Colour = (30, 161, 197)
TRACE: Colour = (99, 84, 111)
JOINT_SPACE: Colour = (144, 16, 160)
"""Of the tool's way along what a search in the space of the joints tried, and found."""
MARK: Colour = (201, 8, 246)
OBSTACLE: Colour = (215, 124, 71)
MESH: Colour = (120, 144, 172)
EXCLUDED: Colour = (150, 96, 72)
VIOLATION: Colour = (169, 57, 22)
TOUCHING: Colour = (168, 16, 22)  # of solids, which light turns towards the obstacles' colour
WORKSPACE: Colour = (128, 138, 150)
POINT: Colour = (92, 107, 122)
JOINTS: tuple[Colour, ...] = (
    (84, 152, 228),
    (179, 128, 138),
    (176, 24, 253),
    (128, 157, 91),
    (192, 44, 158),
    (217, 24, 18),
)
AXES: tuple[Colour, ...] = ((184, 82, 85), (25, 161, 160), (131, 129, 205))
CLOSED: Colour = (84, 110, 158)
WAITING: tuple[Colour, ...] = ((236, 178, 0), (122, 190, 0), (0, 112, 84))
"""Colours of nodes that a search has reached, from the one visited next to the last."""
FADED: Colour = (143, 149, 156)
GHOST_OPACITY = 0.22
HEAT: tuple[Colour, ...] = ((228, 160, 0), (10, 128, 96), (44, 40, 130))
"""Colours of lengths, from the shortest to the longest."""
GOOD: tuple[Colour, Colour] = ((10, 122, 90), (60, 196, 152))
"""Colours of ✓ on the light and the dark page, with a contrast of at least 4.5 to 1 as text."""
BAD: tuple[Colour, Colour] = ((201, 42, 42), (255, 135, 135))
"""Colours of ✗ on the light and the dark page."""

SEARCH_COLOURS = (A_STAR, DIJKSTRA, BELLMAN_FORD, FOURTH_SEARCH)
ALGORITHMS: dict[str, tuple[str, Colour]] = {
    name: (one.label, colour)
    for (name, one), colour in zip(SEARCHES.items(), SEARCH_COLOURS, strict=False)
}
"""The searches of every plan; :mod:`abi.search.compare` has all that can be compared."""
CURVES: dict[str, tuple[str, Colour]] = {
    "bspline": ("B-spline", BSPLINE),
    "quadratic": ("quadratic", QUADRATIC),
}
DASHES: dict[str, tuple[float, int]] = {"dijkstra": (0.03, 3), "taut": (0.07, 6)}
"""Dashed lines by their switch: length of a dash over the workspace, and in a legend, [px].

The straightened path lies among others that are bluish, too, as A*'s and the quadratic are.
"""

LEFT_WIDTH = 344
RIGHT_WIDTH = 384


def paragraph(text: str) -> str:
    """A paragraph between widgets as HTML."""
    return f'<div style="margin:0 10px 4px;line-height:1.35;font-size:12.5px">{text}</div>'


def heading(text: str) -> str:
    """A heading between widgets as HTML."""
    place = "position:relative;top:-3px;margin:0 10px -3px;line-height:1.1"
    return f'<div style="{place};font-size:12.5px;font-weight:600">{text}</div>'


def css(colour: Colour) -> str:
    """The colour as ``#rrggbb``."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


def readable(colours: tuple[Colour, Colour]) -> str:
    """CSS colours of a text on the light and the dark page."""
    light, dark = map(css, colours)
    return f"light-dark({light},{dark})"


def filling(colour: Colour, name: str = "") -> str:
    """CSS background of a short line in a colour, with the dashes of the line so named."""
    if name not in DASHES:
        return css(colour)
    dash = DASHES[name][1]
    stops = f"{css(colour)} 0 {dash}px,transparent {dash}px {dash + 2}px"
    return f"repeating-linear-gradient(90deg,{stops})"


def swatch(colour: Colour, name: str = "") -> str:
    """A short line in a colour as HTML for tables, dashed as the line so named."""
    return (
        '<span style="display:inline-block;width:18px;height:4px;margin-right:6px;'
        f'vertical-align:middle;background:{filling(colour, name)}"></span>'
    )

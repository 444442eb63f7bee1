"""The legend: what of a tab's picture can be shown and hidden, in the order of its entries."""

from __future__ import annotations

from dataclasses import dataclass

from app.ui import style


@dataclass(frozen=True)
class Switch:
    """Entry of the legend that shows or hides something drawn.

    Attributes:
        name: element of :attr:`app.state.frame.Frame.shown` while it is on.
        label: its text on the page.
        colour: of what is drawn; None for what has several or none.
        on: whether a new tab shows it.
        hint: when it is there, or what it is, where the label does not say that.
    """

    name: str
    label: str
    colour: style.Colour | None
    on: bool = True
    hint: str | None = None


SWITCHES = (
    Switch("workspace", "workspace box", style.WORKSPACE),
    Switch("axes", "axes x, y, z", None),
    Switch("edges", "mesh edges", style.MESH),
    Switch("nodes", "mesh nodes", style.MESH),
    Switch("excluded", "nodes in obstacles", style.EXCLUDED),
    *(Switch(name, label, colour) for name, (label, colour) in style.ALGORITHMS.items()),
    Switch("taut", "shortcut path", style.TAUT, hint="Where stage 3 cuts the corners of the path."),
    Switch("bspline", "B-spline", style.BSPLINE),
    Switch(
        "control",
        "control points",
        style.BSPLINE,
        hint="Of the B-spline, which bends towards them.",
    ),
    Switch("quadratic", "quadratic", style.QUADRATIC),
    Switch(
        "ghost",
        "last plan's curve",
        style.FADED,
        on=False,
        hint="The curve before the last change, to compare.",
    ),
    Switch(
        "bases",
        "bases tried (heat map)",
        style.HEAT[0],
        hint="After Find a base in stage 6: yellow where the curve is shortest, dark blue "
        "where it is longest, grey where there is no plan.",
    ),
    Switch(
        "names",
        "names and distance",
        None,
        hint="Of points and curves, and the curve's least distance from an obstacle.",
    ),
    Switch(
        "bent",
        "control points to drag",
        style.BSPLINE,
        on=False,
        hint="A dashed curve follows them and says what it keeps; the plan stays as it is. "
        "Off and on again puts them back.",
    ),
    Switch("obstacles", "obstacles", style.OBSTACLE),
    Switch("trace", "tool tip trace", style.TRACE, hint="Where the tool tip has been since 0 s."),
    Switch("arm", "arm", None),
    Switch(
        "other_elbow",
        "other elbow, or other poses (ghosts)",
        style.FADED,
        on=False,
        hint="Another way for the arm to hold the tool tip where it is now.",
    ),
    Switch("end_poses", "poses at start and goal (ghosts)", style.POINT, on=False),
    Switch(
        "tool_only",
        "curve of the tool tip alone",
        style.FADED,
        hint="Where the curve would go if the links were no matter; drawn if they are.",
    ),
    Switch("shadow", "arm's shadow", style.VIOLATION, on=False),
    Switch("reach", "arm's reach", style.A_STAR, on=False),
)
SHOWN = frozenset(switch.name for switch in SWITCHES if switch.on)
"""Entries that are on in a new tab."""

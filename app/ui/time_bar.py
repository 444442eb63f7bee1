"""The time bar of a motion: proven clear, undecided and touching stretches, in colours and words.

None is told by its colour alone: touching is thick, undecided is striped, proven is thin.
"""

from __future__ import annotations

import bisect
from collections.abc import Sequence

from abi.arm_planning.joint_search.held_span import HeldSpan
from abi.certification.verdict import State, TimeStretch
from app.ui import style

_UNDECIDED: style.Colour = (214, 140, 0)
_LEAST = 1.0
"""Least width of a stretch, as a percentage of the bar."""
_MOST = 200
"""Most stretches that are drawn."""


_BarLook = tuple[str, str, int]
"""Name of a state, its image in CSS, and its height, [px]."""


def _plain(colour: style.Colour) -> str:
    return f"linear-gradient({style.css(colour)},{style.css(colour)})"


def _striped(colour: style.Colour) -> str:
    stripes = f"{style.css(colour)} 0 3px,transparent 3px 6px"
    return f"repeating-linear-gradient(90deg,{stripes})"


_LOOKS: dict[State, _BarLook] = {
    "clear": ("proven clear", _plain(style.GOOD[0]), 3),
    "undecided": ("not decided", _striped(_UNDECIDED), 6),
    "touches": ("touching", _plain(style.VIOLATION), 6),
}

_HELD = ("direction of the gripper kept", _plain(style.TAUT), 2)
_SEAM = ("end of a leg", _plain(style.FADED), 16)


def leg_at(begins: Sequence[float], time: float) -> int:
    """Number of the leg at a time, [s], from 0.

    Args:
        begins: when each leg of a sequence begins, and when the last one ends, [s].
        time: since the first one has begun, [s].
    """
    return min(max(bisect.bisect_right(begins, time), 1), len(begins) - 1) - 1


def bar_style(
    stretches: Sequence[TimeStretch],
    end: float,
    held: Sequence[HeldSpan] = (),
    seams: Sequence[float] = (),
) -> str:
    """Style sheet that draws stretches on the player's slider, which runs from 0 to ``end``, [s].

    A short one is made as wide as can be seen. Below them is a line where a direction of the tool
    is ``held``, and a mark stands at each of the ``seams``. The player of no motion is hidden.
    """
    if end == 0:
        return "<style>#abi-overlay .abi-player{visibility:hidden}</style>"
    # what touches lies above what is undecided, and that above what is proven
    order = ("touches", "undecided", "clear")
    shown = sorted(stretches[:_MOST], key=lambda one: order.index(one.state))
    layers = [
        _layer((one.first, one.last), end, _LOOKS[one.state])
        for one in shown
        if one.last >= one.first
    ]
    layers += [_layer((one.first, one.last), end, _HELD, "100%") for one in held]
    layers += [f"{_SEAM[1]} {100 * at / end:.2f}% 50%/2px {_SEAM[2]}px no-repeat" for at in seams]
    if not layers:
        return ""
    return f"<style>#abi-overlay .abi-track{{background:{','.join(layers)}}}</style>"


def legend(stretches: Sequence[TimeStretch]) -> str:
    """Legend of the bar as HTML, with each state's part of the motion."""
    whole = sum(one.last - one.first for one in stretches) or 1.0
    parts = []
    for state, (words, image, height) in _LOOKS.items():
        share = sum(one.last - one.first for one in stretches if one.state == state) / whole
        mark = (
            '<span style="display:inline-block;width:18px;margin-right:5px;vertical-align:middle;'
            f'height:{height}px;background:{image}"></span>'
        )
        per_cent = "0" if share == 0 else "< 1" if share < 0.01 else f"{100 * share:.0f}"
        parts.append(f'<span style="white-space:nowrap">{mark}{words} {per_cent} %</span>')
    return f'<div style="display:flex;flex-wrap:wrap;gap:2px 14px">{"".join(parts)}</div>'


def _layer(span: tuple[float, float], end: float, look: _BarLook, height: str = "50%") -> str:
    """CSS background of a span of time at a height of the bar."""
    _, image, thickness = look
    low, high = (100 * moment / end for moment in span)
    width = min(max(high - low, _LEAST), 100.0)
    low = min(max((low + high - width) / 2, 0.0), 100 - width)
    # a percentage places as much of the image as of the bar
    place = 100 * low / (100 - width) if width < 100 else 0.0
    return f"{image} {place:.2f}% {height}/{width:.2f}% {thickness}px no-repeat"

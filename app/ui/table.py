"""Tables of numbers as HTML."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable

_STYLE = (
    "<style>.abi-table{width:100%;border-collapse:collapse;font-size:12.5px;"
    "font-variant-numeric:tabular-nums}"
    ".abi-table th,.abi-table td{padding:3px 4px;text-align:right;white-space:nowrap;"
    "border-bottom:1px solid rgba(128,128,128,.22)}"
    ".abi-table th{font-weight:600;white-space:normal;vertical-align:bottom;"
    "border-bottom-color:rgba(128,128,128,.5)}"
    ".abi-table :first-child{text-align:left}"
    ".mantine-Tabs-tab{padding-left:9px;padding-right:9px}"
    ".abi-name{display:inline-block;max-width:7.6em;white-space:normal;vertical-align:middle}"
    "@media(max-height:760px){.abi-table th,.abi-table td{padding:2px 4px}}"
    "@media(max-width:600px){.abi-table{font-size:12px}"
    ".abi-table th,.abi-table td{padding:2px}}</style>"
)
"""Numbers stay on one line; names and headings wrap where the font is wide or the page narrow."""

HINTS = {
    "path nodes": "Nodes on the path, start and goal among them.",
    "length": "How long the path or the curve is.",
    "nodes visited": "Nodes from which the search went on to their neighbours. Bellman-Ford may "
    "visit one again, and counts it again.",
    "edges tried": "How often the search looked along an edge.",
    "longer than best": "By how much it is longer than the shortest clear path there is.",
    "longer by at most": "How much longer it may be than the shortest clear path there is: "
    "of that only a least length is proven here.",
    "distance kept": "Least distance from the obstacles anywhere along it; proven if there is a ✓.",
    "best possible": "Length of the shortest path that keeps the distance asked for, found apart "
    "from the mesh.",
    "gap": "By how much the path costs more than the cheapest in the mesh.",
    "visited": "Nodes from which the search went on to their neighbours; one that it visits again "
    "counts again. Of a search in rounds, how many of these.",
    "g so far": "Cost of the best path to the node that was found so far.",
    "h to go": "Cost of the shortest path from the node to the goal in the mesh without any "
    "obstacle: an estimate of what is left, and never too large.",
    "f": "What orders those that wait: the node with the least is visited next.",
    "tried": "How often the search looked along an edge.",
    "time": "Processor time of the search. Where few nodes are saved, A* can take longer than "
    "others, as it computes h for each.",
}
"""Explanations of headings, by their text without unit and number."""
_REST = re.compile(r"( \[|:).*")


def table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]], last: str = "") -> str:
    """An HTML table of rows under a head; ``last`` is one cell over the full width."""
    lines = [_row("th", head)] + [_row("td", row) for row in rows]
    if last:
        cell = f'<td colspan="{len(head)}"{_hint(last)} style="white-space:normal">{last}</td>'
        lines.append(f"<tr>{cell}</tr>")
    return (
        f'{_STYLE}<div style="margin:4px 8px 6px"><table class="abi-table">{"".join(lines)}'
        "</table></div>"
    )


def _row(tag: str, cells: tuple[str, ...]) -> str:
    hints = map(_hint, cells) if tag == "th" else [""] * len(cells)
    pairs = zip(cells, hints, strict=True)
    return f"<tr>{''.join(f'<{tag}{hint}>{cell}</{tag}>' for cell, hint in pairs)}</tr>"


def _hint(heading: str) -> str:
    """Attribute with the explanation of a heading; empty if it needs none."""
    hint = HINTS.get(_REST.sub("", heading))
    return "" if hint is None else f' title="{html.escape(hint)}"'

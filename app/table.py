"""Tables of numbers as HTML."""

from __future__ import annotations

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


def table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]], last: str = "") -> str:
    """An HTML table of rows under a head; ``last`` is one cell over the whole width."""
    lines = [_row("th", head)] + [_row("td", row) for row in rows]
    if last:
        cell = f'<td colspan="{len(head)}" style="white-space:normal">{last}</td>'
        lines.append(f"<tr>{cell}</tr>")
    return (
        f'{_STYLE}<div style="margin:4px 8px 6px"><table class="abi-table">{"".join(lines)}'
        "</table></div>"
    )


def _row(tag: str, cells: tuple[str, ...]) -> str:
    return f"<tr>{''.join(f'<{tag}>{cell}</{tag}>' for cell in cells)}</tr>"

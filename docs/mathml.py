"""Formulas as MathML, which browsers draw without loading anything."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert


def setup(app: Any) -> dict[str, bool]:
    """Make the renderer known to Sphinx."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _mathml(formula: str, display: str) -> str:
    """The formula with upright names of functions, and room around them."""
    named = re.sub(r"\\operatorname\{(\w+)\}", r"\\text{\1}", formula)
    room = r'<mo lspace="0.17em" rspace="0.17em">\1</mo>'
    return re.sub(r"<mi>(sin|cos|tan)</mi>", room, str(convert(named, display=display)))


def _inline(translator: Any, node: nodes.Element) -> None:
    translator.body.append(_mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _display(translator: Any, node: nodes.Element) -> None:
    formula = _mathml(node.astext(), "block")
    translator.body.append(f'<p style="margin: 1em 0">{formula}</p>')
    raise nodes.SkipNode

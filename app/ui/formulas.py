"""Formulas in Markdown: LaTeX between dollar signs, converted to MathML for the browser."""

from __future__ import annotations

import re

from latex2mathml.converter import convert

_BLOCK = re.compile(r"\$\$(.+?)\$\$", re.DOTALL)
_INLINE = re.compile(r"(?<![\\$])\$(?!\s)([^$\n]+?)(?<!\s)\$")


def with_formulas(markdown: str) -> str:
    """``markdown`` with every ``$…$`` and ``$$…$$`` replaced; it must hold no code spans."""
    blocks = _BLOCK.sub(
        lambda found: f"\n\n{convert(found[1].strip(), display='block')}\n\n", markdown
    )
    return _INLINE.sub(lambda found: convert(found[1]), blocks)

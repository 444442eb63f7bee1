"""Small robots as URDF text, and archives of them, for tests."""

from __future__ import annotations

import io
import zipfile

LINK = (
    '<link name="{0}"><collision><geometry><box size="0.1 0.1 0.3"/></geometry></collision></link>'
)


def urdf(*parts: str) -> str:
    """A robot of these elements."""
    return f'<?xml version="1.0"?><robot name="r">{"".join(parts)}</robot>'


def link(name: str) -> str:
    """A link with a box."""
    return LINK.format(name)


def joint(
    name: str,
    parent: str,
    child: str,
    kind: str = "revolute",
    axis: str = "0 0 1",
    extra: str = '<limit lower="-2" upper="2" velocity="1" effort="9"/>',
) -> str:
    """A joint 0.4 m above its parent."""
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="0 0 0.4" rpy="0.3 0.2 0.1"/>'
        f'<parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>{extra}</joint>'
    )


def arm(*changes: tuple[str, str]) -> str:
    """An arm of three joints from ``a`` to ``d``, with pieces of its text replaced."""
    text = urdf(
        *map(link, "abcd"),
        joint("p", "a", "b"),
        joint("q", "b", "c", axis="1 0 0"),
        joint("s", "c", "d", "prismatic"),
    )
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


def packed(files: dict[str, str | bytes]) -> bytes:
    """A zip of files."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return content.getvalue()


def follows(name: str, factor: float = 1.0, offset: float = 0.0) -> str:
    """What makes a joint follow another."""
    return f'<mimic joint="{name}" multiplier="{factor}" offset="{offset}"/>'


LIMIT = '<limit lower="-2" upper="2" velocity="1" effort="9"/>'
LINKAGE = urdf(
    *map(link, "abcdefghi"),
    joint("p", "a", "b"),
    joint("q", "b", "c", axis="1 0 0", extra=LIMIT + follows("m", 0.5, 0.1)),
    joint("s", "c", "d", "prismatic"),
    joint("m", "a", "g", axis="0 1 0"),  # the master of a joint on the way to the tip
    joint("n", "g", "h", axis="1 1 0", extra=LIMIT + follows("q", -1.5, 0.3)),  # a chain of masters
    joint("o", "h", "e", "prismatic", axis="0 1 0", extra=LIMIT + follows("s", 0.4, -0.2)),
    joint("u", "c", "f", axis="0 1 0", extra='<limit lower="0.3" upper="2"/>'),  # stands still
    joint("v", "f", "i", axis="1 0 0", extra=LIMIT + follows("p", -0.7)),
)
"""An arm from ``a`` to ``d`` with joints beside it that follow its own, move these, and rest."""

LINKED_BIT = arm(
    ('<joint name="s" type="prismatic">', '<joint name="s" type="continuous">'),
    (LIMIT + "</joint></robot>", follows("p", -0.5, 0.2) + "</joint></robot>"),
)
"""An arm whose third joint follows the first, as a parallel linkage does."""
OWN = {"linked": LINKED_BIT, "sliding": arm(), "linkage": LINKAGE}
"""Arms from ``a`` to ``d`` that are not shipped, by a name for tests."""

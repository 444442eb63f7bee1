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

"""Reader of SRDF files: the pairs of links whose collisions are ignored."""

from __future__ import annotations

from abi.robot.strict_xml import Element, parse


def read_srdf(content: bytes, name: str) -> frozenset[frozenset[str]]:
    """Pairs of links that an SRDF excludes from collision checks.

    The format: http://wiki.ros.org/srdf. Everything else in it is ignored, and so are links that
    the URDF does not have.

    Raises:
        SceneError: it is no SRDF, or it is truncated.
    """
    root = Element(parse(content, name), name, "robot")
    pairs = (
        frozenset((pair.text("link1"), pair.text("link2")))
        for pair in root.all("disable_collisions")
    )
    return frozenset(pair for pair in pairs if len(pair) == 2 and all(pair))

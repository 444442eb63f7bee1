"""A certificate as written: its margin, and its directions by the pair that they separate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from operator import attrgetter
from typing import Any, NamedTuple, TypeVar

from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.solids import ExactSolid, Vec3
from abi.verify.fault import Fault
from abi.verify.plan_fields import finite, list_of, mapping, number_of, vector_of

ARM = "arm.certificate"
MOTION = "certificate"
"""Names of certificates whose directions hold around a pose."""

CapsuleKey = tuple[int, int | str]
"""A capsule, and what it must keep clear of."""

_Key = TypeVar("_Key")
_NONE = Fraction(0)


class CertifiedPlane(NamedTuple):
    """A direction that separates a curve or a capsule from something on a piece of the motion.

    Attributes:
        start, end: parameters of the piece.
        at: parameter of the pose around which it holds; of a curve the start.
        normal: the direction.
        closer: whether it separates the hull in a capsule, not the capsule.
    """

    start: Fraction
    end: Fraction
    at: Fraction
    normal: Vec3
    closer: bool = False


def claimed_margin(
    name: str,
    section: dict[str, Any],
    required: Fraction,
    obstacles: Sequence[ExactSolid | ExactMesh],
    slack: Fraction = _NONE,
) -> Fraction | None:
    """Margin of a certificate, [unit], which must be what the plan says; None without obstacles.

    Args:
        name: of the section of the plan, whose ``certificate`` it is.
        section: that section.
        required: margin from which on it is certified, [unit].
        obstacles: those of the scene.
        slack: what may be missing, [unit].

    Raises:
        Fault: the plan says something else.
        SceneError: the margin is no number.
    """
    given, stated = section["certificate"].get("margin"), section.get("clearance")
    margin = None if given is None else Fraction(finite(f"{name}.certificate.margin", given))
    if (margin is None) != (not obstacles):
        raise Fault("a margin belongs to obstacles")
    if (stated is None) != (margin is None) or (margin is not None and number_of(stated) != margin):
        raise Fault("its margin is not the clearance stated")
    if margin is not None and margin < -slack:
        raise Fault("its margin is negative")
    enough = margin is None or margin >= required - slack
    if section.get("certified") is not enough:
        subject = "arm" if name == "arm" else "curve"
        raise Fault(f"as the {subject} is {'not ' if enough else ''}said to be certified")
    if name == "arm" and section.get("reachable") is not True:
        raise Fault("the motion is said to be out of reach")
    return margin


def planes_of(
    field: str, certificate: dict[str, Any], key_of: Callable[[dict[str, Any]], _Key]
) -> dict[_Key, list[CertifiedPlane]]:
    """Planes by key, in the order in which their pieces begin.

    Args:
        field: name of the certificate.
        certificate: as in a plan's JSON.
        key_of: function from an entry to its key.

    Raises:
        SceneError: a field has the wrong form.
        Fault: ``key_of`` knows no key.
    """
    planes: dict[_Key, list[CertifiedPlane]] = {}
    names = ("t0", "t1", "at" if field in (ARM, MOTION) else "t0")
    for entry in list_of(f"{field}.planes", certificate.get("planes")):
        data = mapping(f"{field}.planes", entry)
        key = key_of(data)
        start, end, at = (
            Fraction(finite(f"{field}.planes.{name}", data.get(name))) for name in names
        )
        normal = vector_of(f"{field}.planes.direction", data.get("direction"))
        plane = CertifiedPlane(start, end, at, normal, data.get("hull") is True)
        planes.setdefault(key, []).append(plane)
    for group in planes.values():
        group.sort(key=attrgetter("start"))
    return planes


def capsule_of(entry: dict[str, Any], capsules: int) -> int:
    """Number of the capsule that an entry names, checked against their count.

    Raises:
        Fault: it names none.
    """
    capsule = entry.get("capsule")
    if type(capsule) is not int or not 0 <= capsule < capsules:
        raise Fault("a direction belongs to no capsule")
    return capsule


def words_of(
    margin: Fraction | None, unit: str, links: str = "its links", asked: float = 0.0
) -> str:
    """Phrase for the margin that links keep, [unit], and for more that was asked for.

    Args:
        margin: the margin; None if there is no obstacle.
        unit: of lengths.
        links: what keeps it.
        asked: what the scene asks for.
    """
    if margin is None:
        return "there is no obstacle"
    kept = f"{links} keep {float(margin):.9g} {unit}" if margin else f"{links} touch no obstacle"
    less = margin < Fraction(asked) * (1 - Fraction(1, 10**9))
    return f"{kept}, less than the {asked:g} {unit} asked for" if less else kept

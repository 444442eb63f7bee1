"""Contents of the lock files, so that pip and uv install the same from them on any day."""

import re
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, requires
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
LOCKS = sorted(ROOT.glob("requirements*.lock"))
ENTRY = re.compile(r"^([A-Za-z0-9._-]+)(?:\[([^]]*)\])?==", re.MULTILINE)


def locked_extras(lock: Path) -> dict[str, set[str]]:
    """Each locked package's name with the extras that its line names."""
    found = ENTRY.findall(lock.read_text())
    return {canonicalize_name(name): set(extras.split(",")) - {""} for name, extras in found}


def test_an_extra_that_a_locked_package_asks_for_is_locked_by_name() -> None:
    """Else pip takes the newest release for it, which has no hash here, once there is one."""
    asked = 0
    for lock in LOCKS:
        locked = locked_extras(lock)
        for name in locked:
            for requirement in _requirements_with_extras(name, locked):
                asked += 1
                missing = requirement.extras - locked[canonicalize_name(requirement.name)]
                assert not missing, f"{lock.name}: {name} asks for {requirement}"
    assert asked


def _requirements_with_extras(name: str, locked: dict[str, set[str]]) -> Iterator[Requirement]:
    """Requirements with extras of a locked package on this system, none if it is not installed."""
    try:
        needed = requires(name) or []
    except PackageNotFoundError:  # for another system, or for the documentation alone
        return
    for requirement in map(Requirement, needed):
        marker = requirement.marker
        applies = marker is None or any(
            marker.evaluate({"extra": extra}) for extra in locked[name] | {""}
        )
        if requirement.extras and applies and canonicalize_name(requirement.name) in locked:
            yield requirement

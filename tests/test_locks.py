"""Contents of the lock files, so that pip and uv install the same from them on any day."""

import re
from importlib.metadata import PackageNotFoundError, requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
LOCKS = sorted(ROOT.glob("requirements*.lock"))
ENTRY = re.compile(r"^([A-Za-z0-9._-]+)(?:\[([^]]*)\])?==", re.MULTILINE)


def locked_extras(lock: Path) -> dict[str, set[str]]:
    """Each locked package's name with the extras that its line names."""
    found = ENTRY.findall(lock.read_text())
    return {canonicalize_name(name): set(extras.split(",")) - {""} for name, extras in found}


@pytest.mark.parametrize("lock", LOCKS, ids=lambda path: path.stem)
def test_an_extra_that_a_locked_package_asks_for_is_locked_by_name(lock: Path) -> None:
    """Else pip takes the newest release for it, which has no hash here, once there is one."""
    locked = locked_extras(lock)
    asked = 0
    for name in locked:
        try:
            needed = requires(name) or []
        except PackageNotFoundError:  # for another system, or for the documentation alone
            continue
        for requirement in map(Requirement, needed):
            other = canonicalize_name(requirement.name)
            marker = requirement.marker
            if not requirement.extras or other not in locked:
                continue
            if marker is not None and not any(
                marker.evaluate({"extra": extra}) for extra in locked[name] | {""}
            ):
                continue
            asked += 1
            assert requirement.extras <= locked[other], f"{name} asks for {requirement}"
    assert asked

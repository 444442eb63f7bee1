"""Sizes of the packages that an installation brings, largest first.

PYTHONPATH=. ENVIRONMENT/bin/python -m benchmarks.sizes
"""

from __future__ import annotations

from importlib.metadata import Distribution, distributions
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from benchmarks.report import table

PROJECT = "abi-visualiser"


def needed(project: str) -> dict[str, Distribution]:
    """Installed packages that a project needs without its extras, those they need among them."""
    installed: dict[str, Distribution] = {
        canonicalize_name(one.name): one for one in distributions()
    }
    seen, waiting = set[tuple[str, str]](), [(project, "")]
    while waiting:
        name, extra = waiting.pop()
        if (name, extra) in seen or name not in installed:
            continue
        seen.add((name, extra))
        for requirement in map(Requirement, installed[name].requires or []):
            if requirement.marker is None or requirement.marker.evaluate({"extra": extra}):
                other = canonicalize_name(requirement.name)
                waiting += [(other, wanted) for wanted in ("", *requirement.extras)]
    return {name: installed[name] for name, _ in seen if name != project}


def size(distribution: Distribution) -> float:
    """Size of a package's files, without what Python compiles of them, [MB]."""
    paths = [Path(str(file.locate())) for file in distribution.files or []]
    return (
        sum(path.stat().st_size for path in paths if path.is_file() and path.suffix != ".pyc") / 1e6
    )


if __name__ == "__main__":
    sizes = {name: size(one) for name, one in needed(PROJECT).items()}
    largest = sorted(sizes, key=sizes.__getitem__, reverse=True)
    print(table([{"package": name, "MB": sizes[name]} for name in largest]))
    print(f"{len(sizes)} packages, {sum(sizes.values()):.0f} MB")

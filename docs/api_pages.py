"""Pages of the API reference: one per package of ``abi/``, and one of ``abi_sweep/``."""

from __future__ import annotations

import ast
import re
from pathlib import Path

_MARKUP = re.compile(r"(?<![`*:])(?<=\w)\*(?!\*)|(?<!`)\|(?!`)")
"""Characters that reST would take for markup: the star of A*, the bars of an absolute value."""


def write(root: Path, folder: Path) -> None:
    """Write ``folder/<name>.rst`` for each package of ``abi``, for ``abi_sweep``, and for modules.

    Kernels are left out: they are called by the module beside them.
    """
    folder.mkdir(exist_ok=True)
    package, studies = root / "abi", root / "abi_sweep"
    _keep(folder / "abi_sweep.rst", "abi_sweep", _modules(studies), _summary(studies))
    _keep(folder / "modules.rst", "Modules beside the packages", _modules(package))
    for inner in sorted(package.iterdir()):
        if (inner / "__init__.py").exists():
            names = _modules(inner)
            for part in sorted(inner.iterdir()):
                if (part / "__init__.py").exists():
                    names += _modules(part)
            _keep(folder / f"{inner.name}.rst", f"abi.{inner.name}", names, _summary(inner))


def escape(
    app: object, what: str, name: str, obj: object, options: object, lines: list[str]
) -> None:
    """Escape the formulas of a docstring, outside of its literal text."""
    for k, line in enumerate(lines):
        parts = re.split(r"(``.*?``|:\w+:`.*?`)", line)
        parts[::2] = [_MARKUP.sub(r"\\\g<0>", part) for part in parts[::2]]
        lines[k] = "".join(parts)


def _modules(folder: Path) -> list[str]:
    roots = ("abi", "abi_sweep")
    root = next(parent for parent in (folder, *folder.parents) if parent.name in roots)
    return [
        ".".join(file.relative_to(root.parent).with_suffix("").parts)
        for file in sorted(folder.glob("*.py"))
        if not file.stem.startswith("_") and not file.stem.endswith("_kernels")
    ]


def _summary(package: Path) -> str:
    text = ast.get_docstring(ast.parse((package / "__init__.py").read_text(encoding="utf-8")))
    return text or ""


def _keep(file: Path, title: str, names: list[str], summary: str = "") -> None:
    """Write the page unless it is up to date: Sphinx reads new files again."""
    parts = [title, "=" * len(title), "", summary, ""]
    for name in names:
        parts += [name, "-" * len(name), "", f".. automodule:: {name}", ""]
    text = "\n".join(parts)
    if not file.exists() or file.read_text(encoding="utf-8") != text:
        file.write_text(text, encoding="utf-8")

"""Scene files: YAML 1.2 or JSON into plain data, and back, with strict limits.

Duplicate keys, anchors, tags and NaN are refused: each of them has another meaning in some
reader, or grows without limit.
"""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any, NoReturn

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import AliasEvent, CollectionStartEvent, ScalarEvent

from abi.atomic_file import replace_file
from abi.errors import SceneError

MAX_BYTES = 400_000
"""Largest scene file: some 3,000 obstacles, and a few seconds to read as YAML."""
_MAX_DEPTH = 16

_ENDINGS = (".yaml", ".yml", ".json")


def parse(path: Path) -> object:
    """Plain data of the scene file at ``path``, at most ``MAX_BYTES`` long.

    Raises:
        SceneError: missing, unreadable, too large, or not YAML or JSON; names the file and line.
    """
    _refuse_ending(path)
    return parse_bytes(read_file(path, MAX_BYTES), path.name)


def read_file(path: Path, most: int) -> bytes:
    """The first ``most`` bytes of a file, and one more where there are more.

    Raises:
        SceneError: missing or unreadable.
    """
    try:
        with path.open("rb") as file:
            return file.read(most + 1)
    except (OSError, ValueError) as error:  # a name that can be no path is a ValueError
        reason = (getattr(error, "strerror", None) or "no path").lower()
        raise SceneError("scene", str(path), f"a file that can be read ({reason})") from None


def parse_bytes(content: bytes, name: str) -> object:
    """Plain data of a scene file's content; the ending of ``name`` gives the format."""
    if len(content) > MAX_BYTES:
        raise SceneError("scene", name, f"a file of at most {MAX_BYTES // 1000} kB")
    try:
        text = content.decode("utf-8-sig")
        if name.lower().endswith(".json"):
            return json.loads(text, object_pairs_hook=_unique, parse_constant=_refuse_constant)
        _refuse_traps(text)
        return YAML(typ="safe", pure=True).load(text)
    except SceneError as error:
        raise SceneError("scene", name, error.expected) from None
    except UnicodeDecodeError:
        raise SceneError("scene", name, "text in UTF-8") from None
    except YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f" (line {mark.line + 1})" if mark is not None else ""
        problem = (getattr(error, "problem", None) or "not YAML").splitlines()[0]
        raise SceneError("scene", name, f"valid YAML: {problem}{line}") from None
    except json.JSONDecodeError as error:
        raise SceneError("scene", name, f"valid JSON: {error.msg} (line {error.lineno})") from None
    except (ValueError, RecursionError):
        raise SceneError("scene", name, "plain numbers, lists and mappings") from None


def write(data: dict[str, Any], path: Path) -> None:
    """Write ``data`` as YAML or JSON, by the ending of ``path``, in one step.

    A file that was there keeps its permissions; a new one has those of any new file.

    Raises:
        SceneError: the file cannot be written, or could not be read again; nothing of it is left.
    """
    _refuse_ending(path)
    text = dump(data, path.name)
    try:
        replace_file(path, text.encode())
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or "not writable").lower()
        raise SceneError("scene", str(path), f"a place that can be written ({reason})") from None


def dump(data: dict[str, Any], name: str) -> str:
    """``data`` as text, YAML or JSON by the ending of ``name``.

    Raises:
        SceneError: it is too long to be read again.
    """
    if name.lower().endswith(".json"):
        text = json.dumps(data, indent=2) + "\n"
    else:
        stream = io.StringIO()
        yaml = YAML(typ="safe", pure=True)
        yaml.default_flow_style = None
        yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
        yaml.dump(data, stream)
        text = stream.getvalue()
    if len(text.encode()) > MAX_BYTES:
        kilobytes = f"{len(text.encode()) // 1000} kB"
        raise SceneError(
            "scene", kilobytes, f"at most {MAX_BYTES // 1000} kB, with fewer obstacles"
        )
    return text


def _refuse_ending(path: Path) -> None:
    if path.suffix.lower() not in _ENDINGS:
        raise SceneError("scene", str(path), "a file that ends in .yaml, .yml or .json")


def _refuse_traps(text: str) -> None:
    """Refuse anchors, tags and depth, which make a small YAML text large or ambiguous."""
    depth = 0
    for event in YAML(typ="safe", pure=True).parse(text):
        if isinstance(event, AliasEvent) or getattr(event, "anchor", None):
            raise SceneError("scene", "", "no YAML anchors or aliases")
        if isinstance(event, CollectionStartEvent | ScalarEvent) and event.ctag:
            raise SceneError("scene", "", "no YAML tags")
        if isinstance(event, CollectionStartEvent):
            depth += 1
        elif type(event).__name__ in ("SequenceEndEvent", "MappingEndEvent"):
            depth -= 1
        if depth > _MAX_DEPTH:
            raise SceneError("scene", "", f"at most {_MAX_DEPTH} levels")


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    keys = [key for key, _ in pairs]
    if len(set(keys)) < len(keys):
        repeated = next(key for key in keys if keys.count(key) > 1)
        raise SceneError("scene", "", f"each field once, {repeated} stands there twice")
    return dict(pairs)


def _refuse_constant(name: str) -> NoReturn:
    raise SceneError("scene", "", f"finite numbers, not {name}")

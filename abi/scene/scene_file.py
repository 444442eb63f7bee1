"""Reader and writer of scene files: YAML 1.2 or JSON, as plain data, within strict limits.

Duplicate keys, anchors, tags and NaN are refused: readers disagree about their meaning, or they can
grow without limit.
"""

from __future__ import annotations

import copy
import io
import json
import re
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, NoReturn

from ruamel.yaml import YAML
from ruamel.yaml.constructor import DuplicateKeyError
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import AliasEvent, CollectionStartEvent, ScalarEvent
from ruamel.yaml.nodes import ScalarNode
from ruamel.yaml.representer import SafeRepresenter
from ruamel.yaml.resolver import implicit_resolvers as _OTHERS

from abi.atomic_file import replace_file
from abi.errors import SceneError

MAX_BYTES = 400_000
"""Most bytes of a scene file in YAML: some 1,000 obstacles, and a few seconds to read."""
MAX_JSON_BYTES = 2_000_000
"""Most bytes in JSON: some 5,000 obstacles."""
_MAX_DEPTH = 16
_MOST_EVENTS = 60_000
"""Most YAML events, such as scalars and starts of lists: some 2,500 obstacles."""
_SHORT = 20_000
"""Characters of a YAML text that is kept, as all shipped ones are."""
_VERSION = re.compile(r"^%YAML[ \t]+(\S{1,20})", re.MULTILINE)
_TAG = "tag:yaml.org,2002:"
_AMBIGUOUS = re.compile(
    r"[-+]?(?:0o?[0-9]+|0b[01_]+|[0-9][0-9.]*_[0-9_.]*(?:[eE][-+]?[0-9_]+)?)"
    r"|(?:0x[0-9a-fA-F]*_|[-+]0x)[0-9a-fA-F_]*"
)
"""Plain words that are numbers by one version of YAML, and others or none by another."""
_WORDS = re.compile(r"[^\W\d](?:[\w ./-]*\w)?")
"""Text in which YAML has no signs of its own."""
_MANY = 1_000  # obstacles that are not tried to be written as YAML

ENDINGS = (".yaml", ".yml", ".json")
"""Endings of scene files."""


def parse(path: Path) -> object:
    """Read the plain data of the scene file at ``path``.

    Raises:
        SceneError: it is missing, unreadable, larger than ``MAX_BYTES`` (in JSON,
            ``MAX_JSON_BYTES``), or neither YAML nor JSON; names the file and line.
    """
    _refuse_ending(path)
    return parse_bytes(read_file(path, _most(path.name)), path.name)


def read_file(path: Path, most: int) -> bytes:
    """The first ``most`` bytes of a file, and one more if it is longer.

    Raises:
        SceneError: it is missing or unreadable.
    """
    try:
        with path.open("rb") as file:
            return file.read(most + 1)
    except (OSError, ValueError) as error:  # a name that can be no path is a ValueError
        reason = (getattr(error, "strerror", None) or "no path").lower()
        raise SceneError("scene", str(path), f"a file that can be read ({reason})") from None


def parse_bytes(content: bytes, name: str, most_json: int = MAX_JSON_BYTES) -> object:
    """Parse a scene file's content; the ending of ``name`` gives the format.

    Raises:
        SceneError: it is larger than ``MAX_BYTES``, in JSON than ``most_json``, or neither format.
    """
    most = most_json if is_json(name) else MAX_BYTES
    if len(content) > most:
        expected = f"a file of at most {most // 1000} kB"
        raise SceneError("scene", name, expected if is_json(name) else f"{expected}, or JSON")
    try:
        text = content.decode("utf-8-sig")
        if is_json(name):
            data = json.loads(text, object_pairs_hook=unique, parse_constant=_refuse_constant)
            _refuse_depth(data)
            return data
        return copy.deepcopy(_kept(text)) if len(text) < _SHORT else _of_yaml(text)
    except SceneError as error:
        raise SceneError("scene", name, error.expected) from None
    except UnicodeDecodeError:
        raise SceneError("scene", name, "text in UTF-8") from None
    except DuplicateKeyError as error:
        repeated = str(error.problem).split('"')[1]
        expected = f"each field once, {repeated} stands there twice"
        raise SceneError("scene", name, expected) from None
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
    """Write ``data`` atomically as YAML or JSON, by the ending of ``path``.

    An existing file keeps its permissions; a new one has those of any new file.

    Raises:
        SceneError: it cannot be written, or could not be read again; no part of it is left.
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
    if is_json(name):
        text = json.dumps(data, indent=2 if len(data.get("obstacles", ())) < _MANY else None) + "\n"
    else:
        text = yaml_text(data)
    if len(text.encode()) > _most(name):
        kilobytes = f"{len(text.encode()) // 1000} kB"
        limit = f"at most {_most(name) // 1000} kB, with fewer obstacles"
        raise SceneError("scene", kilobytes, limit if is_json(name) else f"{limit} or as JSON")
    if not is_json(name) and len(data.get("obstacles", ())) >= _MANY:
        _refuse_traps(text)
    return text


def _of_text(representer: SafeRepresenter, text: str) -> ScalarNode:
    """Text, in quotes unless YAML 1.1 and 1.2 take it for text, as neither ``on`` nor ``1:30``."""
    style: str | None = "'"
    if not text.isprintable():
        style = '"'  # escapes line breaks, of which 1.1 has more
    elif _WORDS.fullmatch(text) and not any(one.match(text) for _, _, one, _ in _OTHERS):
        style = None
    return representer.represent_scalar(f"{_TAG}str", text, style=style)


def _of_number(representer: SafeRepresenter, number: float) -> ScalarNode:
    """A number with a point, without which YAML 1.1 takes ``1e-05`` for text."""
    text = repr(number)
    text = text if "." in text else text.replace("e", ".0e")
    return representer.represent_scalar(f"{_TAG}float", text)


def yaml_text(data: dict[str, Any], width: int | None = None) -> str:
    """``data`` as YAML in its order, with lists of numbers in lines of ``width`` letters.

    Numbers are finite. Readers of YAML 1.1, which ROS reads, and 1.2 find the same in it.
    """
    stream = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = width
    own = {str: _of_text, float: _of_number}
    yaml.representer.yaml_representers = yaml.representer.yaml_representers | own
    yaml.dump(data, stream)
    return stream.getvalue()


def is_json(name: str) -> bool:
    """Check whether a file of that name holds JSON."""
    return name.lower().endswith(".json")


def _most(name: str) -> int:
    return MAX_JSON_BYTES if is_json(name) else MAX_BYTES


def _refuse_ending(path: Path) -> None:
    if path.suffix.lower() not in ENDINGS:
        raise SceneError("scene", str(path), "a file that ends in .yaml, .yml or .json")


def _of_yaml(text: str) -> object:
    declared = _VERSION.search(text)
    if declared and declared[1] != "1.2":
        raise SceneError("scene", "", f"YAML 1.2, the text declares {declared[1]}")
    _refuse_traps(text)
    return YAML(typ="safe", pure=True).load(text)


@lru_cache(maxsize=64)
def _kept(text: str) -> object:
    """What a YAML text says: to read it takes twenty times as long as to make a scene of it."""
    return _of_yaml(text)


def _refuse_traps(text: str) -> None:
    """Refuse anchors, tags and depth, which make a small YAML text large or ambiguous."""
    depth = 0
    for count, event in enumerate(YAML(typ="safe", pure=True).parse(text)):
        if count > _MOST_EVENTS:
            expected = (
                "fewer entries, or the same as JSON, which is read in a hundredth of the time"
            )
            raise SceneError("scene", "", expected)
        if isinstance(event, AliasEvent) or getattr(event, "anchor", None):
            raise SceneError("scene", "", "no YAML anchors or aliases")
        if isinstance(event, CollectionStartEvent | ScalarEvent) and event.ctag:
            raise SceneError("scene", "", "no YAML tags")
        if isinstance(event, ScalarEvent) and not event.style:
            if event.value == "<<":
                raise SceneError("scene", "", "no YAML merge keys")
            if _AMBIGUOUS.fullmatch(event.value):
                number = event.value[:40]
                expected = f"no number such as {number}, which versions of YAML read otherwise"
                raise SceneError("scene", "", expected)
        if isinstance(event, CollectionStartEvent):
            depth += 1
        elif type(event).__name__ in ("SequenceEndEvent", "MappingEndEvent"):
            depth -= 1
        if depth > _MAX_DEPTH:
            raise SceneError("scene", "", f"at most {_MAX_DEPTH} levels")


def _refuse_depth(data: object) -> None:
    level = [data]
    for _ in range(_MAX_DEPTH + 1):
        inner = [one for one in level if isinstance(one, dict | list)]
        level = [
            one for many in inner for one in (many.values() if isinstance(many, dict) else many)
        ]
        if not level:
            return
    raise SceneError("scene", "", f"at most {_MAX_DEPTH} levels")


def text_of(data: dict[str, Any]) -> tuple[str, str]:
    """Name and text of a scene file: ``scene.yaml``, or ``scene.json`` if that is too long.

    Raises:
        SceneError: the JSON is too long, too.
    """
    if len(data.get("obstacles", ())) < _MANY:
        with suppress(SceneError):
            return "scene.yaml", dump(data, "scene.yaml")
    return "scene.json", dump(data, "scene.json")


def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """The mapping of pairs, as JSON's reader asks for it.

    Raises:
        SceneError: a field stands there twice.
    """
    keys = [key for key, _ in pairs]
    if len(set(keys)) < len(keys):
        repeated = next(key for key in keys if keys.count(key) > 1)
        raise SceneError("scene", "", f"each field once, {repeated} stands there twice")
    return dict(pairs)


def _refuse_constant(name: str) -> NoReturn:
    raise SceneError("scene", "", f"finite numbers, not {name}")

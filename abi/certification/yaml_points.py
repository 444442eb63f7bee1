"""Reader of long messages in YAML, whose points a reader of YAML takes minutes for.

Points as ``abi export`` and PyYAML write them, one field a line, are read as JSON, in which such
lines mean the same. The rest, and a file in which they might be something else, is read as YAML.
"""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Sequence
from contextlib import suppress

from abi.errors import SceneError
from abi.scene.scene_file import MAX_BYTES, parse_bytes, unique

_NUMBER = r"-?(?:0|[1-9][0-9]{0,400})(?:\.[0-9]{1,400})?(?:[eE][-+]?[0-9]{1,4})?"
_LIST = rf"\[(?:{_NUMBER}(?:, {_NUMBER})*)?\]"
_PAIR = rf"[a-z_]+: {_NUMBER}"
_LINE = re.compile(rf"( *)(- |  )([a-z_]+): ({_LIST}|\{{{_PAIR}(?:, {_PAIR})*\}}|{_NUMBER})")
_KEY = re.compile(r"([a-z_]+):")
_STANDS_FOR = "points-{}-read-apart"
_STANDING = re.compile(r"points-([0-9]{1,9})-read-apart")


def parse_yaml_points(content: bytes, name: str, least: int = MAX_BYTES) -> object:
    """Plain data of a message in YAML.

    Args:
        content: of the file.
        name: of the file.
        least: bytes up to which a file is read as YAML at once.

    Raises:
        SceneError: it is no YAML, or what is not in lines of points is larger than a scene may be.
    """
    if len(content) > least:
        with suppress(SceneError, UnicodeDecodeError):
            text = content.decode("utf-8-sig")
            if not _STANDING.search(text):
                rest, runs = _taken_apart(text)
                data = parse_bytes(rest.encode(), name)
                if _put_back(data, runs) == len(runs):
                    return data
    return parse_bytes(content, name)


def _taken_apart(text: str) -> tuple[str, list[list[dict[str, object]]]]:
    """The text with a word in place of each run of points, and these."""
    rest, runs, indent = list[str](), list[list[dict[str, object]]](), None
    for line in text.split("\n"):
        found = _LINE.fullmatch(line.removesuffix("\r"))
        if found is None or (found[1] != indent and found[2] != "- "):
            indent = None
            rest.append(line)
            continue
        if found[1] != indent:
            indent = found[1]
            rest.append(f"{indent}- {_STANDS_FOR.format(len(runs))}")
            runs.append([])
        if found[2] == "- ":
            runs[-1].append({})
        if found[3] in runs[-1][-1]:
            raise SceneError("scene", "", f"each field once, {found[3]} stands there twice")
        value = _KEY.sub(r'"\1":', found[4])
        runs[-1][-1][found[3]] = json.loads(value, object_pairs_hook=unique)
    return "\n".join(rest), runs


def _put_back(data: object, runs: Sequence[Sequence[object]]) -> int:
    """Put runs of points where lists have the word for them, and count them."""
    count, inside = 0, [data]
    while inside:
        one = inside.pop()
        if isinstance(one, dict):
            inside += one.values()
        if isinstance(one, list):
            inside += one
            found = [_STANDING.fullmatch(each) if isinstance(each, str) else None for each in one]
            parts = [
                [each] if word is None else runs[int(word[1])]
                for each, word in zip(one, found, strict=True)
            ]
            count += sum(word is not None for word in found)
            one[:] = itertools.chain.from_iterable(parts)
    return count

"""Result codes: a student's settings, short enough to paste into a form."""

from __future__ import annotations

import base64
import hashlib
import json
import zlib
from collections.abc import Mapping, Sequence
from typing import Any

from abi.errors import AbiError
from abi.scene.scene import Scene

_CHECK = 4
"""Characters of the checksum, which reveals a code that was copied in part."""
FLOOR = "floor"
"""What may be kept beside a scene's fields: the height below which no arm gets, which two set."""
_MOST = 20_000
"""Most bytes of a decompressed code."""


def fingerprint(scene: Scene, keep: Sequence[str]) -> str:
    """Sixteen characters that identify the values of fields such as ``search.taut``.

    Args:
        scene: the scene.
        keep: the fields' names, which may come from anyone.
    """
    data = scene.model_dump(mode="json")
    kept = {name: _field(data, name) for name in keep}
    return hashlib.sha256(json.dumps(kept, sort_keys=True).encode()).hexdigest()[:16]


def result_code(scene: Scene, keep: Sequence[str]) -> str:
    """Encode a scene: unprotected fields that differ from the defaults."""
    usual = _free(Scene(version=1), keep)
    changes = _difference(_free(scene, keep), usual)
    packer = zlib.compressobj(9, wbits=-zlib.MAX_WBITS)
    packed = packer.compress(json.dumps(changes, separators=(",", ":")).encode()) + packer.flush()
    body = base64.urlsafe_b64encode(packed).decode().rstrip("=")
    return _checked(body) + body


def scene_of_code(code: str, task: Scene, keep: Sequence[str]) -> Scene:
    """Decode a scene.

    Args:
        code: by :func:`result_code`; it may come from anyone.
        task: the scene that was set, which has the fields that stay.
        keep: these fields.

    Raises:
        AbiError: it is no such code.
        SceneError: a field of it is wrong.
    """
    if not is_whole(code):
        raise AbiError("This is no whole code; copy all of its letters.")
    body = code.strip()[_CHECK:]
    try:
        packed = base64.urlsafe_b64decode(body + "=" * (-len(body) % 4))
        changes = json.loads(zlib.decompressobj(-zlib.MAX_WBITS).decompress(packed, _MOST))
    except (ValueError, zlib.error, RecursionError):
        changes = None
    if not isinstance(changes, dict):
        raise AbiError("This is no code of a result.")
    fields = _merged(_free(Scene(version=1), keep), changes)
    return task.replace(**{name: fields[name] for name in fields if name not in keep})


def is_whole(code: str) -> bool:
    """Check whether a text is a code of which no letter is missing or wrong."""
    check, body = code.strip()[:_CHECK], code.strip()[_CHECK:]
    return body != "" and _checked(body) == check


def _checked(body: str) -> str:
    return hashlib.sha256(body.encode()).hexdigest()[:_CHECK]


def _field(data: Mapping[str, Any], name: str) -> Any:
    if name == FLOOR:
        return min(data["arm"]["base"][2], data["workspace"]["min"][2])
    section, _, field = name.partition(".")
    part = data.get(section)
    return part.get(field) if field and isinstance(part, dict) else part


def _free(scene: Scene, keep: Sequence[str]) -> dict[str, Any]:
    """Unprotected fields of a scene as plain data."""
    data = scene.model_dump(mode="json")
    del data["version"]
    for name in keep:
        section, _, field = name.partition(".")
        if not field:
            data.pop(section, None)
        elif isinstance(part := data.get(section), dict):
            part.pop(field, None)
    return data


def _difference(data: Mapping[str, Any], usual: Mapping[str, Any]) -> dict[str, Any]:
    """Values that differ from the defaults, by field in sections."""
    found: dict[str, Any] = {}
    for name, value in data.items():
        before = usual.get(name)
        if isinstance(value, dict) and isinstance(before, dict):
            value = _difference(value, before)
            before = {}
        if value != before:
            found[name] = value
    return found


def _merged(usual: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """The defaults with changes; changes of unknown fields are dropped."""
    return {
        name: {**value, **{k: v for k, v in changes.get(name, {}).items() if k in value}}
        if isinstance(value, dict) and isinstance(changes.get(name, {}), dict)
        else changes.get(name, value)
        for name, value in usual.items()
    }

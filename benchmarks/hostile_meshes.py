"""Meshes that nobody should have made, in every format."""

from __future__ import annotations

import io
import json
import random
import re
import struct
import zipfile
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import trimesh

from abi.obstacles.triangle_mesh.mesh_reader import SUFFIXES
from app.reading.reading import ReadingRequest

Chance = random.Random

WORDS = ("nan", "-inf", "1e999", "-1", "0", "1e-320", "99999999999", "9" * 400, "٢", "", "${x}")
"""Words that stand where a number should."""
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?")


def damaged(chance: Chance, content: bytes) -> bytes:
    """A content with a few bytes changed, cut, doubled, or numbers replaced."""
    text = bytearray(content)
    for _ in range(chance.randint(1, 5)):
        at = chance.randrange(len(text) + 1)
        length = chance.choice((1, 4, 40, len(text)))
        match chance.randrange(5):
            case 0:
                text[at : at + 1] = chance.randbytes(1)
            case 1:
                del text[at : at + length]
            case 2:
                text[at:at] = text[at : at + length] * chance.choice((1, 1, 50))
            case 3:
                text[at : at + 4] = chance.choice((b"\xff" * 4, bytes(4), b"\0\0\xc0\x7f", b"<a>"))
            case _:
                found = _NUMBER.search(text, at)
                if found:
                    text[found.start() : found.end()] = chance.choice(WORDS).encode()
    return bytes(text[:4_000_000])


def maybe_damaged(chance: Chance, content: bytes, share: float = 0.5) -> bytes:
    """A content that is damaged in a share of all cases."""
    return damaged(chance, content) if chance.random() < share else content


def hostile_mesh(chance: Chance, names: Sequence[str]) -> ReadingRequest:
    """A mesh with something wrong.

    Args:
        chance: draws what.
        names: ways to name what is outside; it may name one.
    """
    suffix = chance.choice(SUFFIXES)
    shape = chance.choice(_SOLIDS)()
    with np.errstate(all="ignore"):
        if chance.random() < 0.3:
            shape.vertices[chance.randrange(8)] *= chance.choice((np.nan, np.inf, 1e300, 0))
        plain = shape.export(file_type=suffix[1:])
    content = plain if isinstance(plain, bytes) else str(plain).encode()
    if chance.random() < 0.8:
        content = _WRONG[suffix](chance, content, chance.choice(names))
    other = chance.choice(SUFFIXES) if chance.random() < 0.05 else suffix
    return ReadingRequest("mesh", f"part{other}", maybe_damaged(chance, content))


def _torus() -> Any:
    return trimesh.creation.torus(1.0, 0.3)


def _cylinder() -> Any:
    return trimesh.creation.cylinder(1.0, 2.0)


def _stl(chance: Chance, content: bytes, name: str) -> bytes:
    return chance.choice(
        (b"solid x\n" + b"facet " * 300_000, content[:80] + b"\xff" * 4 + content[84:])
    )


def _obj(chance: Chance, content: bytes, name: str) -> bytes:
    return chance.choice(
        (
            f"mtllib {name}\ncall {name}\nmap_Kd {name}\n".encode() + content,
            b"v 0 0 0\n" * 3 + b"f 1 2 3\n" * 400_000,
            b"v 0 0 0\nf " + b"1 " * 100_000,
            content + b"f 1 99999999999 -7\n",
        )
    )


def _ply(chance: Chance, content: bytes, name: str) -> bytes:
    return chance.choice(
        (
            content.replace(b"element face ", b"element face 99"),
            content.replace(b"element vertex ", b"element vertex 999999"),
            content.replace(b"format", f"comment TextureFile {name}\nformat".encode()),
            content.replace(b"uchar", b"int64", 1).replace(b"list", b"list list"),
        )
    )


def _off(chance: Chance, content: bytes, name: str) -> bytes:
    return chance.choice(
        (b"OFF\n1999999 1999999 0\n", content.replace(b"OFF", b"COFF"), content * 40)
    )


def _dae(chance: Chance, content: bytes, name: str) -> bytes:
    return chance.choice(
        (
            content.replace(b"<COLLADA", f'<!DOCTYPE a SYSTEM "{name}"><COLLADA'.encode()),
            content.replace(b'url="#', f'url="{name}#'.encode()),
            re.sub(rb'count="\d+"', b'count="999999999"', content),
            re.sub(rb"<node [^>]*>", rb'\g<0><instance_node url="#node0"/>', content),
            b"<a>" * 100_000,
        )
    )


def _glb(chance: Chance, content: bytes, name: str) -> bytes:
    """A GLB whose description says something else than it should."""
    length = int.from_bytes(content[12:16], "little")
    document = json.loads(content[20 : 20 + length])
    lists = [key for key, value in document.items() if isinstance(value, list)]
    entry = chance.choice(document[chance.choice(lists)])
    key = chance.choice([*entry, "uri", "children", "sparse", "extensions"])
    entry[key] = chance.choice((10**9, -1, 2**70, [0], [[0]], {}, name, None, 1e308, "VEC3"))
    if chance.random() < 0.2:
        document["buffers"] = [{"byteLength": 10**9, "uri": name}]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + content[20 + length :]
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def _model(chance: Chance, content: bytes, name: str) -> bytes:
    """A 3MF whose parts consist of each other, or a large one packed small."""
    if chance.random() < 0.2:
        return _bomb()
    place = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    parts = "".join(
        f'<object id="{k}" type="model"><components>'
        + f'<component objectid="{chance.choice((k + 1, k + 1, 1))}"/>' * 10
        + "</components></object>"
        for k in range(1, 12)
    )
    text = f'<model unit="millimeter" xmlns="{place}"><metadata name="{name}"/><resources>{parts}'
    text += '</resources><build><item objectid="1"/></build></model>'
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("3D/3dmodel.model", text)
        archive.writestr(
            "_rels/.rels", f'<Relationships><Relationship Target="{name}"/></Relationships>'
        )
    return packed.getvalue()


def _bomb() -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", b"<a>" + b" " * 210_000_000)
    return content.getvalue()


_SOLIDS: tuple[Callable[[], Any], ...] = (
    trimesh.creation.box,
    trimesh.creation.icosphere,
    _cylinder,
    _torus,
)
_WRONG: dict[str, Callable[[Chance, bytes, str], bytes]] = {
    ".stl": _stl,
    ".obj": _obj,
    ".glb": _glb,
    ".ply": _ply,
    ".off": _off,
    ".3mf": _model,
    ".dae": _dae,
}

"""Files that nobody should have made: damaged, lying about their sizes, naming what is not theirs.

Each is made of its seed alone.
"""

from __future__ import annotations

import io
import json
import struct
import zipfile

from app.reading.reading import ReadingRequest
from benchmarks.hostile_meshes import WORDS, Chance, hostile_mesh, maybe_damaged
from tests.abi.robot.robots import arm, joint, link, urdf

_SHAPE = '<box size="0.1 0.1 0.3"/>'


def hostile(seed: int, outside: str) -> ReadingRequest:
    """The hostile file of a seed: three of ten describe an arm, four a mesh, three a scene.

    Args:
        seed: of all that is drawn.
        outside: address of a file or a server that must not be asked; every other file names it.
    """
    chance = Chance(seed)
    make = (_urdf, _arm_zip, _arm_zip, *[_mesh] * 4, _scene, _scene, _scene_zip)[seed % 10]
    return make(chance, outside)


def references(outside: str) -> list[str]:
    """Ways to name what is outside."""
    return [
        outside,
        f"file://{outside}",
        f"../{outside.rpartition('/')[2]}",
        f"package://x/../../{outside}",
        f"a/../../../../../../../../..{outside}",
        f"http://{outside}",
        f"\\\\{outside}",
        "/proc/self/environ",
        "/dev/zero",
    ]


def _robot(chance: Chance, outside: str) -> str:
    """Text of a robot with one or two things wrong."""
    name = chance.choice(references(outside))
    wrong = (
        lambda: arm((_SHAPE, f'<mesh filename="{name}"/>')),
        lambda: f'<!DOCTYPE r [<!ENTITY x SYSTEM "{name}">]>' + arm(('name="r"', 'name="&x;"')),
        lambda: f'<!DOCTYPE r SYSTEM "{name}">' + arm(),
        lambda: '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">' + "".join(
            f'<!ENTITY a{k} "{f"&a{k - 1};" * 9}">' for k in range(1, 9)
        ).replace("&a0;", "&a;") + "]>" + arm(('name="r"', 'name="&a8;"')),
        lambda: arm().replace("<robot", f'<?xml-stylesheet href="{name}"?><robot'),
        lambda: urdf(*(link(f"l{k}") for k in range(chance.choice((149, 151, 3000)))),
                     *(joint(f"j{k}", f"l{k}", f"l{k + 1}") for k in range(140))),
        lambda: urdf("<a>" * 9000 + "</a>" * chance.choice((0, 9000))),
        lambda: urdf(*map(link, "ab"), joint("p", "a", "b"), joint("q", "b", "a")),
        lambda: arm(("</link>", f"<collision><geometry>{_SHAPE}</geometry></collision>" * 500)),
        lambda: arm(("</robot>", "<link/>" * chance.choice((10, 30_000)) + "</robot>")),
        lambda: arm(('xyz="0 0 0.4"', f'xyz="{chance.choice(WORDS)} 0 0.4"')),
        lambda: arm(('lower="-2"', f'lower="{chance.choice(WORDS)}"')),
        lambda: arm(('effort="9"/>', f'effort="9"/><mimic joint="{chance.choice("pqsx")}"/>')),
        lambda: arm(
            ('name="b"', f'name="{chance.choice(("", "../b", "&#x202e;b", "b" * 9999))}"')
        ),
        lambda: arm(("<collision>", '<inertial><mass value="-1"/></inertial><collision>')),
    )  # fmt: skip
    return chance.choice(wrong)()


def _mesh(chance: Chance, outside: str) -> ReadingRequest:
    return hostile_mesh(chance, references(outside))


def _urdf(chance: Chance, outside: str) -> ReadingRequest:
    content = _robot(chance, outside).encode()
    if chance.random() < 0.15:
        content = content.decode(errors="replace").encode(chance.choice(("utf-16", "utf-32")))
    return ReadingRequest("arm", "r.urdf", maybe_damaged(chance, content))


def _arm_zip(chance: Chance, outside: str) -> ReadingRequest:
    text = _robot(chance, outside) if chance.random() < 0.5 else arm(
        (_SHAPE, '<mesh filename="package://r/part.stl"/>')
    )  # fmt: skip
    part = hostile_mesh(chance, references(outside))
    return ReadingRequest(
        "arm", "r.zip", _archive(chance, outside, {"r.urdf": text.encode()}, part.content)
    )


def _archive(chance: Chance, outside: str, files: dict[str, bytes], part: bytes) -> bytes:
    """A zip of files and a part of several names, often lying."""
    content = io.BytesIO()
    packing = chance.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2))
    with zipfile.ZipFile(content, "w", packing) as archive:
        for name, text in files.items():
            archive.writestr(name, text)
        archive.writestr("part.stl", part)
        match chance.randrange(7):
            case 0:
                archive.writestr(chance.choice(references(outside)), part)
            case 1:
                archive.writestr("bomb.stl", bytes(chance.choice((10, 110)) * 10**6))
            case 2:
                for k in range(chance.choice((300, 2000))):
                    archive.writestr(f"{k}.stl", b"")
            case 3:
                symbolic = zipfile.ZipInfo("meshes")
                symbolic.external_attr = 0xA1FF << 16
                archive.writestr(symbolic, outside)
            case 4:
                archive.writestr("a/" * 5000 + "b.stl", part)
    packed = bytearray(content.getvalue())
    if chance.random() < 0.4:  # sizes, methods and flags in the directory at the end
        directory = packed.rfind(b"PK\x01\x02")
        at = directory + chance.choice((8, 10, 16, 20, 24, 28, 42))
        packed[at : at + 4] = struct.pack("<I", chance.choice((0, 1, 7, 2**16, 2**32 - 1)))
    return maybe_damaged(chance, bytes(packed), 0.3)


def _fields(chance: Chance, outside: str) -> dict[str, object]:
    """Fields of a scene with one thing wrong."""
    name = chance.choice((*references(outside), "part.stl"))
    ball: dict[str, object] = {"shape": "sphere", "radius": 0.5, "position": [1, 2, 3]}
    wrong: tuple[dict[str, object], ...] = (
        {"obstacles": [ball] * chance.choice((4_900, 5_001, 12_000))},
        {"obstacles": [{"shape": "mesh", "file": name, "position": [3, 3, 3]}]},
        {"obstacles": [{**ball, chance.choice([*ball]): chance.choice((-1, 1e308, None, [], {}))}]},
        {"arm": {"model": "urdf", "urdf": name}},
        {"arm": {"model": "urdf", "urdf": "ur5e", "tip": chance.choice(("", "x" * 99, name[:90]))}},
        {"mesh": {"pitch": chance.choice((1e-9, 1e-300, 0, -1, 1e308, True, "a"))}},
        {"mesh": {"max_nodes": 10 ** chance.randrange(30)}},
        {"workspace": {"min": [0, 0, 0], "max": [chance.choice((0, 1e300, -1)), 1, 1]}},
        {"spline": {"degree": 10**9}},
        {"start": [0] * chance.choice((2, 4, 100_000))},
        {"unit": name, "version": 2**70},
        {name: name},
        {"obstacles": {"a": {"b": {"c": [[[[[[[[[[[[[[[]]]]]]]]]]]]]]]}}}},
    )
    return {"version": 1, **chance.choice(wrong)}


def _scene(chance: Chance, outside: str) -> ReadingRequest:
    text = json.dumps(_fields(chance, outside))
    if chance.random() < 0.5:
        return ReadingRequest("scene", "a.json", maybe_damaged(chance, text.encode()))
    traps = (
        "a: &a [x, x]\nb: &b [*a, *a]\nc: &c [*b, *b]\n",
        "a: !!python/object/apply:os.system ['x']\n",
        "a: " + "[" * 2000,
        "? " * 500,
        "a: 2020-01-01T00:00:00Z\nb: .nan\nc: 0x" + "f" * 9000,
        "<<: {a: 1}\nversion: 1\nversion: 1\n",
        "%YAML 9.9\n---\n- |\n",
        "",
    )
    yaml = text[:300_000] if chance.random() < 0.5 else chance.choice(traps)
    return ReadingRequest("scene", "a.yaml", maybe_damaged(chance, yaml.encode()))


def _scene_zip(chance: Chance, outside: str) -> ReadingRequest:
    files = {
        chance.choice(("scene.yaml", "scene.json")): json.dumps(_fields(chance, outside)).encode(),
        "r.urdf": _robot(chance, outside).encode(),
    }
    part = hostile_mesh(chance, references(outside))
    return ReadingRequest("scene", "a.zip", _archive(chance, outside, files, part.content))

"""Random 3MF files with the surface that their build section places."""

from __future__ import annotations

import io
import zipfile

import numpy as np

from abi.arrays import FloatArray
from benchmarks.written_shapes import Chance, Written, placed, pose, solid, together

_METRES = {
    **{"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "meter": 1.0},
    **{"inch": 0.0254, "foot": 0.3048},
}
_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
_BEAMS = "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02"
_TYPE = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"


def threemf(chance: Chance) -> Written:
    """Units, components in components, objects in other parts, and objects that nothing places."""
    unit = chance.choice((*_METRES, ""))
    metres = _METRES[unit or "millimeter"]
    surfaces: dict[int, FloatArray] = {}
    objects: list[str] = []
    others: list[str] = []
    paths: dict[int, str] = {}
    bad: set[int] = set()
    for number in range(1, chance.randint(2, 4)):
        one = solid(chance)
        beams = ""
        if chance.random() < 0.04:
            beams = f'<b:beamlattice xmlns:b="{_BEAMS}"/>'
            bad.add(number)
        text = _object(number, one.surface, beams)
        surfaces[number] = one.surface
        if chance.random() < 0.2 and not beams:
            others.append(text)
            paths[number] = ' p:path="/3D/other.model"'
        else:
            objects.append(text)
    meshes = len(surfaces)
    used: set[int] = set()
    for number in range(meshes + 1, meshes + chance.randint(1, 3)):
        inside = [chance.choice(list(surfaces)) for _ in range(chance.randint(1, 2))]
        poses = [_posed(chance) for _ in inside]
        components = "".join(
            f'<component objectid="{k}"{paths.get(k, "")}{text}/>'
            for k, (text, _) in zip(inside, poses, strict=True)
        )
        objects.append(f'<object id="{number}"><components>{components}</components></object>')
        parts = [placed(surfaces[k], at) for k, (_, at) in zip(inside, poses, strict=True)]
        surfaces[number] = together(parts)
        used |= set(inside)
        bad |= {number} if bad & set(inside) else set()
    items, found = "", []
    top = [k for k in surfaces if k not in used] or [max(surfaces)]
    left = len(top) > 1 and chance.random() < 0.3
    for k in top[left:]:
        for _ in range(chance.randint(1, 2)):
            text, at = _posed(chance)
            items += (
                f'<item objectid="{k}"{paths.get(k, "")}{text} printable="{chance.randint(0, 1)}"/>'
            )
            found.append(placed(surfaces[k], at))
    units = f' unit="{unit}"' if unit else ""
    spaces = f'xmlns="{_CORE}" xmlns:p="{_PRODUCTION}"'
    head = f'<?xml version="1.0" encoding="utf-8"?><model{units} {spaces}>'
    files = {"3D/3dmodel.model": f"{head}<resources>{''.join(objects)}</resources><build>{items}"}
    files["3D/3dmodel.model"] += "</build></model>"
    if others:
        files["3D/other.model"] = f"{head}<resources>{''.join(others)}</resources><build/></model>"
    name = "3D/3dmodel.model"
    if chance.random() < 0.3:
        name = "Parts/Main.model"
        files[name] = files.pop("3D/3dmodel.model")
    if name != "3D/3dmodel.model" or chance.random() < 0.5:
        relation = f'<Relationship Target="/{name}" Id="a" Type="{_TYPE}"/>'
        files["_rels/.rels"] = f"<Relationships>{relation}</Relationships>"
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, text in files.items():
            archive.writestr(path, text)
    surface = together(found) * metres
    return Written(".3mf", content.getvalue(), surface, metres, left, bool(bad & set(top[left:])))


def _object(number: int, surface: FloatArray, beams: str) -> str:
    corners, ids = np.unique(surface.reshape(-1, 3), axis=0, return_inverse=True)
    vertices = "".join(f'<vertex x="{x!r}" y="{y!r}" z="{z!r}"/>' for x, y, z in corners.tolist())
    triangles = "".join(
        f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in ids.reshape(-1, 3).tolist()
    )
    mesh = f"<vertices>{vertices}</vertices><triangles>{triangles}</triangles>{beams}"
    return f'<object id="{number}" type="model"><mesh>{mesh}</mesh></object>'


def _posed(chance: Chance) -> tuple[str, FloatArray]:
    """A transform as an attribute, and its pose (4, 4); sometimes none."""
    if chance.random() < 0.3:
        return "", np.eye(4)
    at = pose(chance)
    numbers = " ".join(map(repr, at[:3].T.ravel().tolist()))
    return f' transform="{numbers}"', at

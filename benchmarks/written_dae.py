"""Random DAE files with the surface that their scene places."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy

from abi.arrays import FloatArray
from benchmarks.written_shapes import Chance, Solid, Written, placed, pose, solid, together

_SPACES = (
    "http://www.collada.org/2005/11/COLLADASchema",
    "http://www.collada.org/2008/03/COLLADASchema",
)


class _Dae:
    """Texts of the libraries, and the surfaces of geometries and nodes."""

    def __init__(self, chance: Chance) -> None:
        self.chance = chance
        self.surfaces: list[FloatArray] = []
        self.geometries = ""
        self.shared: list[FloatArray] = []
        self.left_out = self.refused = False
        self.used: set[int] = set()
        self.crossed: set[int] = set()
        self.reached: set[int] = set()
        self.bad: list[bool] = []

    def geometry(self, one: Solid) -> None:
        """Add a geometry in one of the kinds of primitives."""
        number, chance = len(self.surfaces), self.chance
        numbers = " ".join(map(repr, one.vertices.ravel().tolist()))
        axes = "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ")
        source = (
            f'<source id="s{number}"><float_array id="a{number}" count="{one.vertices.size}">'
            f'{numbers}</float_array><technique_common><accessor source="#a{number}" '
            f'count="{len(one.vertices)}" stride="3">{axes}</accessor></technique_common></source>'
        )
        positions = f'<input semantic="POSITION" source="#s{number}"/>'
        vertices = f'<vertices id="v{number}">{positions}</vertices>'
        polygons = list(one.polygons)
        kind = chance.choice(("polylist", "polygons", "runs"))
        if kind != "runs" and chance.random() < 0.04:
            a, b, c, d = polygons[-1]
            polygons[-1] = (a, c, b, d)
            self.crossed.add(number)
        body = _primitives(chance, polygons, number, kind)
        if chance.random() < 0.1:
            lines = f'<input semantic="VERTEX" source="#v{number}" offset="0"/><p>0 1</p>'
            body += f'<lines count="1">{lines}</lines>'
            self.left_out = True
        mesh = f"<mesh>{source}{vertices}{body}</mesh>"
        self.geometries += f'<geometry id="g{number}">{mesh}</geometry>'
        self.surfaces.append(one.surface)

    def node(self, depth: int) -> tuple[str, FloatArray]:
        """A node with what is below it, and the surface in its parent."""
        chance = self.chance
        transforms, at = _transforms(chance)
        inner, surfaces = "", []
        if depth == 0 or chance.random() < 0.6:
            k = chance.randrange(len(self.surfaces))
            self.used.add(k)
            kind = "instance_geometry"
            if chance.random() < 0.03:
                kind, self.refused = "instance_controller", True
            self.refused |= k in self.crossed
            inner += f'<{kind} url="#g{k}"/>'
            surfaces.append(self.surfaces[k])
        if self.shared and chance.random() < 0.4:
            k = chance.randrange(len(self.shared))
            self.reached.add(k)
            self.refused |= self.bad[k]
            inner += f'<instance_node url="#shared{k}"/>'
            surfaces.append(self.shared[k])
        for _ in range(chance.randint(1, 2) if depth else 0):
            text, surface = self.node(depth - 1)
            inner += text
            surfaces.append(surface)
        if chance.random() < 0.1:
            extra = '<technique profile="FCOLLADA"><visibility>0</visibility></technique>'
            inner += f"<extra>{extra}</extra>"
        return f"<node>{transforms}{inner}</node>", placed(together(surfaces), at)


def dae(chance: Chance) -> Written:
    """Units, axes, nodes in nodes and used again, all kinds of polygons, and other scenes."""
    file = _Dae(chance)
    for _ in range(chance.randint(1, 3)):
        file.geometry(solid(chance))
    library = ""
    for k in range(chance.randint(0, 2)):
        file.refused = False
        text, surface = file.node(chance.randint(0, 1))
        file.bad.append(file.refused)
        library += text.replace("<node>", f'<node id="shared{k}">', 1)
        file.shared.append(surface)
    file.refused = False
    roots = [file.node(chance.randint(0, 2)) for _ in range(chance.randint(1, 2))]
    refused = file.refused
    scenes = f'<visual_scene id="main">{"".join(text for text, _ in roots)}</visual_scene>'
    if chance.random() < 0.2:
        scenes += f'<visual_scene id="other">{file.node(0)[0]}</visual_scene>'
        file.left_out = True
    file.left_out |= len(file.used) < len(file.surfaces)
    file.left_out |= len(file.reached) < len(file.shared)
    metres = chance.choice((1.0, 0.01, 0.001, 0.0254, None))
    asset = f'<unit name="u" meter="{metres}"/>' if metres else ""
    asset += chance.choice(("", *(f"<up_axis>{axis}_UP</up_axis>" for axis in "XYZ")))
    content = (
        f'<?xml version="1.0" encoding="utf-8"?><COLLADA xmlns="{chance.choice(_SPACES)}" '
        f'version="1.4.1"><asset>{asset}</asset><library_geometries>{file.geometries}'
        f"</library_geometries><library_nodes>{library}</library_nodes><library_visual_scenes>"
        f'{scenes}</library_visual_scenes><scene><instance_visual_scene url="#main"/></scene>'
        "</COLLADA>"
    )
    surface = together([surface for _, surface in roots]) * (metres or 1.0)
    found = Written(".dae", content.encode(), surface, metres or 1.0, file.left_out, refused)
    return found


def _primitives(chance: Chance, polygons: list[tuple[int, ...]], number: int, kind: str) -> str:
    """Elements for the polygons of a solid, whose sides may be strips and fans."""
    others = chance.randint(0, 2)
    inputs = "".join(
        f'<input semantic="TEXCOORD" source="#t" offset="{k}"/>' for k in range(others)
    )
    inputs += f'<input semantic="VERTEX" source="#v{number}" offset="{others}"/>'
    if kind == "polygons":
        body = "".join(_corners(polygon, others) for polygon in polygons)
        return f'<polygons count="{len(polygons)}">{inputs}{body}</polygons>'
    listed = polygons if kind == "polylist" else polygons[:2]
    sizes = " ".join(str(len(polygon)) for polygon in listed)
    corners = [corner for polygon in listed for corner in polygon]
    body = f"{inputs}<vcount>{sizes}</vcount>{_corners(corners, others)}"
    text = f'<polylist count="{len(listed)}">{body}</polylist>'
    for a, b, c, d in polygons[2:] if kind == "runs" else ():
        name, run = chance.choice((("trifans", (a, b, c, d)), ("tristrips", (b, c, a, d))))
        text += f'<{name} count="1">{inputs}{_corners(run, others)}</{name}>'
    return text


def _corners(ids: Sequence[int], others: int) -> str:
    """Numbers of corners, each behind as many others."""
    return f"<p>{' '.join(' '.join(['0'] * others + [str(k)]) for k in ids)}</p>"


def _transforms(chance: Chance) -> tuple[str, FloatArray]:
    """Elements of a node, and the pose (4, 4) that is their product."""
    text, at = "", np.eye(4)
    for kind in [chance.choice(("matrix", "translate", "rotate", "scale")) for _ in range(2)]:
        step = np.eye(4)
        if kind == "matrix":
            step = pose(chance)
            numbers = step.ravel().tolist()
        elif kind == "translate":
            numbers = [chance.uniform(-3, 3) for _ in range(3)]
            step[:3, 3] = numbers
        elif kind == "scale":
            numbers = [chance.uniform(0.5, 2) * chance.choice((1, 1, -1)) for _ in range(3)]
            step[:3, :3] = np.diag(numbers)
        else:
            turn = np.array([chance.uniform(-1, 1) for _ in range(3)])
            angle = chance.uniform(-180, 180)
            numbers = [*turn.tolist(), angle]
            vector = turn / np.linalg.norm(turn) * math.radians(angle)
            step[:3, :3] = scipy.spatial.transform.Rotation.from_rotvec(vector).as_matrix()
        text += f"<{kind}>{' '.join(map(repr, numbers))}</{kind}>"
        at = at @ step
    return text, at

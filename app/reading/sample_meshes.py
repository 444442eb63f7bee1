"""A tetrahedron as DAE and 3MF files, which trimesh cannot write without more packages."""

from __future__ import annotations

import io
import zipfile

_DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_geometries><geometry id="body"><mesh>
<source id="positions"><float_array id="numbers" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#numbers" count="4" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source>
<vertices id="corners"><input semantic="POSITION" source="#positions"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#corners" offset="0"/>
<p>0 2 1 0 1 3 1 2 3 0 3 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="all"><node><instance_geometry url="#body"/></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#all"/></scene>
</COLLADA>
"""
_MODEL = """<model xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" unit="meter">
<resources><object id="1" type="model"><mesh>
<vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/>
<vertex x="0" y="0" z="1"/></vertices>
<triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/>
<triangle v1="1" v2="2" v3="3"/><triangle v1="0" v2="3" v3="2"/></triangles>
</mesh></object></resources>
<build><item objectid="1"/></build>
</model>
"""


def dae() -> bytes:
    """The DAE file."""
    return _DAE.encode()


def threemf() -> bytes:
    """The 3MF file."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("3D/3dmodel.model", _MODEL)
    return file.getvalue()

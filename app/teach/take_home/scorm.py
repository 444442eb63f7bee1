"""A lesson as a SCORM 1.2 package, which learning platforms import and record scores of.

The manifest follows IMS Content Packaging 1.1.2 with ADL's extensions of SCORM 1.2.
"""

from __future__ import annotations

import io
import re
import zipfile

from lxml import etree

_IMS = "http://www.imsproject.org/xsd/imscp_rootv1p1p2"
_ADL = "http://www.adlnet.org/xsd/adlcp_rootv1p2"
_XSI = "http://www.w3.org/2001/XMLSchema-instance"
PAGE = "index.html"
MANIFEST = "imsmanifest.xml"
_EPOCH = (1980, 1, 1, 0, 0, 0)
"""Fixed date of the files, so that the same lesson gives the same package."""


def scorm_package(name: str, title: str, page: bytes) -> bytes:
    """The package as a zip.

    Args:
        name: of the lesson's file.
        title: of the lesson.
        page: its HTML, which finds the platform by itself.
    """
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as package:
        for file, content in ((MANIFEST, manifest(name, title)), (PAGE, page)):
            package.writestr(zipfile.ZipInfo(file, _EPOCH), content, zipfile.ZIP_DEFLATED)
    return target.getvalue()


def manifest(name: str, title: str) -> bytes:
    """The package's manifest, with one item that starts the page.

    Characters of the title that XML does not have become spaces.
    """
    title = "".join(one if one.isprintable() else " " for one in title)
    identifier = "abi-" + re.sub(r"[^A-Za-z0-9]", "-", name)
    root = etree.Element(
        _tag("manifest"), nsmap={None: _IMS, "adlcp": _ADL, "xsi": _XSI}, identifier=identifier
    )
    root.set("version", "1.0")
    schemas = f"{_IMS} imscp_rootv1p1p2.xsd {_ADL} adlcp_rootv1p2.xsd"
    root.set(f"{{{_XSI}}}schemaLocation", schemas)
    metadata = etree.SubElement(root, _tag("metadata"))
    etree.SubElement(metadata, _tag("schema")).text = "ADL SCORM"
    etree.SubElement(metadata, _tag("schemaversion")).text = "1.2"
    organizations = etree.SubElement(root, _tag("organizations"), default="lesson")
    organization = etree.SubElement(organizations, _tag("organization"), identifier="lesson")
    etree.SubElement(organization, _tag("title")).text = title
    item = etree.SubElement(
        organization, _tag("item"), identifier="item", identifierref="page", isvisible="true"
    )
    etree.SubElement(item, _tag("title")).text = title
    resources = etree.SubElement(root, _tag("resources"))
    resource = etree.SubElement(
        resources, _tag("resource"), identifier="page", type="webcontent", href=PAGE
    )
    resource.set(f"{{{_ADL}}}scormtype", "sco")
    etree.SubElement(resource, _tag("file"), href=PAGE)
    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))


def _tag(name: str) -> str:
    return f"{{{_IMS}}}{name}"

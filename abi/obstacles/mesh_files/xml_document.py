"""Strict parser of the XML in mesh files: no document type, entities or external references."""

from __future__ import annotations

import re
from collections.abc import Iterable
from urllib.parse import unquote

import numpy as np
from lxml import etree

from abi.arrays import FloatArray
from abi.obstacles.mesh_files.words import float_words, shown

_ENTITIES = re.compile(rb"<!(?:DOCTYPE|ENTITY)", re.IGNORECASE)
_ENCODING = re.compile(rb"""<\?xml[^>]{0,100}encoding\s*=\s*["']([^"']*)""")
_ENCODINGS = re.compile(rb"utf-8|(us-)?ascii|iso-8859-[0-9]{1,2}|windows-125[0-8]", re.IGNORECASE)
MOST_ITEMS = 12_000_000
"""Most elements and attributes of a text, an element with the text behind it counted as two."""
_MARKS_OF_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
_DECLARATION = re.compile(r"<\?xml[^>]*>")


def parse(data: bytes, root: str) -> etree._Element:
    """The root element of an XML text.

    Args:
        data: the text in UTF-8, in UTF-16 with its mark, or in an encoding of one byte a letter.
        root: name that the root element must have.

    Raises:
        ValueError: it is cut off, no XML, or may harm; says what is expected instead.
    """
    data = _as_bytes(data)
    check_plain(data)
    check_items([data])
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=True,  # lists of numbers may be long
        remove_comments=True,
        remove_pis=True,
    )
    try:
        found = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise ValueError(f"a whole XML text, it breaks in line {error.lineno or 1}") from None
    except ValueError:
        raise ValueError("a whole XML text") from None
    if name_of(found) != root:
        raise ValueError(f"an XML text of <{root}>, this begins with <{name_of(found)[:40]}>")
    return found


def check_items(texts: Iterable[bytes]) -> None:
    """Refuse texts of so many elements and attributes that they would fill the memory.

    Raises:
        ValueError: more than ``MOST_ITEMS``.
    """
    if sum(2 * text.count(b"<") + text.count(b"=") for text in texts) > MOST_ITEMS:
        raise ValueError(f"an XML text of at most {MOST_ITEMS:,} elements and attributes")


def _as_bytes(data: bytes) -> bytes:
    """A text in UTF-16 as one in UTF-8; another as it is."""
    if data[:2] not in _MARKS_OF_UTF_16:
        return data
    try:
        text = data.decode("utf-16")
    except UnicodeDecodeError:
        raise ValueError("a whole XML text, this is none in UTF-16") from None
    return _DECLARATION.sub("", text, count=1).encode(errors="replace")


def check_plain(data: bytes) -> None:
    """Refuse entities, and encodings that would hide them.

    Raises:
        ValueError: says what is expected instead.
    """
    encoding = _ENCODING.search(data[:200])
    if encoding and not _ENCODINGS.fullmatch(encoding[1]):
        raise ValueError("an XML file in UTF-8")
    if (zero := data.find(b"\0")) >= 0:
        line = data.count(b"\n", 0, zero) + 1
        raise ValueError(f"an XML file in UTF-8, there is a byte 0 in line {line}")
    if _ENTITIES.search(data):
        raise ValueError("an XML file without a document type")
    if b"http://www.w3.org/2001/XInclude" in data:
        raise ValueError("an XML file that includes no other")


def name_of(element: etree._Element) -> str:
    """Name of an element without its namespace."""
    return str(etree.QName(element).localname)


def children(element: etree._Element, *names: str) -> list[etree._Element]:
    """Children with one of the names, in any namespace."""
    return list(element.iterchildren(*(f"{{*}}{name}" for name in names)))


def child(element: etree._Element, *names: str) -> etree._Element | None:
    """The first child with one of the names."""
    return next(element.iterchildren(*(f"{{*}}{name}" for name in names)), None)


def refers(url: str, name: object) -> bool:
    """Check whether a URL, in which letters may be percent-encoded, is of the element so called."""
    return f"#{name}" in (url, unquote(url))


def where(element: etree._Element) -> str:
    """Name and line of an element as a phrase."""
    return f"<{name_of(element)}> in line {element.sourceline}"


def floats(element: etree._Element) -> FloatArray:
    """Numbers of an element's text, (n,).

    Raises:
        ValueError: one is none.
    """
    words = "".join(element.itertext()).encode().split()
    return float_words(words, f"numbers in {where(element)}")


def integer(element: etree._Element, attribute: str, default: str = "") -> int:
    """An attribute that is a whole number, 0 or more.

    Raises:
        ValueError: it is none.
    """
    text = str(element.get(attribute, default)).strip()
    if not (re.fullmatch(r"[0-9]{1,10}", text) and int(text) < 2**31):
        raise ValueError(
            f"whole numbers below 2^31, {attribute} of {where(element)} is {shown(text)}"
        )
    return int(text)


def affine(numbers: FloatArray, name: str) -> FloatArray:
    """Check a pose (4, 4) whose entries must be within 1e9.

    Raises:
        ValueError: they are not.
    """
    if not (np.isfinite(numbers).all() and np.abs(numbers).max() <= 1e9):
        raise ValueError(f"poses within 1e9, that of {name} is not")
    return numbers

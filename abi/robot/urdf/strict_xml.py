"""Strict parser of robot descriptions in XML, whose errors are one sentence each."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np
import scipy
from lxml import etree

from abi.arrays import FloatArray, read_only
from abi.errors import MISSING, SceneError
from abi.obstacles.pose import Vec3

MAX_BYTES, MAX_ELEMENTS = 2_000_000, 20_000

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,4})?", re.ASCII)
_MOST_DIGITS, _LONGEST_NAME = 400, 100
_NOT_IN_NAMES = '<>"\\`'
_ENDLESS = ("inf", "infinity")
_COMMA = re.compile(r",(\s|$)")  # between numbers; one inside a number is not let pass
_DEFAULTED = re.compile(r"\$\(optenv\s+\w+\s+([^$()]*)\)")
"""Pattern of xacro's environment variables with a default."""
_MARKUP = re.compile(r"<!(DOCTYPE|ENTITY|ELEMENT|ATTLIST|NOTATION)")
_ZERO: Vec3 = (0.0, 0.0, 0.0)
_LEAST_QUATERNION = 1e-6
_LENGTHS = ("xyz", "size", "radius", "length")
_DECLARATION = re.compile(r"\A\s*<\?xml[^>]{0,200}\?>")


class XmlElement:
    """An XML element, and its name in error messages.

    Attributes:
        xml: the element.
        file: name of the file.
        title: name of the element in error messages.
        told: beginnings of sentences on what of the file is not as it should be, with the elements
            that they are told of; shared with the elements inside.
    """

    def __init__(
        self,
        element: etree._Element,
        file: str,
        title: str,
        told: dict[str, list[str]] | None = None,
    ) -> None:
        self.xml, self.file, self.title = element, file, title
        self.told: dict[str, list[str]] = {} if told is None else told

    def refuse(self, what: str, value: object, expected: str) -> SceneError:
        """Error that names this element, a part of it, its value and what would work."""
        return SceneError(f"arm.urdf {self.file}: {self.title}, {what}", value, expected)

    def tell(self, note: str) -> None:
        """Note this element for a summarising sentence."""
        named = self.told.setdefault(note, [])
        if self.title not in named:
            named.append(self.title)

    def called(self) -> XmlElement:
        """A copy that error messages call by its ``name`` attribute."""
        name = self.xml.get("name", "")
        tag = str(self.xml.tag)
        if not _is_name(name):
            expected = (
                f"1 to {_LONGEST_NAME} letters of any script, digits and signs, "
                f"but none of {' '.join(_NOT_IN_NAMES)} and no .. between slashes"
            )
            raise XmlElement(self.xml, self.file, tag).refuse("name", name, expected)
        return XmlElement(self.xml, self.file, f"{tag} {name}", self.told)

    def all(self, tag: str) -> Iterator[XmlElement]:
        """Children with a tag, called by it in error messages."""
        for element in self.xml.iterfind(tag):
            yield XmlElement(element, self.file, self.title, self.told)

    def child(self, tag: str) -> XmlElement | None:
        """First child with a tag; None if there is none. Further ones are noted."""
        found = list(self.all(tag))
        if len(found) > 1:
            self.tell(f"Of more than one <{tag}> the first counts:")
        return found[0] if found else None

    def needed(self, tag: str) -> XmlElement:
        """First child with a tag; SceneError if there is none."""
        found = self.child(tag)
        if found is None:
            raise self.refuse(tag, MISSING, f"one <{tag}>")
        return found

    def text(self, attribute: str, default: str = "") -> str:
        """An attribute without spaces around it."""
        text = self._given(attribute)
        return default if text is None else text.strip()

    def number(self, attribute: str, default: float | None, low: float, high: float) -> float:
        """An attribute as a number from ``low`` to ``high``; SceneError if it is not one."""
        text = self._given(attribute)
        if text is None and default is not None:
            return default
        return self._number(attribute, text or "", low, high)

    def vector(self, attribute: str, default: Vec3, low: float = -100, high: float = 100) -> Vec3:
        """An attribute as three numbers from ``low`` to ``high``; SceneError if it is not."""
        text = self._given(attribute)
        if text is None:
            return default
        words = _COMMA.sub(" ", text).split()
        if len(words) < 3:
            raise self.refuse(attribute, text, "three numbers")
        if len(words) > 3:
            self.tell(f"Of more numbers than three the first three count, as {attribute} of")
        x, y, z = (self._number(attribute, word, low, high) for word in words[:3])
        return (x, y, z)

    def bound(self, attribute: str, most: float) -> float | None:
        """An attribute as a number, with its sign and inf where it is above ``most``.

        None if it is missing; SceneError if it is no number or NaN.
        """
        text = self._given(attribute)
        if text is None or not text.strip():
            return None
        word = text.strip().lower()
        value = math.inf if word.lstrip("+-") in _ENDLESS else None
        if value is None:
            value = abs(self._number(attribute, text, -math.inf, math.inf))
        return math.copysign(value if value <= most else math.inf, -1 if word[0] == "-" else 1)

    def origin(self) -> FloatArray:
        """Pose (4, 4), [m], parent from element, of its ``<origin>``; without it the identity."""
        pose = np.eye(4)
        origin = self.child("origin")
        if origin is not None:
            pose[:3, 3] = origin.vector("xyz", _ZERO)
            pose[:3, :3] = origin._turn().as_matrix()
        return read_only(pose)

    def _turn(self) -> scipy.spatial.transform.Rotation:
        """Rotation of an origin: by its quaternion, or by angles about the fixed x, y and z."""
        text = self._given("quat_xyzw")
        if text is None:
            return scipy.spatial.transform.Rotation.from_euler("xyz", self.vector("rpy", _ZERO))
        if self._given("rpy") is not None:
            raise self.refuse("quat_xyzw", text, "either rpy or quat_xyzw")
        self.tell("quat_xyzw turns, which readers of URDF before version 1.1 ignore:")
        words = _COMMA.sub(" ", text).split()
        numbers = [self._number("quat_xyzw", word, -1e3, 1e3) for word in words]
        if len(numbers) != 4 or math.hypot(*numbers) < _LEAST_QUATERNION:
            raise self.refuse("quat_xyzw", text, "four numbers that are not all 0")
        return scipy.spatial.transform.Rotation.from_quat(numbers)

    def _given(self, attribute: str) -> str | None:
        """An attribute of the file, with the defaults of variables that xacro left."""
        text = self.xml.get(attribute)
        if text is None:
            return None
        found, count = _DEFAULTED.subn(r"\1", str(text))
        if count:
            self.tell("The default of $(optenv …) counts, as no environment is asked:")
        return found

    def _number(self, attribute: str, text: str, low: float, high: float) -> float:
        word = text.strip()
        if len(word) > _MOST_DIGITS:
            raise self.refuse(attribute, text[:20], f"a number of at most {_MOST_DIGITS} letters")
        if not _NUMBER.fullmatch(word) or not low <= float(word) <= high:
            in_metres = attribute in _LENGTHS and self.xml.tag != "axis"
            unit = " m" if in_metres else ""
            within = "" if math.isinf(low) else f" from {low:g} to {high:g}{unit}"
            raise self.refuse(attribute, text, f"a number{within}")
        return float(word)


def _is_macro(text: str) -> bool:
    """Check whether an attribute needs xacro's evaluation, and not just its default."""
    return "${" in text or "$(" in _DEFAULTED.sub("", text)


def _is_name(name: str) -> bool:
    """Check whether a name is valid for links and joints: it is displayed, and written to files."""
    return (
        0 < len(name) <= _LONGEST_NAME
        and name.isprintable()
        and name == name.strip()
        and not any(sign in name for sign in _NOT_IN_NAMES)
        and ".." not in name.split("/")
    )


def decoded(content: bytes) -> str:
    """Decode an XML file in UTF-8 or UTF-16.

    Raises:
        UnicodeDecodeError: it is neither.
    """
    wide = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    return content.decode("utf-16" if wide else "utf-8-sig")


def parse(content: bytes, name: str) -> etree._Element:
    """Parse XML that has no document type, entities or xacro macros, and return its root.

    Args:
        content: of the file.
        name: of the file, for the sentences.

    Raises:
        SceneError: it is too large, truncated or no XML, or its root is no robot.
    """
    field = f"arm.urdf {name}"
    if len(content) > MAX_BYTES:
        raise SceneError(field, f"{len(content):,} bytes", f"at most {MAX_BYTES // 10**6} MB")
    try:
        text = decoded(content)
    except UnicodeDecodeError:
        raise SceneError(field, content[:20], "URDF text in UTF-8") from None
    if markup := _MARKUP.search(text):
        raise SceneError(field, markup[0], "no document type and no entities")
    text = text.rstrip("\0")  # of programs that write the end of their text, too
    try:
        # the encoding that the text declares must not matter any more
        root = _root_of(_DECLARATION.sub("", text).encode())
    except etree.XMLSyntaxError as error:
        line = error.lineno or 1
        shown = "".join(text.splitlines()[line - 1 : line]).strip()[:60]
        expected = f"a whole XML text; it breaks in line {line}"
        if not text.lstrip().startswith("<"):
            expected = "URDF, an XML text with <robot> around it"
        raise SceneError(field, shown, expected) from None
    except ValueError as error:
        raise SceneError(field, str(error)[:90], "a whole XML text") from None
    default = f"{{{root.nsmap.get(None)}}}"
    for count, element in enumerate(root.iter("*")):
        if str(element.tag).startswith(default):
            element.tag = str(element.tag).removeprefix(default)
        values = [str(value) for value in element.attrib.values()]
        if count >= MAX_ELEMENTS:
            raise SceneError(field, f"{count} elements", f"at most {MAX_ELEMENTS:,}")
        if "xacro" in str(element.tag) or any(map(_is_macro, values)):
            raise SceneError(field, "xacro", "URDF; write it with: xacro FILE.xacro > FILE.urdf")
    if root.tag != "robot":
        raise SceneError(field, f"<{root.tag}>"[:60], "<robot>, as a URDF begins")
    return root


def package_name(content: bytes) -> str | None:
    """Name that a ``package.xml`` gives its package; None if it gives none, or is no plain XML."""
    if len(content) > MAX_BYTES:
        return None
    try:
        text = decoded(content)
        if _MARKUP.search(text):
            return None
        root = _root_of(_DECLARATION.sub("", text.rstrip("\0")).encode())
    except (UnicodeDecodeError, etree.XMLSyntaxError, ValueError):
        return None
    name = next((one.text for one in root.iter("{*}name") if one.getparent() is root), None)
    return name.strip() if name else None


def _root_of(content: bytes) -> etree._Element:
    """Root element of a text; an undeclared prefix, such as ``drake:``, is accepted.

    Raises:
        etree.XMLSyntaxError: it is no XML but for that.
    """
    try:
        return etree.fromstring(content, _parser(recover=False))
    except etree.XMLSyntaxError as error:
        if error.code != etree.ErrorTypes.NS_ERR_UNDEFINED_NAMESPACE:
            raise
        parser = _parser(recover=True)
        root = etree.fromstring(content, parser)
        if {one.type for one in parser.error_log} != {error.code}:
            raise
        return root


def _parser(recover: bool) -> etree.XMLParser:
    return etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        recover=recover,
        remove_comments=True,
        remove_pis=True,
        encoding="utf-8",
    )

"""Reads XML as the world writes it: what PyBullet, ROS and Gazebo accept is accepted.

Encodings that are declared wrongly, blank lines before the declaration, bytes after the end,
prefixes that nobody declares, default namespaces and comments with ``--`` occur in public URDFs,
and are repaired. What cannot be repaired is reported with the parser's reason. Entities are
refused, and size and depth are limited, since files may come from anywhere.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path
from xml.parsers import expat

from ..files import FileError, check_file

MAX_BYTES = 20_000_000
"""Size of a file; chosen: twenty times that of the largest URDF that was found."""
MAX_ELEMENTS = 200_000
"""Chosen: a hundred times that of a humanoid with two hands."""
HEAD = 300
"""Characters in which the XML declaration is looked for; chosen: three times the longest."""
MAX_DEPTH = 100
"""Levels of elements; chosen: a URDF has six, and extensions of simulators ten more."""

_TEXT_DECLARATION = re.compile(r"^\s*<\?xml[^>]*encoding\s*=\s*['\"]([\w.-]+)['\"]", re.IGNORECASE)
_BARE_AMPERSAND = re.compile(r"&(?!(?:amp|lt|gt|quot|apos|#\d+|#x[0-9a-fA-F]+);)")
_DECLARED_ENCODING = re.compile(r"\A(<\?xml[^>]*?)\s+encoding\s*=\s*['\"][^'\">]*['\"]")
_FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")
_BINARY_BOM = ((b"\xef\xbb\xbf", "utf-8"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))


class _Builder(ET.TreeBuilder):
    """Builds elements without namespaces, within the limits."""

    def __init__(self) -> None:
        super().__init__()
        self._elements = self._depth = 0

    def start(self, tag, attrs, /):
        self._elements += 1
        self._depth += 1
        if self._elements > MAX_ELEMENTS:
            raise FileError(f"has more than {MAX_ELEMENTS:,} elements; give a smaller file")
        if self._depth > MAX_DEPTH:
            raise FileError(f"is nested more than {MAX_DEPTH} levels deep; nest less")
        local = {key.rpartition("}")[2]: value for key, value in attrs.items()}
        return super().start(_local_name(tag), local)

    def end(self, tag, /):
        self._depth -= 1
        return super().end(_local_name(tag))


def _local_name(tag: str) -> str:
    """The name of an element without its namespace; those of xacro keep the prefix."""
    namespace, _, name = tag.rpartition("}")
    return f"xacro:{name}" if "xacro" in namespace else name


def read_xml(path: Path) -> ET.Element:
    """Read a file; names of elements and attributes are without namespaces.

    Raises
    ------
    FileError
        With the parser's reason, and the line, where the file is not XML.
    """
    check_file(path, MAX_BYTES)
    return parse_xml(path.read_bytes())


def parse_xml(content: bytes) -> ET.Element:
    """As :func:`read_xml`, for the content of a file."""
    text = decode(content)
    first = _parse(text)
    if isinstance(first, ET.Element):
        return first
    repaired = _parse(repair(text))
    if isinstance(repaired, ET.Element):
        return repaired
    line, reason = first.position[0], expat.ErrorString(first.code)
    raise FileError(f"not valid XML in line {line} ({reason}); correct it there")


def decode(content: bytes) -> str:
    """Return the text of a file: by its byte order mark, its declaration, as UTF-8, or Latin-1."""
    for mark, encoding in _BINARY_BOM:
        if content.startswith(mark):
            return _checked(content.decode(encoding, "replace").removeprefix("\ufeff"))
    if content[:4:2] == b"\0\0" or content[1:4:2] == b"\0\0":  # UTF-16 without a mark
        return _checked(content.decode("utf-16-be" if content[:1] == b"\0" else "utf-16-le"))
    declared = _TEXT_DECLARATION.match(content[:200].decode("latin-1"))
    encodings = ["utf-8"]
    if declared is not None and not declared[1].lower().startswith(("utf-16", "ucs", "utf-32")):
        encodings = [declared[1], "utf-8"]
    for encoding in encodings:
        try:
            return _checked(content.decode(encoding))
        except (LookupError, UnicodeDecodeError):
            continue
    return _checked(content.decode("latin-1"))  # every byte is a character there


def _checked(text: str) -> str:
    if "<!ENTITY" in text:
        raise FileError("declares entities, which are not read; write out what they stand for")
    # The text is decoded, so what the declaration says about its bytes no longer holds.
    return _DECLARED_ENCODING.sub(r"\1", text[:HEAD], count=1) + text[HEAD:]


def repair(text: str) -> str:
    """Return a text in which common mistakes do not stop a strict parser."""
    for opening, closing in (("<!--", "-->"), ("<?", "?>"), ("<!DOCTYPE", ">")):
        text = _cut(text, opening, closing)  # comments may hold --, a declaration may come too late
    text = _FORBIDDEN.sub("", text)
    text = text[max(text.find("<"), 0) :]
    root = re.match(r"<([A-Za-z_][\w.:-]*)", text)
    if root is None:
        return text
    end = text.rfind(f"</{root[1]}")
    if end >= 0:
        text = text[: text.find(">", end) + 1]
    text = _BARE_AMPERSAND.sub("&amp;", text)
    used = set(re.findall(r"[<\s/]([A-Za-z_][\w.-]*):[A-Za-z_][\w.-]*[\s=/>]", text))
    declared = set(re.findall(r"xmlns:([\w.-]+)\s*=", text))
    missing = sorted(used - declared - {"xmlns", "xml"})
    extra = "".join(f' xmlns:{prefix}="{prefix}"' for prefix in missing)
    return text[: root.end()] + extra + text[root.end() :]


def _cut(text: str, opening: str, closing: str) -> str:
    """Remove everything from each `opening` to the next `closing`, in linear time."""
    kept, position = [], 0
    while (start := text.find(opening, position)) >= 0:
        end = text.find(closing, start + len(opening))
        if end < 0:
            break
        kept.append(text[position:start])
        position = end + len(closing)
    return "".join([*kept, text[position:]])


def _parse(text: str) -> ET.Element | ET.ParseError:
    try:
        return ET.fromstring(text, ET.XMLParser(target=_Builder()))
    except ET.ParseError as error:
        return error
    except (ValueError, LookupError) as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"cannot be read as XML ({error}); save it as UTF-8") from None

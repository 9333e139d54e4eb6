"""URDFs that are written in xacro, the macro language of ROS.

They are expanded by the package ``xacro``, which is an extra. It evaluates the expressions that
such a file contains, so expand only files from people whom you trust.
"""

from __future__ import annotations

import io
import os
import re
import xml.etree.ElementTree as ET
from contextlib import redirect_stderr
from pathlib import Path

from ..files import FileError, locate
from .xml_reader import parse_xml

REMEDY = "pip install 'sensory-commutativity[xacro]', or run xacro FILE > robot.urdf"
_OPTENV = re.compile(r"\$\(optenv\s+(\w+)([^()]*)\)")
_EXPRESSION = re.compile(r"\$[({][^)}]*[)}]")


def is_xacro(path: Path, robot: ET.Element) -> bool:
    """Whether a file has elements, or expressions, of xacro."""
    if path.suffix == ".xacro":
        return True
    return any(element.tag.startswith("xacro:") for element in robot.iter())


def substitute_defaults(robot: ET.Element) -> None:
    """Replace ``$(optenv NAME DEFAULT)`` in attributes: by the variable, else by the default.

    Files that were expanded long ago still contain them (husky.urdf of pybullet_data).
    """
    for element in robot.iter():
        for key, value in element.attrib.items():
            if "$(optenv" in value:
                element.set(key, _OPTENV.sub(_optenv, value))


def _optenv(found: re.Match[str]) -> str:
    return os.environ.get(found[1], found[2].strip())


def find_expression(text: str) -> str | None:
    """Return the first expression of xacro in a text, ``${...}`` or ``$(...)``."""
    found = _EXPRESSION.search(text[:10_000])
    return found[0] if found else None


def expand_xacro(path: Path) -> ET.Element:
    """Expand a file with the package xacro.

    Raises
    ------
    FileError
        The package is not installed, or it reports an error.
    """
    try:
        import xacro
        from xacro import substitution_args
    except ModuleNotFoundError:
        raise FileError(f"contains xacro elements, which must be expanded; {REMEDY}") from None

    original = substitution_args._eval_find
    substitution_args._eval_find = lambda package: str(locate_package(package, path.parent))
    try:
        with redirect_stderr(io.StringIO()):  # its warnings
            text = xacro.process_file(str(path)).toxml()
    except Exception as error:  # xacro passes on whatever an expression raises
        reason = " ".join(str(error).split())[:300]
        raise FileError(f"cannot be expanded by xacro ({reason}); correct it there") from None
    finally:
        substitution_args._eval_find = original
    return parse_xml(text.encode())


def locate_package(package: str, folder: Path) -> Path:
    """Return the folder of a ROS package.

    Raises
    ------
    FileError
    """
    return locate(f"package://{package}/package.xml", folder).parent

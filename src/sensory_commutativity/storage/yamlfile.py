"""A YAML reader for untrusted files: it executes nothing and limits size and nesting.

PyYAML's safe loader silently takes the last of two equal keys, follows aliases that expand to
billions of values, and passes on whatever Python raises for an impossible value. Here each of
these is an error with a line number.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from ..errors import UserError
from .files import check_regular_file

MAX_BYTES = 1_000_000
"""Size of a file; chosen: a hundred times that of our longest file."""
MAX_VALUES = 20_000
"""Keys, values and lists, with all aliases expanded; chosen: enough for thousands of objects in a
scene, and read within two seconds."""
MAX_DEPTH = 40
"""Levels of nesting; chosen: ten times those of a configuration, far below Python's limit."""


class _RejectedError(yaml.MarkedYAMLError):
    """YAML allows it but this package does not; `problem` says what, and the remedy."""


class _Loader(yaml.SafeLoader):
    """PyYAML's safe loader with the limits above."""

    def __init__(self, text: str):
        super().__init__(text)
        self._depth = 0
        self._values = 0

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        self._depth += 1
        self._values += 1
        if self._depth > MAX_DEPTH or self._values > MAX_VALUES:
            problem = f"more than {MAX_VALUES:,} values; write fewer"
            if self._depth > MAX_DEPTH:
                problem = f"more than {MAX_DEPTH} levels deep; nest less"
            raise _RejectedError(problem=problem, problem_mark=self.peek_event().start_mark)
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def compose_mapping_node(self, anchor: str | None) -> yaml.MappingNode:
        node = super().compose_mapping_node(anchor)
        keys: dict[tuple[str, str], yaml.Node] = {}
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                first = keys.setdefault((key.tag, key.value), key)
                if first is not key:
                    line = first.start_mark.line + 1
                    problem = f"the key {key.value!r:.60} is already in line {line}; remove one"
                    raise _RejectedError(problem=problem, problem_mark=key.start_mark)
        return node

    def get_single_node(self) -> yaml.Node | None:
        node = super().get_single_node()
        if node is not None:
            _check_expansion(node, {})
        return node

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        try:
            return super().construct_object(node, deep)
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
            # a date with month 13, a number without digits, and the like
            kind = node.tag.rpartition(":")[2]
            problem = (
                f"{node.value!s:.40} is not a valid {kind}; put it in quotes if it is meant as text"
            )
            raise _RejectedError(problem=problem, problem_mark=node.start_mark) from None


def _check_expansion(node: yaml.Node, sizes: dict[int, tuple[int, int] | None]) -> tuple[int, int]:
    """Count the values and levels of a node with all aliases expanded, and check the limits.

    `sizes` holds those of nodes that were counted before, and None for those being counted.
    """
    if id(node) in sizes:
        size = sizes[id(node)]
        if size is None:
            raise _RejectedError(
                problem="a value that contains itself; write it out without the alias",
                problem_mark=node.start_mark,
            )
        return size
    sizes[id(node)] = None
    children: list[yaml.Node] = []
    if isinstance(node, yaml.MappingNode):
        children = [part for pair in node.value for part in pair]
    elif isinstance(node, yaml.CollectionNode):
        children = node.value
    values, depth = 1, 0
    for child in children:
        child_values, child_depth = _check_expansion(child, sizes)
        values, depth = values + child_values, max(depth, child_depth)
    if values > MAX_VALUES or depth >= MAX_DEPTH:
        limit = f"{MAX_VALUES:,} values" if values > MAX_VALUES else f"{MAX_DEPTH} levels"
        raise _RejectedError(
            problem=f"aliases that stand for more than {limit}; write out what is meant",
            problem_mark=node.start_mark,
        )
    sizes[id(node)] = values, depth + 1
    return values, depth + 1


def read_yaml(file: str | Path, error: type[UserError], expected: str) -> Any:
    """Read a YAML file.

    Parameters
    ----------
    file : path
    error : type
        Raised with one line: the file, what is wrong, the remedy.
    expected : str
        What the file should be, with an example, for that line.

    Returns
    -------
    The value that the file holds: dict, list, str, int, float, bool, date or None.
    """
    check_regular_file(Path(file), error, f"give the path of {expected}")
    try:
        with open(file, "rb") as opened:
            content = opened.read(MAX_BYTES + 1)
        if len(content) > MAX_BYTES:
            raise error(f"{file}: more than {MAX_BYTES:,} bytes; give the path of {expected}")
        return yaml.load(content.decode("utf-8"), Loader=_Loader)
    except FileNotFoundError:
        raise error(f"{file}: there is no such file; give the path of {expected}") from None
    except (OSError, UnicodeDecodeError) as problem:
        raise error(
            f"{file}: cannot be read ({problem}); give the path of a readable YAML file"
        ) from None
    except yaml.YAMLError as problem:
        mark = getattr(problem, "problem_mark", None)
        where = f" in line {mark.line + 1}" if mark else ""
        if isinstance(problem, _RejectedError):
            raise error(f"{file}: not usable{where}: {problem.problem}") from None
        raise error(
            f"{file}: not valid YAML{where}; check indentation, brackets and quotes there"
        ) from None

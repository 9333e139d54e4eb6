"""Reading YAML that may come from anywhere: nothing in it is executed, and what would grow without end is refused before it grows.

PyYAML's safe loader takes the last of two equal keys without a word, follows aliases that stand for billions of values, and lets through whatever
Python raises for a value that cannot be. Here each of these is an error with a line number.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from ..errors import UserError

MOST_BYTES = 1_000_000
"""Of a file; chosen: a hundred times the longest that this project has."""
MOST_VALUES = 20_000
"""Keys, values and lists, with every alias written out; chosen: some thousand objects in a scene, read within two seconds."""
DEEPEST = 40
"""Levels of nesting; chosen: ten times those of a configuration, and far below where Python gives up."""


class _RefusedError(yaml.MarkedYAMLError):
    """What YAML allows and this package does not; `problem` says what it is and the remedy."""


class _Loader(yaml.SafeLoader):
    """PyYAML's safe loader with those limits."""

    def __init__(self, text: str):
        super().__init__(text)
        self._depth, self._values = 0, 0

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        self._depth, self._values = self._depth + 1, self._values + 1
        if self._depth > DEEPEST or self._values > MOST_VALUES:
            problem = (
                f"more than {DEEPEST} levels deep; nest less"
                if self._depth > DEEPEST
                else f"more than {MOST_VALUES:,} values; write fewer"
            )
            raise _RefusedError(problem=problem, problem_mark=self.peek_event().start_mark)
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def compose_mapping_node(self, anchor: str | None) -> yaml.MappingNode:
        node = super().compose_mapping_node(anchor)
        seen: dict[tuple[str, str], yaml.Node] = {}
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                first = seen.setdefault((key.tag, key.value), key)
                if first is not key:
                    problem = f"the key {key.value!r:.60} is there already in line {first.start_mark.line + 1}; remove one of them"
                    raise _RefusedError(problem=problem, problem_mark=key.start_mark)
        return node

    def get_single_node(self) -> yaml.Node | None:
        node = super().get_single_node()
        if node is not None:
            _written_out(node, {})
        return node

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        try:
            return super().construct_object(node, deep)
        except (
            ArithmeticError,
            AttributeError,
            LookupError,
            TypeError,
            ValueError,
        ):  # a date of month 13, a number without digits, and the like
            kind = node.tag.rpartition(":")[2]
            problem = f"{node.value!s:.40} is no value of the type {kind}; put it in quotes if it is meant as text"
            raise _RefusedError(problem=problem, problem_mark=node.start_mark) from None


def _written_out(node: yaml.Node, known: dict[int, tuple[int, int] | None]) -> tuple[int, int]:
    """How many values a node stands for and how deep they lie, with every alias written out; `known` are the nodes that were looked at."""
    if id(node) in known:
        found = known[id(node)]
        if found is None:
            raise _RefusedError(
                problem="a value that holds itself; write it out without the alias",
                problem_mark=node.start_mark,
            )
        return found
    known[id(node)] = None
    values, depth = 1, 0
    inner = (
        [part for pair in node.value for part in pair]
        if isinstance(node, yaml.MappingNode)
        else node.value
    )
    for part in inner if isinstance(node, yaml.CollectionNode) else ():
        more, below = _written_out(part, known)
        values, depth = values + more, max(depth, below)
    if values > MOST_VALUES or depth >= DEEPEST:
        limit = f"{MOST_VALUES:,} values" if values > MOST_VALUES else f"{DEEPEST} levels"
        raise _RefusedError(
            problem=f"aliases that stand for more than {limit}; write out what is meant",
            problem_mark=node.start_mark,
        )
    known[id(node)] = values, depth + 1
    return values, depth + 1


def read_yaml(file: str | Path, error: type[UserError], wanted: str) -> Any:
    """What a YAML file holds.

    Parameters
    ----------
    file : path
    error : type
        Raised with one line: the file, what is wrong with it, the remedy.
    wanted : str
        What the file should be, with an example, for that line.
    """
    try:
        with open(file, "rb") as opened:
            content = opened.read(MOST_BYTES + 1)
        if len(content) > MOST_BYTES:
            raise error(f"{file}: more than {MOST_BYTES:,} bytes; give the path of {wanted}")
        return yaml.load(content.decode("utf-8"), Loader=_Loader)
    except FileNotFoundError:
        raise error(f"{file}: there is no such file; give the path of {wanted}") from None
    except (OSError, UnicodeDecodeError) as problem:
        raise error(
            f"{file}: cannot be read ({problem}); give the path of a readable YAML file"
        ) from None
    except yaml.YAMLError as problem:
        mark = getattr(problem, "problem_mark", None)
        where = f" in line {mark.line + 1}" if mark else ""
        if isinstance(problem, _RefusedError):
            raise error(f"{file}: not usable{where}: {problem.problem}") from None
        raise error(
            f"{file}: not valid YAML{where}; check indentation, brackets and quotes there"
        ) from None

"""The examples in docstrings run."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import sensory_commutativity


def test_examples_in_docstrings():
    package = Path(sensory_commutativity.__file__).parent
    examples = 0
    for source in sorted(package.rglob("*.py")):
        if ">>> " in source.read_text(encoding="utf-8"):
            name = ".".join(source.relative_to(package.parent).with_suffix("").parts)
            result = doctest.testmod(importlib.import_module(name))
            assert result.failed == 0, name
            examples += result.attempted
    assert examples > 6

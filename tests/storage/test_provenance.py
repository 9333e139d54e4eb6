"""Hashes of settings, and the code and packages that produced a file."""

from __future__ import annotations

import hashlib
import json

import pytest
from pydantic import Field

from sensory_commutativity.storage.hashing import digest, sha256
from sensory_commutativity.storage.provenance import environment, git_commit
from sensory_commutativity.storage.settings import NO_EFFECT, Section


class Inner(Section):
    scenes_per_job: int = Field(json_schema_extra=NO_EFFECT)
    pairs: int


class Outer(Section):
    name: str
    inner: Inner
    parts: list[Inner]


def test_digests_depend_on_all_values_but_those_that_affect_no_result():
    def outer(pairs: int, size: int) -> Outer:
        inner = Inner(scenes_per_job=size, pairs=pairs)
        return Outer(name="a", inner=inner, parts=[inner, inner])

    base = digest("a", 1, None, outer(3, 1), {"runs": [outer(3, 1)]})
    assert len(base) == 16 and int(base, 16) >= 0
    assert digest("a", 1, None, outer(3, 5), {"runs": [outer(3, 7)]}) == base
    for other in (
        ("b", 1, None, outer(3, 1), {"runs": [outer(3, 1)]}),
        ("a", 1.5, None, outer(3, 1), {"runs": [outer(3, 1)]}),
        ("a", 1, None, outer(4, 1), {"runs": [outer(3, 1)]}),
        ("a", 1, None, outer(3, 1), {"runs": [outer(4, 1)]}),
        ("a", 1, None, outer(3, 1), {"runs": []}),
    ):
        assert digest(*other) != base, other


def test_files_are_hashed_by_their_content(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"content")
    assert sha256(path) == hashlib.sha256(b"content").hexdigest()
    with pytest.raises(OSError, match="missing"):
        sha256(tmp_path / "missing")


def test_the_environment_names_code_platform_and_packages(monkeypatch):
    found = environment()
    assert found == environment()
    assert all(isinstance(value, str) and value for value in found.values())
    packages = json.loads(found["packages"])
    assert packages["numpy"][0].isdigit() and {"torch", "pymunk", "numba"} <= packages.keys()
    git_commit.cache_clear()
    monkeypatch.setenv("PATH", "/nowhere")  # without git
    try:
        assert git_commit() == "unknown"
    finally:
        git_commit.cache_clear()

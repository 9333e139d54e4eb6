"""No damaged file changes a result unnoticed: every bit that is flipped, and every cut, is either
refused in one line, or changes nothing that is read.

``SENCOM_FLIPS=1000 pytest tests/adversarial/test_damage.py`` flips more bits (make flips).
"""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from sensory_commutativity.errors import UserError
from tests.adversarial.kinds import Kind, all_kinds

FLIPS = int(os.environ.get("SENCOM_FLIPS", "240"))
"""Bits that are flipped in all; the default takes some seconds."""
MUST_REFUSE = {
    "shard", "experiments", "scp", "measurement", "pairs", "predictor", "checkpoint",
}  # fmt: skip
"""Kinds of which every bit counts; damaged caches are made again, and comments do not count."""


@pytest.fixture
def kinds(few_config, tmp_path, monkeypatch) -> list[Kind]:
    return all_kinds(few_config, tmp_path, monkeypatch)


def read_damaged(kind: Kind, damaged: bytes, expected: bytes) -> str:
    """What becomes of a damaged file: ``refused``, or ``harmless``: the result is as before."""
    kind.path.parent.mkdir(parents=True, exist_ok=True)
    kind.path.write_bytes(damaged)
    try:
        found = kind.read()
    except UserError as error:
        assert len(str(error).splitlines()) == 1 and str(error).isprintable(), kind.name
        named = str(kind.path) in str(error) or kind.name == "settings"  # a key may be named
        assert named, f"{kind.name}: {error}"
        return "refused"
    assert found == expected, f"{kind.name}: another result, unnoticed"
    return "harmless"


def test_flipped_bits_are_refused_or_harmless(kinds):
    rng, outcomes = np.random.default_rng(0), Counter()
    originals = [(kind, kind.path.read_bytes(), kind.read()) for kind in kinds]
    for i in range(FLIPS):
        kind, data, expected = originals[i % len(originals)]
        bit = int(rng.integers(8 * len(data)))
        flipped = bytearray(data)
        flipped[bit // 8] ^= 1 << bit % 8
        outcome = read_damaged(kind, bytes(flipped), expected)
        assert outcome == "refused" or kind.name not in MUST_REFUSE, (kind.name, bit)
        outcomes[outcome] += 1
        kind.path.write_bytes(data)
        assert kind.read() == expected, kind.name
    assert outcomes.total() >= 200 and outcomes["refused"] > outcomes.total() / 3


def test_cut_files_are_refused_or_made_again(kinds):
    for kind in kinds:
        data, expected = kind.path.read_bytes(), kind.read()
        for size in {0, 1, 7, len(data) // 3, len(data) // 2, len(data) - 1}:
            outcome = read_damaged(kind, data[:size], expected)
            assert outcome == "refused" or kind.name not in MUST_REFUSE, (kind.name, size)
            kind.path.write_bytes(data)


def test_files_put_in_the_place_of_another_are_refused_or_made_again(kinds):
    contents = {kind.name: kind.path.read_bytes() for kind in kinds}
    for kind in kinds:
        expected = kind.read()
        for other, data in contents.items():
            if other != kind.name:
                outcome = read_damaged(kind, data, expected)
                assert outcome == "refused" or kind.name not in MUST_REFUSE, (kind.name, other)
        kind.path.write_bytes(contents[kind.name])


def test_every_kind_of_file_is_tried(kinds):
    """A kind that is written and not tried would be forgotten."""
    assert {kind.path.suffix for kind in kinds} >= {
        ".parquet", ".h5", ".predictor", ".checkpoint", ".yaml", ".png", ".pdf", ".gif", ".obj",
        ".nbi", ".nbc",
    }  # fmt: skip
    assert all(isinstance(kind.path, Path) for kind in kinds)

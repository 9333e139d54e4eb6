"""Provenance that files carry."""

from __future__ import annotations

import pandas as pd
import pytest

from sensory_commutativity.runs.origin import READERS, OriginError, read_origin
from sensory_commutativity.studies.provenance import provenance
from tests.runs.examples import FILES


def test_every_type_of_file_carries_provenance(example_run, default_config):
    expected = provenance(default_config)
    files = [example_run / name for name in FILES if not name.endswith(".json")]
    assert {file.suffix for file in files} == set(READERS) - {".json", ".html", ".sha256"}
    for file in files:
        origin = read_origin(file)
        assert {key: origin[key] for key in expected} == expected, file
    assert list(read_origin(files[0]))[:3] == ["table", "profile", "config_sha256"]


def test_files_without_provenance_are_rejected(tmp_path):
    (tmp_path / "a.txt").write_text("x")
    (tmp_path / "a.parquet").write_text("x")
    pd.DataFrame({"a": [1]}).to_parquet(tmp_path / "b.parquet")
    cases = (
        ("none.png", "there is no such file"),
        ("a.txt", "carries no provenance, and lies in no run"),
        ("a.parquet", "cannot be read"),
        ("b.parquet", "carries no provenance"),
    )
    for name, message in cases:
        with pytest.raises(OriginError, match=message):
            read_origin(tmp_path / name)

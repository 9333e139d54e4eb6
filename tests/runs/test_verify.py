"""Verification of a run: no damaged file goes unnoticed."""

from __future__ import annotations

import shutil
from pathlib import Path

import pandas as pd
import pytest

from sensory_commutativity.errors import UserError
from sensory_commutativity.runs.checksums import MANIFEST, list_files
from sensory_commutativity.runs.verify import remove_bad_files, verify_run
from tests.runs.examples import (
    ARRAYS,
    FILES,
    PDF,
    PNG,
    PREDICTOR,
    TABLE,
    damage,
    set_time_after_checksums,
    write_scp,
)


def bad_files(run: Path) -> list[tuple[str, str]]:
    """Paths and statuses."""
    return [(bad.path, bad.status) for bad in verify_run(run).bad]


def truncations(data: bytes) -> list[bytes]:
    return [b"", data[: len(data) // 2], data[:-1]]


def test_an_unchanged_run_is_verified_with_and_without_checksums(run):
    assert verify_run(run) == ((), len(FILES), 0, 0, {})
    (run / MANIFEST).unlink()
    assert verify_run(run) == ((), 0, len(FILES), 0, {})


def test_checksums_reveal_every_flipped_bit_and_every_truncation(run):
    for name in FILES:
        data = (run / name).read_bytes()
        positions = (0, 1, len(data) // 3, len(data) // 2, len(data) - 3, len(data) - 1)
        flipped = [
            data[:i] + bytes([data[i] ^ bit]) + data[i + 1 :] for i in positions for bit in (1, 128)
        ]
        for content in (*flipped, *truncations(data)):
            damage(run / name, content)
            assert bad_files(run) == [(name, "damaged")], name
        damage(run / name, data)
    assert bad_files(run) == []


def test_without_checksums_every_truncation_is_found(run):
    (run / MANIFEST).unlink()
    for name in FILES:
        if name.endswith(".json"):  # without its last newline, it is still valid
            continue
        data = (run / name).read_bytes()
        for content in truncations(data):
            damage(run / name, content)
            assert bad_files(run) == [(name, "damaged")], (name, len(content))
        damage(run / name, data)
    damage(run / "data/apartment_ready/a.json", b'{"seconds": ')
    assert bad_files(run) == [("data/apartment_ready/a.json", "damaged")]


def test_a_file_written_after_the_checksums_is_changed_and_not_damaged(run, default_config):
    write_scp(run / TABLE, [0.75], default_config)
    set_time_after_checksums(run, TABLE)
    assert bad_files(run) == [(TABLE, "changed")]
    (run / TABLE).write_bytes(b"half")
    set_time_after_checksums(run, TABLE)
    assert bad_files(run) == [(TABLE, "damaged")]


def test_files_of_other_programs_are_not_bad(run):
    pd.DataFrame({"a": [1]}).to_parquet(run / "tables" / "mine.parquet")
    (run / "tables" / "mine.txt").write_text("x")
    assert verify_run(run) == ((), len(FILES), 0, 1, {})


def test_only_bad_files_and_the_checksums_are_removed(run):
    assert remove_bad_files(run, verify_run(run)) == []
    assert (run / MANIFEST).is_file() and list_files(run) == sorted(FILES)
    damage(run / PREDICTOR, b"x")
    damage(run / PNG, b"x")
    (run / ARRAYS).unlink()
    before = {path for path in run.rglob("*") if path.is_file()}
    assert (ARRAYS, "missing") in bad_files(run)
    removed = remove_bad_files(run, verify_run(run))
    assert set(removed) == {PREDICTOR, PNG, MANIFEST} and removed[-1] == MANIFEST
    remaining = {path for path in run.rglob("*") if path.is_file()}
    assert before - remaining == {run / name for name in removed}
    assert bad_files(run) == []


def test_a_published_run_may_omit_raw_data_and_models(run):
    shutil.rmtree(run / "data")
    shutil.rmtree(run / "models/navigation")
    verification = verify_run(run)
    assert verification.bad == ()
    assert verification.absent == {"data": 3, "models/navigation": 1}
    damage(run / PDF, b"x")
    with pytest.raises(UserError, match="data: absent"):
        remove_bad_files(run, verify_run(run))
    assert (run / PDF).exists() and (run / MANIFEST).exists()


def test_damaged_checksums_refer_to_no_file_outside_the_run(run, tmp_path):
    outside = tmp_path / "outside.png"
    outside.write_bytes(b"mine")
    lines = (run / MANIFEST).read_text().splitlines()
    n, zeros = len(lines), "0" * 64
    lines[-1:] = [f"{zeros}  ../outside.png", f"{zeros}  {outside}", lines[-1][:40]]
    (run / MANIFEST).write_text("\n".join(lines) + "\n")
    reasons = [f"line {k} is not the checksum of a file of this run" for k in (n, n + 1, n + 2)]
    assert list(verify_run(run).bad) == [(MANIFEST, "damaged", reason) for reason in reasons]
    assert remove_bad_files(run, verify_run(run)) == [MANIFEST]
    assert outside.exists() and list_files(run) == sorted(FILES)


def test_a_folder_that_is_not_a_run_is_rejected(tmp_path):
    with pytest.raises(UserError, match=r"not a run.*results/default"):
        verify_run(tmp_path)

"""The commands ``sensory-commutativity run ...``: what they print, and their exit codes."""

from __future__ import annotations

import json
import shutil
import zipfile

from click.testing import CliRunner

from sensory_commutativity.cli import main
from sensory_commutativity.errors import UserError
from sensory_commutativity.runs.checksums import MANIFEST
from sensory_commutativity.runs.origin import read_origin
from tests.runs.examples import (
    FILES,
    PDF,
    PNG,
    SHARD,
    TABLE,
    damage,
    set_time_after_checksums,
    write_scp,
)


def call(*arguments) -> tuple[int, str]:
    """Exit code and output of a command."""
    result = CliRunner().invoke(main, ["run", *map(str, arguments)])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.output


def call_rejected(*arguments) -> str:
    """Message of a command that raises UserError."""
    result = CliRunner().invoke(main, ["run", *map(str, arguments)])
    assert isinstance(result.exception, UserError), result.exception
    return str(result.exception)


def test_provenance_prints_text_or_json(example_run, default_config):
    for name in FILES:
        if name.endswith(".json"):
            continue
        code, text = call("provenance", example_run / name)
        assert code == 0 and default_config.digest() in text and "numpy " in text
        code, text = call("provenance", "--json", example_run / name)
        assert code == 0 and json.loads(text) == read_origin(example_run / name)


def test_compare_fails_if_values_are_beyond_their_intervals(run, tmp_path, default_config):
    within, beyond = tmp_path / "within", tmp_path / "beyond"
    write_scp(within / TABLE, [0.52], default_config)
    write_scp(beyond / TABLE, [0.9], default_config)
    code, text = call("compare", run, within)
    assert code == 0 and "1 of 1 rows, 0 of 1 intervals" in text
    code, text = call("compare", run, beyond)
    assert code == 1 and "1 of 1 rows, 1 of 1 intervals" in text and "scp 0.5 and 0.9" in text
    assert "holds no tables" in call_rejected("compare", run, tmp_path)


def test_checksums_and_verify(run):
    (run / MANIFEST).unlink()
    assert call("checksums", "--out", run / MANIFEST)[0] == 0
    code, text = call("verify", run, "--files-only")
    assert code == 0 and str(len(FILES)) in text
    damage(run / SHARD, b"x")
    code, text = call("verify", run)
    assert code == 1
    assert text.startswith(f"{run / SHARD}: damaged: does not have its checksum\n")
    assert f"sensory-commutativity run verify {run} --remove" in text


def test_verify_tells_changed_files_of_a_run_that_has_not_ended(run, default_config):
    write_scp(run / TABLE, [0.75], default_config)
    set_time_after_checksums(run, TABLE)
    code, text = call("verify", run)
    assert code == 1 and f"{run / TABLE}: changed: " in text
    assert "run the workflow to its end" in text


def test_verify_removes_bad_files_on_request(run):
    assert call("verify", run, "--remove")[0] == 0
    assert (run / MANIFEST).exists()
    damage(run / PNG, b"x")
    code, text = call("verify", run, "--remove")
    assert code == 1 and "run the workflow again" in text
    for name in (PNG, MANIFEST):
        assert f"{run / name}: deleted" in text and not (run / name).exists()


def test_verify_of_a_published_run_names_the_absent_folders(run):
    shutil.rmtree(run / "data")
    code, text = call("verify", run, "--files-only")
    assert code == 0 and text.startswith(f"{run / 'data'}: ") and "3 files" in text
    damage(run / PDF, b"x")
    code, text = call("verify", run)
    assert code == 1 and "--remove" not in text
    assert "data: absent" in call_rejected("verify", run, "--remove")


def test_crate_writes_a_zip_file(example_run, tmp_path):
    code, text = call("crate", example_run, "--out", tmp_path / "a.zip", "--with-data")
    assert code == 0 and "a.zip: " in text
    assert any(name.endswith(SHARD) for name in zipfile.ZipFile(tmp_path / "a.zip").namelist())

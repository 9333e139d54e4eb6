"""The whole workflow on the tiny profile: what it makes, that it makes it once, and that a kill changes nothing."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from conftest import ENVIRONMENT, command, copy_workflow, hashes, snakemake
from sensory_commutativity.config import load
from sensory_commutativity.figures.catalogue import FIGURES
from sensory_commutativity.tables import TABLES, read_table

WRITTEN = set(TABLES) - {"flatland_commutation_experiments"}  # that one stays among the raw data


def test_it_makes_every_table_and_figure_and_nothing_half_done(finished: Path) -> None:
    results = finished / "results" / "test"
    assert {p.stem for p in (results / "tables").iterdir()} == WRITTEN
    expected = {f"{name}.{kind}" for name in FIGURES for kind in ("png", "pdf")} | {"flatland_experiment.gif"}
    assert {p.name for p in (results / "figures").iterdir()} == expected
    assert not [p for p in results.rglob(".*")], "temporary files or batches were left behind"


def test_tables_have_the_promised_rows(finished: Path) -> None:
    tables = finished / "results" / "test" / "tables"
    config = load(finished / "config" / "default.yaml", finished / "config" / "test.yaml")
    experiments = read_table("flatland_experiments", tables / "flatland_experiments.parquet")
    assert len(experiments) == 8 * sum(run.experiments for run in config.flatland.runs())
    assert not experiments.duplicated(["world", "agent", "length", "dof", "experiment"]).any()
    scp = read_table("flatland_scp", tables / "flatland_scp.parquet")
    assert (scp["ci_low"] <= scp["scp"]).all() and (scp["scp"] <= scp["ci_high"]).all()
    commutation = read_table("flatland_commutation", tables / "flatland_commutation.parquet")
    assert commutation.groupby("world").size().tolist() == [64, 64]
    baselines = read_table("flatland_baselines", tables / "flatland_baselines.parquet")
    assert baselines["excess_error"].min() == 0


def test_tables_say_where_they_come_from(finished: Path) -> None:
    config = load(finished / "config" / "default.yaml", finished / "config" / "test.yaml")
    for path in (finished / "results" / "test" / "tables").iterdir():
        metadata = pq.read_schema(path).metadata
        assert metadata[b"table"].decode() == path.stem
        assert metadata[b"config_sha256"].decode() == config.digest()
        assert metadata[b"root_seed"].decode() == str(config.seed)


def test_a_second_run_does_nothing(finished: Path) -> None:
    before = {p: p.stat().st_mtime_ns for p in (finished / "results").rglob("*") if p.is_file()}
    run = snakemake(finished, "--cores", "2")
    assert run.returncode == 0, run.stderr
    assert {p: p.stat().st_mtime_ns for p in (finished / "results").rglob("*") if p.is_file()} == before


def test_a_changed_setting_runs_only_what_depends_on_it(finished: Path) -> None:
    run = snakemake(finished, "--cores", "1", "--dry-run", "--config", "flatland={commutation: {experiments: 11}}")
    assert run.returncode == 0, run.stderr
    planned = subprocess.run(
        [*[a for a in command("--cores", "1", "--dry-run") if a not in ("--quiet", "all")], "--config", "flatland={commutation: {experiments: 11}}"],
        cwd=finished, env=ENVIRONMENT, capture_output=True, text=True, timeout=300,
    ).stdout  # fmt: skip
    assert "flatland_commutation_part" in planned
    assert "flatland_experiments_part" not in planned
    assert "flatland_baselines_part" not in planned


def test_the_report_can_be_made(finished: Path) -> None:
    run = snakemake(finished, "--report", "report.html")
    assert run.returncode == 0, run.stderr
    text = (finished / "report.html").read_text()
    assert all(name in text for name in FIGURES)


def test_killed_half_way_and_resumed_on_one_core_gives_the_same_tables(finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "killed")
    data = folder / "results" / "test" / "data"
    process = subprocess.Popen(
        command("--cores", "1"), cwd=folder, env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    end = time.monotonic() + 300
    while len(list(data.rglob("[!.]*.parquet"))) < 8:
        assert process.poll() is None and time.monotonic() < end, "the workflow ended before it could be killed"
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = {p: p.stat().st_mtime_ns for p in data.rglob("[!.]*.parquet")}
    assert kept and not (folder / "results" / "test" / "tables").exists()
    assert snakemake(folder, "--unlock").returncode == 0
    run = snakemake(folder, "--cores", "1", "--rerun-incomplete")
    assert run.returncode == 0, run.stderr
    again = [p for p, when in kept.items() if p.stat().st_mtime_ns != when]
    assert len(again) <= 1, f"finished work was done again: {again}"
    assert hashes(folder / "results" / "test" / "tables") == hashes(finished / "results" / "test" / "tables")


@pytest.mark.parametrize(
    ("setting", "key"),
    [
        ("flatland={worlds: {furnished: {thing: 3}}}", "flatland.worlds.furnished.thing"),
        ("seed=-1", "seed"),
        ("flatland={reference: {experiments: many}}", "flatland.reference.experiments"),
        ("flatland={reference: {agent: nobody}}", "nobody"),
        ("results=/proc/nowhere", "/proc"),
        ("results=Snakefile/results", "Snakefile"),
    ],
)
def test_bad_settings_stop_before_any_job(tmp_path: Path, setting: str, key: str) -> None:
    folder = copy_workflow(tmp_path / "bad")
    before = sorted(p for p in folder.rglob("*") if ".snakemake" not in p.parts)
    run = snakemake(folder, "--cores", "1", "--config", setting)
    assert run.returncode == 2, run.stderr
    message = [line for line in run.stderr.splitlines() if line.startswith("error: ")]
    assert len(message) == 1 and key in message[0]
    assert sorted(p for p in folder.rglob("*") if ".snakemake" not in p.parts) == before

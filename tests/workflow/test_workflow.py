"""The whole workflow on the tiny profile: what it makes, that it makes it once, and that a kill changes nothing."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from sensory_commutativity.running import ENVIRONMENT, command, copy_workflow, snakemake
from sensory_commutativity.studies.catalogue import ARRAYS, FIGURES, source_file

from sensory_commutativity.runs.checksums import FOLDERS, MANIFEST, read_manifest
from sensory_commutativity.runs.verify import verify_run
from sensory_commutativity.storage.tables import TABLES, read_table
from sensory_commutativity.studies.loading import load

WRITTEN = set(TABLES) - {"flatland_commutation_experiments"}  # that one stays among the raw data


def test_no_room_for_the_things_is_said_before_any_job(tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "crowded")
    overlay = folder / "overlay.yaml"
    overlay.write_text(
        "flatland: {worlds: {furnished: {objects: 24, width: 200.0, height: 200.0, start_margin: 90.0}}}"
    )
    run = subprocess.run(
        [*command("--cores", "1")[:3], str(overlay), "--cores", "1"],
        cwd=folder,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert run.returncode == 2, run.stderr
    assert "flatland.worlds.furnished" in run.stderr and not (folder / "results").exists()


def test_it_makes_every_table_and_figure_and_nothing_half_done(finished: Path) -> None:
    results = finished / "results" / "test"
    assert {p.name for p in (results / "tables").iterdir()} == {
        source_file(name) for name in WRITTEN | set(ARRAYS)
    }
    expected = {f"{name}.{kind}" for name in FIGURES for kind in ("png", "pdf")} | {
        "flatland_experiment.gif"
    }
    expected |= {
        f"navigation_episode_{name}.gif"
        for name in load(
            finished / "config" / "default.yaml", finished / "config" / "test.yaml"
        ).navigation.action_spaces
    }
    assert {p.name for p in (results / "figures").iterdir()} == expected
    assert not list(results.rglob(".*")), "temporary files or batches were left behind"


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
    learner = (
        (scp["world"] == config.navigation.scp_world)
        & (scp["agent"] == config.navigation.agent)
        & (scp["threshold"] == 0)
    )
    alone = read_table("navigation_scp", tables / "navigation_scp.parquet")
    assert alone.to_dict("records") == scp[learner].to_dict("records") and len(alone) == 8
    curves = read_table("navigation_curves", tables / "navigation_curves.parquet")
    navigation = config.navigation
    assert (
        len(curves) == len(navigation.runs) * navigation.checkpoints
        and not curves.duplicated(["action_space", "seed", "step"]).any()
    )


def test_tables_say_where_they_come_from(finished: Path) -> None:
    config = load(finished / "config" / "default.yaml", finished / "config" / "test.yaml")
    for path in (finished / "results" / "test" / "tables").glob("*.parquet"):
        metadata = pq.read_schema(path).metadata
        assert metadata[b"table"].decode() == path.stem
        assert metadata[b"config_sha256"].decode() == config.digest()
        assert metadata[b"root_seed"].decode() == str(config.seed)


def test_the_checksums_are_of_everything_and_the_run_is_right(finished: Path) -> None:
    results = finished / "results" / "test"
    manifest = read_manifest(results / MANIFEST)
    made = {
        path.relative_to(results).as_posix()
        for folder in FOLDERS
        for path in (results / folder).rglob("*")
        if path.is_file()
    }
    assert set(manifest.hashes) == made and not manifest.invalid_lines
    found = verify_run(results)
    assert not found.bad and found.recorded == len(made)


def test_without_its_checksums_a_run_makes_anew_whatever_is_missing(
    finished: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "copy"
    shutil.copytree(finished, folder)  # with its times
    results = folder / "results" / "test"
    kinds = {
        path.parent: path
        for place in ("data", "models")
        for path in sorted((results / place).rglob("*"))
        if path.is_file()
    }
    assert len(kinds) > 10
    for path in (results / MANIFEST, *kinds.values()):
        path.unlink()
    run = subprocess.run(
        [*command()[:3], "--cores", "1", "--dry-run"],
        cwd=folder,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    missing = [path for path in kinds.values() if str(path.relative_to(folder)) not in run.stdout]
    assert not missing, f"checksums does not ask for {missing}"


def test_a_second_run_does_nothing(finished: Path) -> None:
    before = {p: p.stat().st_mtime_ns for p in (finished / "results").rglob("*") if p.is_file()}
    run = snakemake(finished, "--cores", "2")
    assert run.returncode == 0, run.stderr
    assert {
        p: p.stat().st_mtime_ns for p in (finished / "results").rglob("*") if p.is_file()
    } == before


@pytest.mark.parametrize(
    ("overlay", "again", "kept"),
    [
        (
            "seed: 7",
            {
                "flatland_experiments_part",
                "flatland_commutation_part",
                "flatland_baselines_part",
                "animation",
            },
            set(),
        ),
        (
            "flatland: {commutation: {experiments: 5}}",
            {"flatland_commutation_part"},
            {"flatland_experiments_part", "flatland_baselines_part"},
        ),
        (
            "flatland: {rest_steps: 4}",
            {"flatland_experiments_part", "flatland_commutation_part"},
            {"flatland_baselines_part"},
        ),
        (
            "flatland: {thresholds: [0.0, 5.0]}",
            {"flatland_scp", "flatland_sensitivity"},
            {"flatland_experiments_part", "flatland_commutation", "navigation_run"},
        ),
        (
            "flatland: {combinations: {experiments: 11}}",
            {"flatland_experiments_part", "flatland_scp"},
            {"navigation_run", "navigation_scores"},
        ),
        (
            "apartment: {thresholds: [0.0, 20.0, 50.0]}",
            {"apartment_scp", "apartment_hierarchy", "apartment_order"},
            {"apartment_experiments_part", "flatland_scp", "mask_pairs"},
        ),
        (
            "apartment: {reach: 0.2}",
            {"apartment_experiments_part"},
            {"flatland_experiments_part", "mask_pairs"},
        ),
        (
            "apartment: {image_size: 48}",
            {"apartment_experiments_part"},
            {"flatland_experiments_part", "mask_pairs"},
        ),
        (
            "masks: {tests: {tuples: 3}}",
            {"mask_model_scores", "mask_summary"},
            {"mask_tuples", "mask_training", "apartment_experiments_part"},
        ),
        (
            "masks: {raft: {learning_rate: 0.002}}",
            {"mask_training", "mask_model_scores"},
            {"mask_pairs", "mask_tuples"},
        ),
        (
            "masks: {judge: {samples: 12}}",
            {"mask_judging", "mask_model_scores"},
            {"mask_training", "mask_places", "mask_tuples"},
        ),
        (
            "masks: {judge: {pairs: 1}}",
            {"mask_places", "mask_judging"},
            {"mask_training", "mask_pairs"},
        ),
        (
            "masks: {map: {spacing: 1.5}}",
            {"local_scp_experiments", "local_scp_summary"},
            {"mask_training", "mask_tuples"},
        ),
        (
            "navigation: {alpha: 0.01}",
            {"navigation_comparisons", "navigation_calibration"},
            {"navigation_run", "navigation_scores"},
        ),
        (
            "flatland: {baselines: {epochs: 3}}",
            {"flatland_baselines_part"},
            {"flatland_experiments_part", "flatland_scp"},
        ),
        (
            "navigation: {learner: {epochs: 3}}",
            {"navigation_run", "navigation_curves"},
            {"flatland_scp", "navigation_action_spaces"},
        ),
        (
            "navigation: {threshold_return: 5.0}",
            {"navigation_scores"},
            {"navigation_run", "navigation_curves"},
        ),
        (
            "navigation: {seeds: [2000, 2001, 2002, 2003, 4]}",
            {"navigation_run", "navigation_curves"},
            {"flatland_scp"},
        ),
    ],
)
def test_a_changed_setting_runs_what_depends_on_it_at_once_and_nothing_else(
    finished: Path, tmp_path: Path, overlay: str, again: set[str], kept: set[str]
) -> None:
    file = tmp_path / "overlay.yaml"
    file.write_text(overlay)
    run = subprocess.run(
        [str(Path(sys.executable).parent / "snakemake"), "--configfile", "config/test.yaml", str(file), "--cores", "1", "--dry-run"],
        cwd=finished, env=ENVIRONMENT, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    planned = set(re.findall(r"^rule (\w+):", run.stdout, re.MULTILINE)) | set(
        re.findall(r"^(\w+) +\d+$", run.stdout, re.MULTILINE)
    )
    assert again <= planned
    assert not kept & planned


def test_a_further_seed_trains_that_seed_only(finished: Path, tmp_path: Path) -> None:
    file = tmp_path / "overlay.yaml"
    file.write_text("navigation: {seeds: [2000, 2001, 2002, 2003, 77]}")
    run = subprocess.run(
        [str(Path(sys.executable).parent / "snakemake"), "--configfile", "config/test.yaml", str(file), "--cores", "1", "--dry-run"],
        cwd=finished, env=ENVIRONMENT, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    assert (
        re.findall(r"^navigation_run +(\d+)$", run.stdout, re.MULTILINE)[0] == "3"
    )  # one for each action space


def test_the_report_can_be_made(finished: Path) -> None:
    run = snakemake(finished, "--report", "report.html")
    assert run.returncode == 0, run.stderr
    text = (finished / "report.html").read_text()
    assert all(name in text for name in FIGURES)


@pytest.mark.parametrize(
    ("setting", "key"),
    [
        ("flatland={worlds: {furnished: {thing: 3}}}", "flatland.worlds.furnished.thing"),
        ("seed=-1", "seed"),
        ("flatland={reference: {experiments: many}}", "flatland.reference.experiments"),
        ("flatland={reference: {agent: nobody}}", "nobody"),
        ("results=/proc/nowhere", "/proc"),
        ("results=Snakefile/results", "Snakefile"),
        ("flatland={worlds: {furnished: {thing: 3}}, agents: {}}", "flatland"),
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

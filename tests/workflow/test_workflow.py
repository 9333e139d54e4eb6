"""The whole workflow on the test profile: what it produces, that it produces it once, and what a
changed setting runs again."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from sensory_commutativity.runs.checksums import FOLDERS, MANIFEST, read_manifest
from sensory_commutativity.runs.verify import verify_run
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.declarations import Animation, Figure, Table
from sensory_commutativity.studies.loading import load
from sensory_commutativity.studies.registry import configured
from sensory_commutativity.studies.runner import read_product
from tests.helpers import DEFAULT

from .running import BIN, command, copy_workflow, dry_run, run, snakemake

RESULTS = Path("results", "test")


def load_config(folder: Path) -> Config:
    return load(folder / "config" / "config.yaml", folder / "config" / "test.yaml")


def test_rooms_that_are_too_small_are_refused_before_any_job(tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "crowded")
    room = "{objects: 24, width: 200.0, height: 200.0, start_margin: 90.0}"
    (folder / "layer.yaml").write_text(f"flatland: {{worlds: {{furnished: {room}}}}}")
    result = run(command("--cores", "1", layers=["layer.yaml"]), folder)
    assert result.returncode == 2, result.stderr
    assert "flatland.worlds.furnished" in result.stderr and not (folder / "results").exists()


def test_every_table_and_figure_is_there_and_nothing_unfinished(finished: Path) -> None:
    results, config = finished / RESULTS, load_config(finished)
    tables = {f"{name}.parquet" for name, table in configured(Table, config).items()
              if not table.shards_only}  # fmt: skip
    assert {path.name for path in (results / "tables").iterdir()} == tables | {"mask_examples.h5"}
    figures = {f"{name}.{kind}" for name in configured(Figure, config) for kind in ("png", "pdf")}
    for animation in configured(Animation, config).values():
        runs = animation.shards.all(config) if animation.shards else [None]
        figures |= {animation.file(one).name for one in runs}
    assert {path.name for path in (results / "figures").iterdir()} == figures
    assert not list(results.rglob(".*")), "temporary files or batches were left behind"


def test_every_table_passes_its_checks_and_tells_its_provenance(
    finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(finished)  # where its paths lead from
    config = load_config(finished)
    frames = {}
    for name, table in configured(Table, config).items():
        if table.shards_only:
            continue
        path = finished / RESULTS / table.file()
        frames[name] = read_product(table, config, path)
        metadata = {k.decode(): v.decode() for k, v in pq.read_schema(path).metadata.items()}
        assert metadata["table"] == name
        assert metadata["config_sha256"] == config.digest()
        assert metadata["root_seed"] == str(config.seed)
    scp, navigation = frames["flatland_scp"], config.navigation
    assert (scp["ci_low"] <= scp["scp"]).all() and (scp["scp"] <= scp["ci_high"]).all()
    assert frames["flatland_baselines"]["excess_error"].min() == 0
    learner = (
        (scp["world"] == navigation.scp_world)
        & (scp["agent"] == navigation.agent)
        & (scp["threshold"] == 0)
    )
    alone = frames["navigation_scp"]
    assert alone.to_dict("records") == scp[learner].to_dict("records") and len(alone) == 8


def test_everything_has_its_checksum(finished: Path) -> None:
    results = finished / RESULTS
    manifest = read_manifest(results / MANIFEST)
    files = {
        path.relative_to(results).as_posix()
        for folder in FOLDERS
        for path in (results / folder).rglob("*")
        if path.is_file()
    }
    assert set(manifest.hashes) == files and not manifest.invalid_lines
    verification = verify_run(results)
    assert not verification.bad and verification.recorded == len(files)


def test_checksums_ask_for_every_missing_file(finished: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(finished, tmp_path / "copy")  # with its times
    results = folder / RESULTS
    of_each_folder = {
        path.parent: path
        for place in ("data", "models")
        for path in sorted((results / place).rglob("*"))
        if path.is_file()
    }
    assert len(of_each_folder) > 10
    for path in (results / MANIFEST, *of_each_folder.values()):
        path.unlink()
    plan = dry_run(folder, "config/test.yaml", "--cores", "1")
    assert plan.returncode == 0, plan.stderr
    missing = [path.relative_to(folder) for path in of_each_folder.values()]
    not_planned = [path for path in missing if str(path) not in plan.stdout]
    assert not not_planned, f"checksums does not ask for {not_planned}"


def test_a_second_run_does_nothing(finished: Path) -> None:
    def written() -> dict[Path, int]:
        return {
            path: path.stat().st_mtime_ns
            for path in (finished / "results").rglob("*")
            if path.is_file()
        }

    before = written()
    result = snakemake(finished, "--cores", "2")
    assert result.returncode == 0, result.stderr
    assert written() == before


def test_a_changed_setting_runs_what_depends_on_it_and_nothing_else(
    finished: Path, tmp_path: Path
) -> None:
    """That rules use their digests; which settings a digest covers is tested with declarations."""
    cases = {
        "flatland: {thresholds: [0.0, 5.0]}": (
            {"flatland_scp", "flatland_sensitivity"},
            {"flatland_experiments_shard", "flatland_commutation", "navigation_policy"},
        ),
        "masks: {view_classifier: {samples: 12}}": (
            {"mask_predictor", "mask_scores_shard"},
            {"mask_training", "mask_regions_shard", "mask_tuples_shard"},
        ),
    }
    for overlay, (again, kept) in cases.items():
        (tmp_path / "layer.yaml").write_text(overlay)
        plan = dry_run(finished, tmp_path / "layer.yaml", "--cores", "1")
        assert plan.returncode == 0, plan.stderr
        planned = set(re.findall(r"^rule (\w+):", plan.stdout, re.MULTILINE))
        planned |= set(re.findall(r"^(\w+) +\d+$", plan.stdout, re.MULTILINE))
        assert again <= planned, overlay
        assert not kept & planned, overlay


def test_a_further_seed_trains_that_seed_only(finished: Path, tmp_path: Path) -> None:
    (tmp_path / "layer.yaml").write_text("navigation: {seeds: [2000, 2001, 2002, 2003, 77]}")
    plan = dry_run(finished, tmp_path / "layer.yaml", "--cores", "1")
    assert plan.returncode == 0, plan.stderr
    trained = re.findall(r"^navigation_policy +(\d+)$", plan.stdout, re.MULTILINE)
    assert trained[0] == "3"  # one for each action space


def test_the_report_holds_every_figure(finished: Path) -> None:
    result = snakemake(finished, "--report", "report.html")
    assert result.returncode == 0, result.stderr
    text = (finished / "report.html").read_text()
    assert all(name in text for name in configured(Figure, load_config(finished)))


def test_bad_settings_stop_before_any_job(tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "bad")

    def files() -> list[Path]:
        return sorted(path for path in folder.rglob("*") if ".snakemake" not in path.parts)

    before = files()
    for setting, key in (
        ("flatland={worlds: {furnished: {objekts: 3}}}", "flatland.worlds.furnished.objekts"),
        ("seed=-1", "seed"),
        ("flatland={reference: {agent: nobody}}", "nobody"),
        ("results=/proc/nowhere", "/proc"),
        ("results=workflow/Snakefile/results", "Snakefile"),
    ):
        result = snakemake(folder, "--cores", "1", "--config", setting)
        assert result.returncode == 2, result.stderr
        messages = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
        assert len(messages) == 1 and key in messages[0], setting
        assert files() == before, setting


def test_the_study_without_a_reset_is_planned_where_the_configuration_has_it(
    tmp_path: Path,
) -> None:
    folder = copy_workflow(tmp_path / "planned")
    line = [BIN / "snakemake", "--cores", "1", "--dry-run", "--quiet", "host"]
    plan = run([*line, "--configfile", "config/reset-free.yaml", "--", "reset_free"], folder)
    assert plan.returncode == 0, plan.stderr
    planned = set(re.findall(r"^(\w+) +\d+$", plan.stdout, re.MULTILINE))
    expected = {name for name in configured(Table, load(DEFAULT)) if name.startswith("reset_free")}
    assert expected | {"reset_free_trials_shard", "figure_reset_free_scp"} <= planned
    left_out = run([*line, "--configfile", "config/test.yaml"], folder)
    assert left_out.returncode == 0 and "reset_free_scp" not in left_out.stdout

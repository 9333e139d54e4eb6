"""runs/crate.py: a run as a Workflow Run RO-Crate."""

from __future__ import annotations

import datetime
import json
import shutil
import zipfile
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from click.testing import CliRunner
from rocrate.rocrate import ROCrate
from sensory_commutativity.test_runs import scp

from sensory_commutativity.cli import main
from sensory_commutativity.errors import UserError
from sensory_commutativity.runs.checksums import MANIFEST, sha256, write_manifest
from sensory_commutativity.runs.crate import write_crate
from sensory_commutativity.storage.provenance import provenance
from sensory_commutativity.storage.tables import write_table
from sensory_commutativity.studies.loading import write_resolved
from sensory_commutativity.studies.plotting import save

DAY = datetime.date(2026, 1, 31)
RESULTS = (
    "tables/flatland_scp.parquet",
    "tables/navigation_scp.parquet",
    "figures/a.pdf",
    "figures/a.png",
)


@pytest.fixture(scope="module")
def made(tmp_path_factory, default_config) -> Path:
    """A small run with two tables, a figure, raw data and checksums."""
    run = tmp_path_factory.mktemp("made") / "run"
    write_resolved(default_config, run / "config.yaml")
    for name in (
        "tables/flatland_scp",
        "tables/navigation_scp",
        "data/flatland_experiments/a.1-of-1",
    ):
        write_table(
            "flatland_scp" if "flatland" in name else "navigation_scp",
            scp([0.5]),
            run / f"{name}.parquet",
            default_config,
        )
    figure, axes = plt.subplots(figsize=(1, 1))
    axes.plot([0, 1])
    save(figure, run / "figures" / "a.png", default_config)
    write_manifest(run / MANIFEST)
    return run


@pytest.fixture
def run(made, tmp_path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "run"))


@pytest.fixture(scope="module")
def unpacked(made, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("crate")
    write_crate(made, folder / "crate.zip", date=DAY)
    zipfile.ZipFile(folder / "crate.zip").extractall(folder / "crate")
    return folder / "crate"


def ids(entities) -> set[str]:
    return {entity.id for entity in entities}


def test_the_workflow_is_the_main_entity_and_was_run_on_the_settings(unpacked, default_config):
    crate = ROCrate(unpacked)
    workflow = crate.mainEntity
    assert workflow.id == "Snakefile" and "ComputationalWorkflow" in workflow.type
    assert workflow["programmingLanguage"]["name"] == "Snakemake"
    action = crate.root_dataset["mentions"]
    assert action.type == "CreateAction" and action["instrument"] is workflow
    where = f"results/{default_config.profile}"
    assert ids(action["object"]) == {f"{where}/config.yaml", "#root_seed"}
    assert ids(action["result"]) == {f"{where}/{name}" for name in RESULTS}
    assert {f"https://w3id.org/ro/wfrun/{kind}/0.5" for kind in ("process", "workflow")} < ids(
        crate.root_dataset["conformsTo"]
    )
    assert (
        crate.root_dataset["datePublished"] == "2026-01-31"
        and crate.root_dataset["license"].id == "https://spdx.org/licenses/MIT"
    )


def test_it_says_where_the_results_come_from(unpacked, default_config):
    crate = ROCrate(unpacked)
    action = crate.root_dataset["mentions"]
    said = {
        value["name"]: value["value"]
        for value in [*action["additionalProperty"], crate.get("#root_seed")]
    }
    about = provenance(default_config)
    assert said == {
        key: about[key]
        for key in ("config_sha256", "git_commit", "python", "platform", "root_seed")
    }
    needed = {
        package["name"]: package["version"] for package in crate.mainEntity["softwareRequirements"]
    }
    assert needed == {
        name: version
        for name, version in json.loads(about["packages"]).items()
        if version != "absent"
    }


def test_every_file_that_it_names_is_in_it_with_its_checksum(unpacked, made):
    crate = ROCrate(unpacked)
    files = [
        entity for entity in crate.data_entities if entity.type == "File" or "File" in entity.type
    ]
    assert len(files) > len(RESULTS) + 3
    for entity in files:
        assert (unpacked / entity.id).is_file(), entity.id
        if "sha256" in entity:
            assert sha256(unpacked / entity.id) == entity["sha256"] and entity[
                "contentSize"
            ] == str((unpacked / entity.id).stat().st_size)
    assert sum("sha256" in entity for entity in files) == len(RESULTS)
    assert (unpacked / "workflow" / "rules" / "common.smk").is_file() and (
        unpacked / "config" / "default.yaml"
    ).is_file()
    assert not list(unpacked.rglob("*.pyc")) and not list(unpacked.rglob("data"))


def test_raw_data_go_in_when_asked(made, tmp_path):
    said = CliRunner().invoke(
        main, ["crate", str(made), "--out", str(tmp_path / "a.zip"), "--with-data"]
    )
    assert said.exit_code == 0 and "a.zip: " in said.output
    assert any(
        name.endswith("data/flatland_experiments/a.1-of-1.parquet")
        for name in zipfile.ZipFile(tmp_path / "a.zip").namelist()
    )


def test_the_same_run_gives_the_same_crate(made, tmp_path):
    for name in ("a.zip", "b.zip"):
        write_crate(made, tmp_path / name, date=DAY)
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()


def test_a_damaged_run_gives_no_crate(run, tmp_path):
    (run / "figures" / "a.pdf").write_bytes(b"x")
    with pytest.raises(
        UserError, match=r"a\.pdf: not what .* says; see sensory-commutativity verify"
    ):
        write_crate(run, tmp_path / "a.zip")
    assert not list(tmp_path.glob("*.zip"))


def test_a_folder_that_is_no_run_is_told(run, tmp_path):
    with pytest.raises(UserError, match="holds no tables; give a folder like results/default"):
        write_crate(tmp_path, tmp_path / "a.zip")
    (run / "config.yaml").unlink()
    with pytest.raises(UserError, match=r"config\.yaml: missing .* run the workflow again"):
        write_crate(run, tmp_path / "a.zip")

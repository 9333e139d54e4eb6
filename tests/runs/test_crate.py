"""A run as a Workflow Run RO-Crate."""

from __future__ import annotations

import datetime
import json
import zipfile
from pathlib import Path

import pytest
from rocrate.rocrate import ROCrate

from sensory_commutativity.errors import UserError
from sensory_commutativity.runs.crate import write_crate
from sensory_commutativity.storage.hashing import sha256
from sensory_commutativity.studies.provenance import provenance
from tests.runs.examples import FILES, PDF

DATE = datetime.date(2026, 1, 31)
RESULTS = [name for name in FILES if not name.startswith("data/")]


@pytest.fixture(scope="module")
def unpacked(example_run, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("crate")
    write_crate(example_run, folder / "crate.zip", date=DATE)
    zipfile.ZipFile(folder / "crate.zip").extractall(folder / "crate")
    return folder / "crate"


@pytest.fixture(scope="module")
def crate(unpacked) -> ROCrate:
    return ROCrate(unpacked)


def ids(entities) -> set[str]:
    return {entity.id for entity in entities}


def test_the_workflow_was_run_on_the_settings(crate, default_config):
    workflow = crate.mainEntity
    assert workflow.id == "workflow/Snakefile" and "ComputationalWorkflow" in workflow.type
    assert workflow["programmingLanguage"]["name"] == "Snakemake"
    root = crate.root_dataset
    action = root["mentions"]
    assert action.type == "CreateAction" and action["instrument"] is workflow
    folder = f"results/{default_config.profile}"
    assert ids(action["object"]) == {f"{folder}/config.yaml", "#root_seed"}
    assert ids(action["result"]) == {f"{folder}/{name}" for name in RESULTS}
    profiles = {f"https://w3id.org/ro/wfrun/{kind}/0.5" for kind in ("process", "workflow")}
    assert profiles < ids(root["conformsTo"])
    assert root["datePublished"] == "2026-01-31"
    assert root["license"].id == "https://spdx.org/licenses/MIT"


def test_the_provenance_of_the_results_is_described(crate, default_config):
    action = crate.root_dataset["mentions"]
    values = [*action["additionalProperty"], crate.get("#root_seed")]
    origin = provenance(default_config)
    keys = ("config_sha256", "git_commit", "python", "platform", "root_seed")
    assert {v["name"]: v["value"] for v in values} == {key: origin[key] for key in keys}
    packages = {p["name"]: p["version"] for p in crate.mainEntity["softwareRequirements"]}
    versions = json.loads(origin["packages"])
    assert packages == {name: v for name, v in versions.items() if v != "absent"}


def test_every_described_file_is_included(crate, unpacked):
    files = [entity for entity in crate.data_entities if "File" in entity.type]
    assert len(files) > len(RESULTS) + 3
    for entity in files:
        file = unpacked / entity.id
        assert file.is_file(), entity.id
        if "sha256" in entity:
            assert entity["sha256"] == sha256(file)
            assert entity["contentSize"] == str(file.stat().st_size)
    assert sum("sha256" in entity for entity in files) == len(RESULTS)


def test_the_workflow_is_included_without_raw_data_and_generated_files(unpacked):
    for name in ("workflow/rules/common.smk", "config/config.yaml"):
        assert (unpacked / name).is_file(), name
    assert not list(unpacked.rglob("*.pyc"))
    assert not list((unpacked / "results").rglob("data"))


def test_raw_data_are_included_on_request(example_run, tmp_path):
    write_crate(example_run, tmp_path / "a.zip", with_data=True)
    names = zipfile.ZipFile(tmp_path / "a.zip").namelist()
    assert all(any(entry.endswith(name) for entry in names) for name in FILES)


def test_equal_runs_give_equal_crates(example_run, tmp_path):
    for name in ("a.zip", "b.zip"):
        write_crate(example_run, tmp_path / name, date=DATE)
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()


def test_damaged_and_incomplete_runs_are_rejected(run, tmp_path):
    data = (run / PDF).read_bytes()
    (run / PDF).write_bytes(b"x")
    message = r"a\.pdf: does not have its checksum .*; see sensory-commutativity run verify"
    with pytest.raises(UserError, match=message):
        write_crate(run, tmp_path / "a.zip")
    (run / PDF).write_bytes(data)
    (run / "config.yaml").unlink()
    with pytest.raises(UserError, match=r"config\.yaml: missing .* run the workflow again"):
        write_crate(run, tmp_path / "a.zip")
    with pytest.raises(UserError, match="holds no tables; give a folder like results/default"):
        write_crate(tmp_path, tmp_path / "a.zip")
    assert not list(tmp_path.glob("*.zip"))

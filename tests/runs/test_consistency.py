"""A run whose files are all whole can still be wrong: what contradicts the rest is named."""

from __future__ import annotations

import base64
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner
from PIL import Image

from sensory_commutativity.cli import main
from sensory_commutativity.cli.products import default_inputs
from sensory_commutativity.runs.checksums import MANIFEST, write_manifest
from sensory_commutativity.runs.consistency import check_consistency
from sensory_commutativity.runs.origin import read_origin
from sensory_commutativity.runs.verify import verify_run
from sensory_commutativity.storage import provenance as storage_provenance
from sensory_commutativity.storage.tables import read_stored_table, write_table
from sensory_commutativity.studies import provenance as studies_provenance
from sensory_commutativity.studies import runner
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.declarations import Figure
from sensory_commutativity.studies.loading import load, write_resolved
from sensory_commutativity.studies.registry import find, find_table
from tests.adversarial.kinds import experiment_rows, write_shards
from tests.helpers import DEFAULT, ROOT
from tests.studies.examples import overlay, write_frame

SCP, FIGURE = "tables/flatland_scp.parquet", "figures/flatland_free_space.png"
BY_THE_WRITER = ("table", "seal", "rows_sha256")
"""Metadata that write_table adds."""
SPACES = "tables/navigation_action_spaces.parquet"


@pytest.fixture(scope="module")
def config() -> Config:
    return load(DEFAULT, ROOT / "config" / "test.yaml")


@pytest.fixture(autouse=True)
def clean_code(monkeypatch):
    """Files say that they come from a commit, also where code is being changed."""
    origin = {**storage_provenance.environment(), "git_commit": "a" * 40}
    monkeypatch.setattr(studies_provenance, "environment", lambda: dict(origin))
    monkeypatch.setattr(storage_provenance, "git_commit", lambda: "a" * 40)


def write_report(run: Path) -> None:
    """A report as Snakemake writes it, of all figures."""
    results = {}
    for path in sorted((run / "figures").glob("*.png")):
        data = base64.b64encode(path.read_bytes()).decode()
        uri = f"data:image/png;charset=utf8;filename={path.name};base64,{data}"
        results[str(path)] = {"name": path.name, "data_uri": uri}
    html = f"<html><script>var results = {json.dumps(results)}\n</script></html>"
    (run / "report.html").write_text(html)


def draw(run: Path, config: Config) -> None:
    runner.write_product(find(Figure, "flatland_free_space"), config, [run / SCP], run / FIGURE)


def write_tables(run: Path, config: Config, distances: float = 1.0) -> None:
    """The tables flatland_experiments, flatland_scp, and those of the action spaces."""
    tables, frame = run / "tables", experiment_rows(config)
    frame = frame.assign(distance=frame["distance"] * distances)
    source = write_frame(find_table("flatland_experiments"), config, tables, frame)
    runner.write_product(find_table("flatland_scp"), config, [source], run / SCP)
    measured = find_table("navigation_scp")
    shards = write_shards(config, run / "data" / "flatland_experiments")
    names = {path.name for path in default_inputs(measured, config, None)}
    inputs = [path for path in shards if path.name in names]
    runner.write_product(measured, config, inputs, tables / "navigation_scp.parquet")
    spaces = find_table("navigation_action_spaces")
    runner.write_product(spaces, config, [tables / "navigation_scp.parquet"], run / SPACES)


@pytest.fixture
def run(config, tmp_path) -> Path:
    """A clean run of a few tables, a figure and a report."""
    folder = tmp_path / "run"
    write_tables(folder, config)
    draw(folder, config)
    write_resolved(config, folder / "config.yaml")
    write_report(folder)
    write_manifest(folder / MANIFEST)
    return folder


def found(run: Path, redraw: bool = False) -> list[tuple[str, str]]:
    return list(check_consistency(run, redraw).contradictions)


def test_a_clean_run_is_told_from_one_of_whole_files(run, monkeypatch):
    output = CliRunner().invoke(main, ["run", "verify", str(run)])
    assert output.exit_code == 0 and "a clean run: all files come from one" in output.output
    shutil.copy(run / FIGURE, run / "figures" / "copy.png")
    Image.new("RGB", (8, 8)).save(run / "figures" / "mine.png")
    output = CliRunner().invoke(main, ["run", "verify", str(run), "--no-redraw"])
    assert "note: 1 files carry no provenance" in output.output
    assert "not a clean run: 0 contradictions, 1 note" in output.output


def test_a_table_of_half_the_seeds_is_named(run, config):
    seeds = config.navigation.seeds
    twice = overlay(config, navigation={"seeds": [*seeds, *(seed + 100 for seed in seeds)]})
    write_resolved(twice, run / "config.yaml")
    table = find_table("navigation_action_spaces")
    runner.write_product(table, config, [run / "tables/navigation_scp.parquet"], run / SPACES)
    reasons = dict(found(run))
    assert "other settings" in reasons[SPACES]
    stored = read_stored_table(run / SPACES, table.name, table.columns)
    old = {  # as earlier versions wrote tables
        key: value
        for key, value in stored.metadata.items()
        if key not in ("settings_sha256", "inputs", "seal", "rows_sha256", "table")
    }
    write_table(run / SPACES, table.name, table.columns, stored.frame, old)
    assert "groups of rows missing" in dict(found(run))[SPACES]


def other_tables(run: Path, config: Config) -> None:
    write_tables(run, config, distances=0.0)


def other_figure(run: Path, config: Config) -> None:
    content = (run / SCP).read_bytes()
    write_tables(run, config, distances=0.0)
    draw(run, config)
    write_tables(run, config)
    assert (run / SCP).read_bytes() == content


def edited_figure(run: Path, config: Config) -> None:
    """The numbers in a picture are painted over; what it says of itself stays."""
    from PIL.PngImagePlugin import PngInfo

    with Image.open(run / FIGURE) as image:
        about = PngInfo()
        for key, value in image.info.items():
            if isinstance(value, str):
                about.add_text(key, value)
        image.load()
        image.putpixel((40, 40), (1, 2, 3, 255))
        image.save(run / FIGURE, pnginfo=about)


def exchanged_pdf(run: Path, config: Config) -> None:
    pdf = (run / FIGURE).with_suffix(".pdf")
    content = (run / FIGURE).read_bytes()
    other_figure(run, config)
    assert pdf.is_file()
    (run / FIGURE).write_bytes(content)


@pytest.mark.parametrize("change", [other_tables, other_figure, edited_figure, exchanged_pdf])
def test_a_figure_that_is_not_drawn_from_the_tables_beside_it_is_named(run, config, change):
    change(run, config)
    assert [bad.status for bad in verify_run(run).bad if bad.path == FIGURE] in ([], ["changed"])
    names = {Path(path).stem for path, _ in found(run, redraw=True)}
    assert "flatland_free_space" in names
    assert CliRunner().invoke(main, ["run", "verify", str(run), "--no-redraw"]).exit_code == 1


def test_a_report_with_other_figures_is_named(run, config):
    other_tables(run, config)
    draw(run, config)
    assert [path for path, _ in found(run)] == ["report.html"]
    write_report(run)
    assert found(run) == []
    (run / FIGURE).unlink()
    (run / FIGURE).with_suffix(".pdf").unlink()
    ((path, reason),) = found(run)
    assert path == "report.html" and "figures that are not there: flatland_free_space.png" in reason


def with_origin(key: str, value: str) -> Callable[[Path], None]:
    """Write a table again with another value in its provenance."""

    def change(run: Path) -> None:
        table = find_table("navigation_action_spaces")
        stored = read_stored_table(run / SPACES, table.name, table.columns)
        own = {k: v for k, v in stored.metadata.items() if k not in BY_THE_WRITER}
        write_table(run / SPACES, table.name, table.columns, stored.frame, {**own, key: value})

    return change


@pytest.mark.parametrize("key", ["git_commit", "config_sha256", "root_seed", "profile"])
def test_a_mixture_of_commits_or_configurations_is_named(run, key):
    with_origin(key, "7" * 40)(run)
    reasons = [reason for _, reason in found(run)]
    assert any(f"files of 2 different {key}" in reason for reason in reasons)
    write_manifest(run / MANIFEST)
    assert any(f"files of 2 different {key}" in reason for _, reason in found(run))


def test_uncommitted_changes_make_a_run_unclean(run, monkeypatch):
    for path in (run / "tables").iterdir():
        table = find_table(path.stem)
        stored = read_stored_table(path, table.name, table.columns)
        own = {k: v for k, v in stored.metadata.items() if k not in BY_THE_WRITER}
        own["git_commit"] = "a" * 40 + "-dirty"
        write_table(path, table.name, table.columns, stored.frame, own)
    result = check_consistency(run, redraw=False)
    assert any("uncommitted changes" in note for note in result.notes) and not result.is_clean


def test_settings_of_an_earlier_version_are_replaced_by_those_of_the_profile(run):
    text = (run / "config.yaml").read_text().replace("objects:", "things:")
    (run / "config.yaml").write_text("\n".join(text.splitlines()[1:-1]))
    result = check_consistency(run, redraw=False)
    assert any("was written by another version" in note for note in result.notes)
    assert "profile test" in " ".join(result.notes)


def test_every_file_of_a_run_has_its_provenance(run, config):
    (run / "logs").mkdir()
    (run / "logs" / "flatland_scp.log").write_text("")
    for path in run.rglob("*"):
        if path.is_file():
            origin = read_origin(path)
            assert origin["profile"] == config.profile, path
            assert origin["config_sha256"] == config.digest(), path
    report = read_origin(run / "report.html")
    assert report["git_commit"] == "a" * 40


def test_no_file_of_a_run_is_read_as_a_table_of_pandas(run):
    """A run may hold tables of other programs; they are no part of it."""
    pd.DataFrame({"a": [1]}).to_parquet(run / "tables" / "mine.parquet")
    assert found(run) == []

"""cli/: what a person types, and what they are told when it cannot be done."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
import yaml

from sensory_commutativity import cli
from sensory_commutativity.storage.tables import read_table
from sensory_commutativity.studies.flatland.tables.flatland_experiments import run_experiments
from sensory_commutativity.studies.loading import json_schema, load
from tests.helpers import DEFAULT, DOFS, ROOT, update_flatland

PROGRAM = str(Path(sys.executable).parent / "sensory-commutativity")
PREFIX = "sensory-commutativity: error: "


class Said:
    """What a command printed and its exit code."""

    def __init__(self, code: int, out: str, err: str):
        self.code, self.out, self.err = code, out, err


@pytest.fixture
def cli_run(monkeypatch, capsys, tmp_path):
    """The entry point, called in this process, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        sys.modules["__main__"], "__package__", None
    )  # so that click takes the program's name from argv, not "pytest"

    def call(*arguments: str) -> Said:
        monkeypatch.setattr(sys, "argv", [PROGRAM, *map(str, arguments)])
        code = 0
        try:
            cli.run()
        except SystemExit as leave:
            code = leave.code
        return Said(code, *capsys.readouterr())

    return call


def commands() -> list[str]:
    return sorted(cli.main.commands)


# ---- help ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", commands())
@pytest.mark.parametrize("flag", ["--help", "-h"])
def test_every_command_has_help(cli_run, command, flag):
    said = cli_run(command, flag)
    assert said.code in (0, None)
    assert not said.err
    assert said.out.startswith(f"Usage: sensory-commutativity {command}")
    description = cli.main.commands[command].help
    assert len(description) > 20
    assert description.split()[0] in said.out


@pytest.mark.parametrize("command", commands())
def test_every_option_is_explained(command):
    for parameter in cli.main.commands[command].params:
        if parameter.param_type_name == "option":
            assert parameter.help, parameter.name


def test_help_lists_all_commands(cli_run):
    said = cli_run("--help")
    assert said.code in (0, None)
    for command in commands():
        assert f"\n  {command} " in said.out


def test_no_arguments_show_the_help(cli_run):
    said = cli_run()
    assert said.code in (0, 2)
    assert (
        "\n  flatland-scp " in said.out + said.err
    )  # as it is laid out, not squeezed into one line
    assert PREFIX not in said.err


def test_version(cli_run):
    assert cli_run("--version").out.strip().endswith("0.1.0")


# ---- errors: one line, exit code 2, nothing written ------------------------------------------------------------------------


@pytest.fixture
def files(tmp_path, tiny_config_file) -> dict[str, str]:
    """Some files to go wrong with."""
    (tmp_path / "broken.yaml").write_text("a: b: c\n")
    (tmp_path / "wrong.yaml").write_text("seed: -1\n")
    (tmp_path / "no-table.parquet").write_text("no table")
    (tmp_path / "folder").mkdir()
    return {"tiny": tiny_config_file, "default": str(DEFAULT)}


PART = "flatland-experiments-part --config {tiny} --world furnished --agent polyphemus --length 4 --part 1/2 --out out.parquet"

SCP = "flatland-scp --config {tiny} --out out.parquet --flatland-experiments"
ERRORS = {
    "dance": "No such command 'dance'",
    "--colour": "No such option",
    "check": "Missing argument 'FILES...'",
    "check gone.yaml": "gone.yaml: there is no such file",
    "check broken.yaml": "broken.yaml: not valid YAML in line 1",
    "check folder": "folder: cannot be read",
    "check {default} wrong.yaml": "config: seed:",
    "check wrong.yaml": "profile: this key is missing",
    "resolve wrong.yaml --out out.yaml": "profile: this key is missing",
    "resolve gone.yaml --out out.yaml": "gone.yaml: there is no such file",
    "resolve {default} --out folder": "is a directory",
    "resolve {default} --out broken.yaml/out.yaml": "check the path and its permissions",
    "resolve --out out.yaml": "Missing argument 'FILES...'",
    "resolve {default}": "Missing option '--out'",
    "schema --out gone/schema.json": "gone/schema.json: No such file or directory",
    PART.replace("1/2", "0/2"): "'0/2': I must lie between 1 and N",
    PART.replace("1/2", "3/2"): "'3/2': I must lie between 1 and N",
    PART.replace("1/2", "1"): "'1' is not of the form I/N, e.g. 1/4",
    PART.replace("1/2", "1/2/3"): "is not of the form I/N",
    PART.replace("1/2", "a/b"): "is not of the form I/N",
    PART.replace("1/2", "1/0"): "I must lie between",
    PART.replace("1/2", "-1/2"): "I must lie between",
    PART.replace("1/2", "1/1"): "the configuration cuts this work into 2 parts, not 1; give I/2",
    PART.replace("1/2", "1/9"): "not 9; give I/2",
    PART.replace(" --part 1/2", ""): "Missing option '--part'",
    PART.replace(
        "--agent polyphemus", "--agent nobody"
    ): "agent 'nobody', length 4; it has: furnished polyphemus 4; ",
    PART.replace("--length 4", "--length 5"): "length 5; it has: ",
    PART.replace("--length 4", "--length 0"): "0 is not in the range",
    PART.replace("--length 4", "--length x"): "'x' is not a valid integer",
    PART.replace("{tiny}", "gone.yaml"): "gone.yaml: there is no such file",
    PART.replace("out.parquet", "folder"): "'folder' is a directory",
    PART.replace("out.parquet", "broken.yaml/out.parquet"): "check the path and its permissions",
    SCP + " gone.parquet": "gone.parquet: there is no such table",
    SCP + " no-table.parquet": "no-table.parquet: not a readable Parquet file",
    SCP + " folder": "folder",
    "flatland-experiments --config {tiny} --out out.parquet": "Missing argument 'PARTS...'",
    "flatland-experiments --config {tiny} --out out.parquet gone.parquet": "gone.parquet: there is no such table",
    "flatland-commutation-part --config {tiny} --world nowhere --part 1/3 --out out.parquet": "choose one of furnished, settled",
    "flatland-commutation-part --config {tiny} --world settled --part 1/2 --out out.parquet": "into 3 parts, not 2; give I/3",
    "flatland-baselines-part --config {tiny} --dof knee --out out.parquet": "choose one of base-longitudinal, ",
    "figure --config {tiny} portrait --tables . --out out.png": "there is no figure 'portrait'; choose one of ",
    "paper-comparison --config {tiny} --tables folder --out out.parquet": "there is no such table",
}


@pytest.mark.parametrize("line", ERRORS, ids=lambda line: line.replace("--config {tiny} ", ""))
def test_an_error_is_one_line(cli_run, files, tmp_path, line):
    before = sorted(tmp_path.rglob("*"))
    said = cli_run(*(word.format(**files) for word in line.split()))
    assert said.code == 2
    assert not said.out
    assert said.err.startswith(PREFIX)
    assert said.err.count("\n") == 1 and said.err.endswith("\n")
    assert ERRORS[line].replace("{{", "{") in said.err
    assert sorted(tmp_path.rglob("*")) == before  # nothing was written


def test_a_usage_error_says_where_help_is(cli_run):
    assert cli_run("resolve").err.rstrip().endswith("(sensory-commutativity resolve --help)")


def test_an_error_of_ours_is_not_hidden(cli_run, monkeypatch, tiny_config_file):
    """What is not the user's to mend keeps its traceback."""

    def fail(*_):
        raise ZeroDivisionError

    monkeypatch.setattr(
        "sensory_commutativity.studies.flatland.tables.flatland_scp.write_scp", fail
    )
    with pytest.raises(ZeroDivisionError):
        cli_run(
            "flatland-scp",
            "--config",
            tiny_config_file,
            "--flatland-experiments",
            "x",
            "--out",
            "y",
        )


def test_results_that_cannot_be_written_are_noticed_by_check(cli_run, tmp_path):
    (tmp_path / "taken").write_text("x")
    (tmp_path / "mine.yaml").write_text("results: taken\n")
    said = cli_run("check", str(DEFAULT), "mine.yaml")
    assert said.code == 2
    assert "taken: is a file" in said.err and "'results'" in said.err


# ---- the program itself ----------------------------------------------------------------------------------------------------


def program(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [PROGRAM, *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        env={**os.environ, **environment},
    )


def test_the_installed_program_reports_errors_so():
    run = program("check", "gone.yaml")
    assert run.returncode == 2
    assert not run.stdout
    assert run.stderr.startswith(f"{PREFIX}gone.yaml: ")
    assert run.stderr.count("\n") == 1


def test_starting_up_imports_nothing_heavy():
    """torch and matplotlib take seconds, and most commands need neither."""
    code = (
        "import sys, sensory_commutativity.cli as cli; "
        "print([m for m in ('torch', 'matplotlib', 'numba', 'pymunk', 'statsmodels', 'snakemake') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert run.stdout.strip() == "[]", run.stderr


def test_one_thread_unless_told():
    code = "import os, sensory_commutativity.cli; print(os.environ['OMP_NUM_THREADS'], os.environ['MKL_NUM_THREADS'])"
    environment = {
        key: value for key, value in os.environ.items() if not key.endswith("_NUM_THREADS")
    }
    run = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env={**environment, "MKL_NUM_THREADS": "3"},
    )
    assert run.stdout.split() == ["1", "3"]


# ---- configuration ---------------------------------------------------------------------------------------------------------


def test_check_says_what_would_be_done(cli_run, monkeypatch):
    monkeypatch.chdir(ROOT)  # robots and scenes are named relative to it
    said = cli_run("check", str(DEFAULT), str(ROOT / "config" / "test.yaml"))
    assert said.code in (0, None)
    config = load(DEFAULT, ROOT / "config" / "test.yaml")
    n = sum(run.experiments for run in config.flatland.runs())
    assert (
        f"profile test: SC-experiments of each degree of freedom: {n:,} in {len(config.flatland.runs())} runs in Flatland"
        in said.out
    )
    assert f"in {len(config.apartment.runs())} runs in apartments" in said.out
    assert "results/test" in said.out


def test_resolve_is_a_round_trip(cli_run, tmp_path):
    out, again = tmp_path / "new" / "config.yaml", tmp_path / "again.yaml"
    (tmp_path / "mine.yaml").write_text(
        "profile: mine\nflatland: {agents: {giraffe: {arm_length: 120.0}}}\n"
    )
    assert cli_run("resolve", str(DEFAULT), "mine.yaml", "--out", str(out)).code in (0, None)
    assert load(out) == load(DEFAULT, "mine.yaml")
    written = yaml.safe_load(out.read_text())
    assert (
        written["flatland"]["agents"]["polyphemus"]["arm_length"] == 50.0
    )  # defaults are filled in
    assert written["flatland"]["agents"]["giraffe"]["arm_length"] == 120.0
    cli_run("resolve", str(out), "--out", str(again))
    assert again.read_bytes() == out.read_bytes()


def test_rooms_that_are_too_full_are_noticed_by_check(cli_run, tmp_path):
    (tmp_path / "mine.yaml").write_text(
        "flatland: {worlds: {furnished: {objects: 24, width: 200.0, height: 300.0, start_margin: 90.0}}}\n"
    )
    said = cli_run("check", str(DEFAULT), "mine.yaml")
    assert said.code == 2
    assert said.err.count("\n") == 1
    assert "flatland.worlds.furnished" in said.err and "no free place for thing" in said.err


def test_schema_writes_the_schema(cli_run, tmp_path):
    assert cli_run("schema", "--out", "schema.json").code in (0, None)
    assert json.loads((tmp_path / "schema.json").read_text()) == json.loads(
        json.dumps(json_schema())
    )


# ---- stages by hand --------------------------------------------------------------------------------------------------------


def test_parts_of_the_experiments_by_hand(cli_run, tmp_path, tiny_config, tiny_config_file):
    """Five experiments, three to a job: two parts; then the table, then its SCP."""
    where = [
        "--config",
        tiny_config_file,
        "--world",
        "furnished",
        "--agent",
        "polyphemus",
        "--length",
        "4",
    ]
    for part in (1, 2):
        said = cli_run(
            "flatland-experiments-part", *where, "--part", f"{part}/2", "--out", f"{part}.parquet"
        )
        assert said.code in (0, None), said.err
    assert cli_run(
        "flatland-experiments",
        "--config",
        tiny_config_file,
        "1.parquet",
        "2.parquet",
        "--out",
        "all.parquet",
    ).code in (0, None)
    frame = read_table("flatland_experiments", tmp_path / "all.parquet")
    expected = run_experiments(tiny_config, tiny_config.flatland.runs()[0], 0, 5)
    assert frame.equals(expected)
    assert frame["experiment"].unique().tolist() == [0, 1, 2, 3, 4]
    said = cli_run(
        "flatland-scp",
        "--config",
        tiny_config_file,
        "--flatland-experiments",
        "all.parquet",
        "--out",
        "scp.parquet",
    )
    assert said.code in (0, None)
    scp = read_table("flatland_scp", tmp_path / "scp.parquet")
    assert scp["dof"].unique().tolist() == DOFS
    assert (scp["n"] == 5).all()
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "1.parquet",
        "2.parquet",
        "all.parquet",
        "scp.parquet",
    ]  # no batches left


def test_jobs_of_another_size_give_the_same(cli_run, tmp_path, tiny_config, tiny_config_file):
    whole = tmp_path / "whole.yaml"
    whole.write_text(
        yaml.safe_dump(
            update_flatland(tiny_config, experiments_per_job=1000).model_dump(mode="json")
        )
    )
    parts = [
        (tiny_config_file, "1/3"),
        (tiny_config_file, "2/3"),
        (tiny_config_file, "3/3"),
        (str(whole), "1/1"),
    ]
    frames = []
    for i, (config, part) in enumerate(parts):
        said = cli_run(
            "flatland-commutation-part",
            "--config",
            config,
            "--world",
            "settled",
            "--part",
            part,
            "--out",
            f"{i}.parquet",
        )
        assert said.code in (0, None), said.err
        frames.append(read_table("flatland_commutation_experiments", tmp_path / f"{i}.parquet"))
    assert set(frames[3]["world"]) == {"settled"}
    assert pd.concat(frames[:3], ignore_index=True).equals(frames[3])

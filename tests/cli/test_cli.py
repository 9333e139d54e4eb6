"""The command line: help, lists of names, errors of one line, and work done by hand."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import click
import pytest
import yaml
from PIL import Image

from sensory_commutativity import cli
from sensory_commutativity.errors import UserError
from sensory_commutativity.studies import runner
from sensory_commutativity.studies.declarations import Animation, Arrays, Figure, Model, Table
from sensory_commutativity.studies.flatland.tables.flatland_experiments import flatland_experiments
from sensory_commutativity.studies.flatland.tables.flatland_scp import flatland_scp
from sensory_commutativity.studies.loading import json_schema, load
from sensory_commutativity.studies.registry import declarations
from tests.helpers import DEFAULT, DOFS, ROOT, update_flatland
from tests.studies.examples import write_shards

PROGRAM = str(Path(sys.executable).parent / "sensory-commutativity")
PREFIX = "sensory-commutativity: error: "
KINDS = {"table": Table, "arrays": Arrays, "train": Model, "figure": Figure,
         "animation": Animation}  # fmt: skip


class Result(NamedTuple):
    """Exit code and output of a command."""

    code: int
    out: str
    err: str


@pytest.fixture
def run(monkeypatch, capsys, tmp_path) -> Callable[..., Result]:
    """Runs a command in this process, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    # so that click takes the name of the program from sys.argv
    monkeypatch.setattr(sys.modules["__main__"], "__package__", None)

    def run(*arguments) -> Result:
        monkeypatch.setattr(sys, "argv", [PROGRAM, *map(str, arguments)])
        code = 0
        try:
            cli.entry_point()
        except SystemExit as error:
            code = int(error.code or 0)
        return Result(code, *capsys.readouterr())

    return run


@pytest.fixture
def in_repository(monkeypatch) -> None:
    """Descriptions of robots and apartments are named relative to the repository."""
    monkeypatch.chdir(ROOT)


def walk(command: click.Command, path: tuple[str, ...] = ()) -> Iterator[tuple]:
    """All commands: their words, and the command."""
    yield path, command
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            child = command.get_command(context, name)
            assert child is not None
            yield from walk(child, (*path, name))


# ---- help -------------------------------------------------------------------------------------


def test_every_command_explains_itself_within_80_columns(run):
    people = {"measure", "check", "predict", "robot"}
    assert set(cli.COMMANDS) == {*KINDS, *people, "config", "run"}
    for path, command in walk(cli.main):
        for flag in ("--help", "-h"):
            result = run(*path, flag)
            assert result.code == 0 and not result.err, path
            assert result.out.startswith(" ".join(("Usage: sensory-commutativity", *path)))
            lines = result.out.splitlines()
            assert max(map(len, lines)) <= 80, path
            listed = lines[lines.index("Commands:") :] if "Commands:" in lines else []
            cut = [line for line in listed if line.endswith("...")]
            assert not cut, f"{path}: cut off: {cut}"
        assert command.help and command.help.split()[0] in result.out, path
        for parameter in command.params:
            if isinstance(parameter, click.Option):
                assert parameter.help, f"{path}: {parameter.name} has no help"


def test_the_program_alone_shows_its_help_and_its_version(run):
    result = run()
    assert result.code == 2 and PREFIX not in result.err
    assert "\n  table " in result.err  # as it is laid out, not as one line
    assert run("--version").out.strip().endswith("0.1.0")


def test_every_kind_lists_its_names_and_titles(run):
    for command, kind in KINDS.items():
        result = run(command, "--list")
        assert result.code == 0
        names = [line.split(maxsplit=1) for line in result.out.splitlines()]
        expected = [
            [name, product.title] for name, product in declarations(kind, optional=True).items()
        ]
        assert names == expected


def test_the_list_of_commands_says_what_their_help_says(run):
    for name, (_, text) in cli.COMMANDS.items():
        first = " ".join(run(name, "--help").out.split("\n\n")[1].split())
        assert text.rstrip(".").split()[0] == first.split()[0], name


# ---- measuring --------------------------------------------------------------------------------

OWN_WORLD = """
from sensory_commutativity import Corridor

def corridor(wall=2):
    return Corridor(wall)

class Broken(Corridor):
    def restore(self, snapshot):
        pass
"""


def test_a_world_is_measured_saved_drawn_and_resumed(run, tmp_path):
    command = ("measure", "corridor", "--length", "5", "--out", "scp.parquet", "--threshold", "0",
               "--threshold", "2", "--plot", "scp.png")  # fmt: skip
    first = run(*command, "-n", "30")
    assert first.code == 0 and not first.err
    assert first.out.startswith("SCP of Corridor: 30 starts")
    assert "lowest to highest SCP" in first.out and "written: scp.parquet, scp.png" in first.out
    assert (tmp_path / "scp.png").read_bytes().startswith(b"\x89PNG")
    more = run(*command, "-n", "60")
    alone = run("measure", "corridor", "--length", "5", "-n", "60", "--threshold", "0",
                "--threshold", "2")  # fmt: skip
    assert more.out.splitlines()[:5] == alone.out.splitlines()[:5]


def test_worlds_of_one_s_own_are_measured_and_checked(run, tmp_path):
    (tmp_path / "own.py").write_text(OWN_WORLD)
    result = run("measure", "own.py:corridor", "-n", "10", "-o", "wall=3")
    assert result.code == 0 and "SCP of Corridor: 10 starts" in result.out
    assert run("check", "own.py:corridor").code == 0
    broken = run("check", "own.py:Broken", "--tries", "3")
    assert broken.code == 1 and "FAILED" in broken.out and "restore" in broken.out
    assert "has no corider; did you mean corridor?" in run("measure", "own.py:corider").err
    assert "boxes" in run("measure", "own.py:corridor", "-o", "boxes=3").err


def test_environments_and_robots_are_measured(run):
    assert "action-0" in run("measure", "Pendulum-v1", "-n", "2", "--length", "5").out
    fetch = run("measure", "--robot", "fetch", "--scene", "free-space", "-n", "1", "--length", "2",
                "-o", "image_size=32")  # fmt: skip
    assert fetch.code == 0 and "shoulder-pan" in fetch.out
    assert "worlds: corridor, flatland" in run("measure", "--list").out


def test_a_robot_of_one_s_own_needs_no_yaml_edited(run, tmp_path):
    husky = "package://pybullet_data/husky/husky.urdf"
    result = run("robot", "init", husky, "--out", "mine.yaml")
    assert result.code == 0 and "2 degrees of freedom" in result.out
    assert run("robot", "init", husky, "--out", "mine.yaml").code == 2  # it exists
    assert run("robot", "init", husky, "--out", "mine.yaml", "--force").code == 0
    result = run("robot", "check", "mine.yaml", "--draw", "mine.png", "-n", "1")
    assert result.code == 0 and "100%" in result.out, result
    assert Image.open(tmp_path / "mine.png").width > 800
    result = run("measure", "--robot", "mine.yaml", "--scene", "free-space", "-n", "1", "--length",
                 "2", "-o", "image_size=32")  # fmt: skip
    assert result.code == 0 and "rear-left-wheel" in result.out and not result.err
    assert run("robot", "check", "mine.yaml", "--draw", "mine.png").code == 2  # it exists


def test_verbose_shows_where_an_error_arose(run):
    assert run("measure", "corridr").code == 2
    with pytest.raises(UserError):
        run("-v", "measure", "corridr")


def test_the_default_profile_of_the_package_is_checked(run):
    result = run("config", "check")
    assert result.code == 0 and result.out.startswith("profile default:")


# ---- errors -----------------------------------------------------------------------------------

SHARD = "table flatland_experiments --config {tiny} --out out.parquet --shard "
SCP = "table flatland_scp --config {tiny} --out out.parquet "
ERRORS = {
    "dance": "No such command 'dance'",
    "--colour": "No such option",
    "config dance": "No such command 'dance'",
    "config resolve": "Missing argument 'FILES...'",
    "measure": "give a WORLD, or a --robot; --list shows all names",
    "measure corridr": "did you mean the world corridor?",
    "measure CartPole-v1": "env: CartPole-v1 has actions in Discrete(2)",
    "measure corridor -n 0": "n: expected a whole number, at least 1; got 0",
    "measure corridor --distance msd": "did you mean 'mse'?",
    "measure corridor --plot scp.doc": "--plot scp.doc: expected a name that ends in .png",
    "measure corridor -o box": "-o box: expected KEY=VALUE",
    "measure corridor -o boxes=1": "no option 'boxes'; it has wall, box",
    "measure corridor --robot fetch": "--robot and --scene belong to the world apartment",
    "measure --robot fetsh": "there is no robot 'fetsh'; choose one of allegro-hand, fetch",
    "measure own.py:World": "own.py: there is no such file",
    "check os:nothing": "os: has no nothing",
    "check nowhere.at.all:World": "there is no such module",
    "config check gone.yaml": "gone.yaml: there is no such file",
    "config check broken.yaml": "broken.yaml: not valid YAML in line 1",
    "config check folder": "folder: cannot be read",
    "config check {default} wrong.yaml": "config: seed:",
    "config check wrong.yaml": "profile: this key is missing",
    "config check {default} taken.yaml": "broken.yaml: is a file, so results cannot go to",
    "config check {default} crowded.yaml": "flatland.worlds.furnished with flatland.agents.",
    "config resolve wrong.yaml --out out.yaml": "profile: this key is missing",
    "config resolve {default} --out folder": "is a directory",
    "config resolve {default} --out broken.yaml/out.yaml": "check the path and its permissions",
    "config resolve --out out.yaml": "Missing argument 'FILES...'",
    "config resolve {default}": "Missing option '--out'",
    "config schema --out gone/schema.json": "gone/schema.json: No such file or directory",
    "config check-start --config {tiny} --robot fetch --scene rs-stand-in --out x.json":
        "Missing option '--start'",
    "config check-start --config {tiny} --robot fetch --scene attic --start anywhere --out x.json":
        "the configuration has no run of robot 'fetch' in scene 'attic', start 'anywhere'",
    "config check-start --robot fetch --scene rs-stand-in --start anywhere --out x.json":
        "give the configuration of the run with --config",
    "table": "give a NAME; --list shows all names (see sensory-commutativity table --help)",
    "table flatland_spc": "there is no table 'flatland_spc'; did you mean flatland_scp",
    "arrays mask_pear": "there is no arrays 'mask_pear'; did you mean mask_pairs",
    "train navigation": "there is no model 'navigation'; did you mean navigation_policy",
    "figure portrait": "there is no figure 'portrait'; the option --list shows all names",
    "table flatland_scp": "give the configuration of the run with --config",
    "table flatland_scp --config gone.yaml": "gone.yaml: there is no such file",
    "table flatland_scp --config {tiny} --shard a.1-of-1": "flatland_scp has no shards; leave out",
    "table flatland_commutation_experiments --config {tiny}": "is computed per shard; give --shard",
    "arrays mask_pairs --config {tiny}": "mask_pairs is computed per shard; give --shard",
    "train mask_training --config {tiny}": "mask_training is computed per run; give --run",
    "train mask_training --config {tiny} --run alexnet":
        "has no shard 'alexnet'; it has 2: raft, flownet",
    "figure flatland_scp --config {tiny} --shard a": "No such option",
    SHARD + "furnished.polyphemus.4.1-of-9":
        "no shard 'furnished.polyphemus.4.1-of-9'; it has 17: furnished.polyphemus.4.1-of-2, ",
    SHARD + "furnished.nobody.4.1-of-1": "no shard 'furnished.nobody.4.1-of-1'",
    SHARD.replace("out.parquet", "folder") + "furnished.polyphemus.4.1-of-2": "is a directory",
    SHARD.replace("out.parquet", "broken.yaml/out.parquet") + "furnished.polyphemus.4.1-of-2":
        "check the path and its permissions",
    SHARD + "furnished.polyphemus.4.1-of-2 wrong.yaml": "wrong.yaml: is no input of flatland_exp",
    SCP: "results/default/tables/flatland_experiments.parquet: there is no such table; run the",
    SCP + "gone.parquet": "gone.parquet: is no input of flatland_scp; leave it out",
    SCP + "folder/flatland_experiments.parquet": "flatland_experiments.parquet: not a readable",
    SCP + "gone/flatland_experiments.parquet": "flatland_experiments.parquet: there is no such",
    "table flatland_experiments --config {tiny}": "polyphemus.4.1-of-2.parquet: there is no such",
    "predict a.png b.png": "a.png: there is no such file",
    "robot init": "Missing argument 'URDF'",
    "robot init gone.urdf": "gone.urdf: the file does not exist",
    "robot init package://pybullet_data/gone.urdf": "the file does not exist",
    "robot init broken.yaml --out a.yaml": "not valid XML in line 1",
    "robot init broken.yaml": "broken.yaml: is the URDF itself; choose another --out",
    "robot init package://pybullet_data/plane.urdf": "are these millimetres?",
    "robot init package://pybullet_data/cube.urdf": "no joint of it can move",
    "robot check gone.yaml": "gone.yaml: there is no such file",
    "robot check broken.yaml --draw a.doc": "expected a name that ends in .png",
    "robot check broken.yaml": "broken.yaml: not valid YAML",
    "run compare gone folder": "'gone' does not exist",
    "run provenance gone.parquet": "gone.parquet: there is no such file",
}  # fmt: skip


def test_an_error_is_one_line_and_nothing_is_written(run, tmp_path, tiny_config_file):
    (tmp_path / "broken.yaml").write_text("a: b: c\n")
    (tmp_path / "wrong.yaml").write_text("seed: -1\n")
    (tmp_path / "taken.yaml").write_text("results: broken.yaml\n")
    room = "{objects: 24, width: 200.0, height: 300.0, start_margin: 90.0}"
    (tmp_path / "crowded.yaml").write_text(f"flatland: {{worlds: {{furnished: {room}}}}}\n")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "flatland_experiments.parquet").write_text("no table")
    (tmp_path / "config").symlink_to(ROOT / "config")
    before = sorted(tmp_path.rglob("*"))
    for line, message in ERRORS.items():
        words = line.format(tiny=tiny_config_file, default=DEFAULT).split()
        result = run(*words)
        assert result.code == 2 and not result.out, line
        assert result.err.startswith(PREFIX), line
        assert result.err.count("\n") == 1 and result.err.endswith("\n"), line
        assert message in result.err, f"{line}: {result.err}"
        assert sorted(tmp_path.rglob("*")) == before, line


def test_errors_of_the_program_itself_keep_their_traceback(run, monkeypatch, tiny_config_file):
    def fail(*_):
        raise ZeroDivisionError

    monkeypatch.setattr(runner, "write_product", fail)
    with pytest.raises(ZeroDivisionError):
        run("table", "flatland_scp", "--config", tiny_config_file)


# ---- the installed program --------------------------------------------------------------------


def test_the_installed_program_reports_errors_in_the_same_way():
    command = [PROGRAM, "config", "check", "gone.yaml"]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert result.returncode == 2 and not result.stdout
    assert result.stderr.startswith(f"{PREFIX}gone.yaml: ") and result.stderr.count("\n") == 1


def test_starting_up_imports_nothing_heavy_and_uses_one_thread():
    """torch and matplotlib take seconds to import, and most commands need neither."""
    heavy = ("torch", "matplotlib", "numba", "pymunk", "pybullet", "statsmodels", "snakemake")
    code = (
        "import os, sys, sensory_commutativity.cli as cli; "
        f"print([m for m in {heavy} if m in sys.modules], "
        "os.environ['OMP_NUM_THREADS'], os.environ['MKL_NUM_THREADS'])"
    )
    environment = {k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")}
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                            timeout=60, env={**environment, "MKL_NUM_THREADS": "3"})  # fmt: skip
    assert result.stdout.strip() == "[] 1 3", result.stderr


# ---- configuration ----------------------------------------------------------------------------


def test_check_says_what_would_be_done(run, in_repository):
    files = [DEFAULT, ROOT / "config" / "test.yaml"]
    result, config = run("config", "check", *files), load(*files)
    assert result.code == 0, result.err
    runs = config.flatland.runs()
    n = sum(run.experiments for run in runs)
    assert "profile test: " in result.out and "results go to results/test" in result.out
    assert f"{n:,} in {len(runs)} runs in Flatland" in result.out
    assert f"in {len(config.apartment.runs())} runs in apartments" in result.out


def test_resolve_fills_in_defaults_and_can_be_repeated(run, tmp_path):
    out, again = tmp_path / "new" / "config.yaml", tmp_path / "again.yaml"
    mine = tmp_path / "mine.yaml"
    mine.write_text("profile: mine\nflatland: {agents: {giraffe: {arm_length: 120.0}}}\n")
    assert run("config", "resolve", DEFAULT, mine, "--out", out).code == 0
    assert load(out) == load(DEFAULT, mine)
    agents = yaml.safe_load(out.read_text())["flatland"]["agents"]
    assert agents["polyphemus"]["arm_length"] == 50.0 and agents["giraffe"]["arm_length"] == 120.0
    run("config", "resolve", out, "--out", again)
    assert again.read_bytes() == out.read_bytes()


def test_schema_is_that_of_the_configuration(run, tmp_path):
    assert run("config", "schema", "--out", "schema.json").code == 0
    assert json.loads((tmp_path / "schema.json").read_text()) == json_schema()


# ---- work by hand -----------------------------------------------------------------------------


def test_shards_table_and_what_is_computed_from_it(run, tmp_path, tiny_config):
    """In the folder of the run by default, or wherever the files are."""
    config = tmp_path / "tiny.yaml"
    one_run = {section: {"worlds": ["free-space"], "agents": ["polyphemus"]}
               for section in ("free_space",)}  # fmt: skip
    tiny = update_flatland(tiny_config, **one_run)
    config.write_text(yaml.safe_dump(tiny.model_dump(mode="json")))
    shards = [shard.name for shard in flatland_experiments.shards.all(tiny)]
    for name in shards:
        result = run("table", "flatland_experiments", "--config", config, "--shard", name)
        assert result.code == 0 and not result.out + result.err
    folder = tmp_path / "results" / "default"
    assert sorted(path.name for path in (folder / "data" / "flatland_experiments").iterdir()) == (
        sorted(f"{name}.parquet" for name in shards)
    )
    assert run("table", "flatland_experiments", "--config", config).code == 0
    assert run("table", "flatland_scp", "--config", config).code == 0
    source, table = (folder / "tables" / f"{name}.parquet"
                     for name in ("flatland_experiments", "flatland_scp"))  # fmt: skip
    experiments = runner.read_product(flatland_experiments, tiny, source)
    paths = write_shards(flatland_experiments, tiny, tmp_path / "again", "furnished.polyphemus.4")
    expected = runner.read_shards(flatland_experiments, tiny, paths)[0]
    assert experiments[: len(expected)].equals(expected)
    scp = runner.read_product(flatland_scp, tiny, table)
    assert scp["dof"].unique().tolist() == DOFS
    first = table.read_bytes()
    moved = tmp_path / "elsewhere" / source.name
    moved.parent.mkdir()
    source.rename(moved)
    result = run("table", "flatland_scp", moved, "--config", config, "--out", "scp.parquet")
    assert result.code == 0, result.err
    assert (tmp_path / "scp.parquet").read_bytes() == first

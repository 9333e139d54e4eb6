"""Settings reach shells and paths as text: whatever they hold, they are refused or quoted. Nothing
is executed, and nothing is written outside the results."""

from __future__ import annotations

import re
import shlex
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from .running import BIN, copy_workflow, run

HOSTILE = 'it\'s "mine"; touch pwned $(touch pwned) `touch pwned` & touch pwned | $HOME \\ #'
"""The name of a folder that a careless workflow would execute."""


def run_with_layer(
    folder: Path, layer: dict[str, Any], *arguments: str
) -> subprocess.CompletedProcess[str]:
    """Snakemake on the test profile with a further configuration file."""
    (folder / "layer.yaml").write_text(yaml.safe_dump(layer))
    profile = ["--configfile", "config/test.yaml", "layer.yaml"]
    return run([BIN / "snakemake", *profile, *arguments], folder)


def remove_quoted(line: str) -> str:
    """What of a shell command is outside quotes, as shlex.quote writes them."""
    return re.sub(r"'[^']*'", "", line.replace("'\"'\"'", ""))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copy_workflow(tmp_path_factory.mktemp("hostile"))


@pytest.fixture(autouse=True)
def nothing_is_executed(folder: Path) -> Iterator[None]:
    yield
    assert not list(folder.rglob("pwned"))


def test_every_output_is_below_the_results(folder: Path) -> None:
    result = run_with_layer(folder, {"results": HOSTILE}, "--summary", "--dry-run")
    assert result.returncode == 0, result.stderr
    outputs = [line.split("\t")[0] for line in result.stdout.splitlines() if "\t" in line][1:]
    assert len(outputs) > 100
    for output in outputs:
        assert output.startswith(f"{HOSTILE}/test/") and ".." not in Path(output).parts


def test_every_command_quotes(folder: Path) -> None:
    result = run_with_layer(folder, {"results": HOSTILE}, "--printshellcmds", "--dry-run")
    assert result.returncode == 0, result.stderr
    prefix = "Shell command: "
    lines = [
        line.removeprefix(prefix)
        for line in result.stdout.splitlines()
        if line.startswith(prefix) and not line.endswith(": None")
    ]
    assert len(lines) > 100
    for line in lines:
        assert not set("$`;&|\"#\\'") & set(remove_quoted(line)), line
        words = shlex.split(line)
        assert words[0] == "sensory-commutativity"
        hostile = [word for word in words if "pwned" in word]
        assert hostile and all(word.startswith(f"{HOSTILE}/test") for word in hostile), line


def test_hostile_settings_are_refused_before_any_job(folder: Path) -> None:
    robot = {"fetch": {"description": "`touch pwned`\n; touch pwned"}}
    scene = {"rs-stand-in": {"file": "{touch pwned} $(touch pwned)"}}
    for layer, name in (
        ({"profile": "$(touch pwned)"}, "profile"),
        ({"results": "a/../../b; touch pwned"}, "results"),
        ({"results": "{touch} pwned"}, "results"),
        ({"apartment": {"robots": robot}}, "touch pwned"),
        ({"apartment": {"scenes": scene}}, "touch pwned"),
        ({"apartment": {"weights": "'; touch pwned; '"}}, "apartment.weights"),
        ({"masks": {"map": {"cramped_room": "$(touch pwned)"}}}, "masks.map.cramped_room"),
    ):
        result = run_with_layer(folder, layer, "--dry-run")
        assert result.returncode == 2, result.stderr
        messages = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
        assert len(messages) == 1 and name in messages[0], layer


def test_repeated_keys_are_refused(folder: Path) -> None:
    (folder / "twice.yaml").write_text("seed: 1\nseed: 2\n")
    profile = ["--configfile", "config/test.yaml", "twice.yaml"]
    result = run([BIN / "snakemake", *profile, "--dry-run"], folder)
    assert result.returncode == 2, result.stderr
    assert "error: " in result.stderr and "'seed'" in result.stderr


def test_hostile_paths_work(folder: Path) -> None:
    """One job: the description of a robot and the results at paths with spaces, quotes and
    commands in them."""
    robots = folder / "own robot's $(touch pwned)"
    robots.mkdir()
    for name in ("jackrabbot.yaml", "jackrabbot.urdf"):
        (robots / name).write_bytes((folder / "config" / "robots" / name).read_bytes())
    robot = {"jackrabbot": {"description": f"{robots.name}/jackrabbot.yaml"}}
    layer = {"results": HOSTILE, "apartment": {"robots": robot}}
    shard = f"{HOSTILE}/test/data/flatland_experiments/free-space.polyphemus.50.1-of-1.parquet"
    result = run_with_layer(
        folder, layer, "--cores", "1", "--until", "flatland_experiments_shard", "--", shard
    )
    assert result.returncode == 0, result.stderr
    assert (folder / shard).is_file() and (folder / HOSTILE / "test" / "config.yaml").is_file()
    own = {"workflow", "config", "profiles", ".snakemake", "layer.yaml", "twice.yaml"}
    assert {path for path in folder.iterdir() if path.name not in own} == {folder / HOSTILE, robots}

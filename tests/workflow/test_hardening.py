"""Settings reach shells and paths as text: whatever they hold, they are refused, or quoted; nothing is executed, nothing lies outside the results."""

from __future__ import annotations

import re
import shlex
import subprocess
from pathlib import Path

import pytest
import yaml
from sensory_commutativity.running import ENVIRONMENT, command, copy_workflow

HOSTILE = 'it\'s "mine"; touch pwned $(touch pwned) `touch pwned` & touch pwned | $HOME \\ #'
"""A folder's name that a careless workflow would execute."""


def laid_over(folder: Path, layer: dict, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Snakemake on the test profile with another layer."""
    (folder / "layer.yaml").write_text(yaml.safe_dump(layer))
    line = [*command()[:3], "layer.yaml", *arguments]
    return subprocess.run(
        line, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=1200
    )


def unquoted(line: str) -> str:
    """What of a shell command stands outside of quotes, as shlex.quote writes them."""
    return re.sub(r"'[^']*'", "", line.replace("'\"'\"'", ""))


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return copy_workflow(tmp_path_factory.mktemp("hostile"))


@pytest.fixture(autouse=True)
def nothing_is_executed(folder: Path):
    yield
    assert not list(folder.rglob("pwned"))


def test_every_output_lies_below_the_results(folder):
    run = laid_over(folder, {"results": HOSTILE}, "--summary", "--dry-run")
    assert run.returncode == 0, run.stderr
    outputs = [line.split("\t")[0] for line in run.stdout.splitlines() if "\t" in line][1:]
    assert len(outputs) > 100
    for output in outputs:
        assert output.startswith(f"{HOSTILE}/test/") and ".." not in Path(output).parts


def test_every_command_quotes(folder):
    run = laid_over(folder, {"results": HOSTILE}, "--printshellcmds", "--dry-run")
    assert run.returncode == 0, run.stderr
    lines = [
        line.removeprefix("Shell command: ")
        for line in run.stdout.splitlines()
        if line.startswith("Shell command: ") and not line.endswith(": None")
    ]
    assert len(lines) > 100
    for line in lines:
        assert not set("$`;&|\"#\\'") & set(unquoted(line)), line
        words = shlex.split(line)
        assert words[0] == "sensory-commutativity"
        hostile = [word for word in words if "pwned" in word]
        assert hostile and all(word.startswith(f"{HOSTILE}/test") for word in hostile), line


@pytest.mark.parametrize(
    ("layer", "names"),
    [
        ({"profile": "$(touch pwned)"}, "profile"),
        ({"results": "a/../../b; touch pwned"}, "results"),
        ({"results": "{touch} pwned"}, "results"),
        (
            {"apartment": {"robots": {"fetch": {"description": "`touch pwned`\n; touch pwned"}}}},
            "touch pwned",
        ),
        (
            {"apartment": {"scenes": {"rs-stand-in": {"file": "{touch pwned} $(touch pwned)"}}}},
            "touch pwned",
        ),
        ({"apartment": {"weights": "'; touch pwned; '"}}, "apartment.weights"),
        ({"masks": {"map": {"cramped_room": "$(touch pwned)"}}}, "masks.map.cramped_room"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else None,
)
def test_what_cannot_be_is_refused_before_any_job(folder, layer, names):
    run = laid_over(folder, layer, "--dry-run")
    assert run.returncode == 2, run.stderr
    told = [line for line in run.stderr.splitlines() if line.startswith("error: ")]
    assert len(told) == 1 and names in told[0]


def test_a_key_that_is_there_twice_is_refused_by_the_workflow_too(folder):
    (folder / "twice.yaml").write_text("seed: 1\nseed: 2\n")
    line = [*command()[:3], "twice.yaml", "--dry-run"]
    run = subprocess.run(
        line, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=300
    )
    assert run.returncode == 2, run.stderr
    assert "error: " in run.stderr and "the key 'seed' is already in line 1" in run.stderr


def test_files_with_strange_names_and_results_in_a_strange_folder_work(folder):
    """One job, for real: with a robot's description and results at paths with spaces, quotes and commands in them."""
    strange = folder / "own robot's $(touch pwned)"
    strange.mkdir()
    for name in ("jackrabbot.yaml", "jackrabbot.urdf"):
        (strange / name).write_bytes((folder / "config" / "robots" / name).read_bytes())
    layer = {
        "results": HOSTILE,
        "apartment": {"robots": {"jackrabbot": {"description": f"{strange.name}/jackrabbot.yaml"}}},
    }
    made = f"{HOSTILE}/test/data/flatland_experiments/free-space.polyphemus.50.1-of-1.parquet"
    run = laid_over(
        folder, layer, "--cores", "1", "--until", "flatland_experiments_part", "--", made
    )
    assert run.returncode == 0, run.stderr
    assert (folder / made).is_file() and (folder / HOSTILE / "test" / "config.yaml").is_file()
    results = {
        path
        for path in folder.iterdir()
        if path.name
        not in ("Snakefile", "workflow", "config", ".snakemake", "layer.yaml", "twice.yaml")
    }
    assert results == {folder / HOSTILE, strange}

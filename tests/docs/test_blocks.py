"""Every block of code in README and docs runs, or says in a comment before it why it is not run.

A block of Python runs in an empty folder, after the blocks before it on its page; commands run in
a folder with the configuration and the committed tables.
"""

from __future__ import annotations

import itertools
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import click
import matplotlib.pyplot as plt
import pytest
import yaml

from sensory_commutativity.cli import main
from sensory_commutativity.studies.loading import load
from tests.docs.blocks import BLOCKS, PAGES, Block
from tests.helpers import DEFAULT, ROOT

RUN = [block for block in BLOCKS if block.reason is None]
MAKE_TARGETS = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)


def named(language: str) -> list[Block]:
    return [block for block in RUN if block.language == language]


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what the commands of the docs read."""
    folder = tmp_path_factory.mktemp("clone")
    shutil.copytree(ROOT / "config", folder / "config")
    shutil.copytree(ROOT / "results" / "paper" / "tables", folder / "results" / "paper" / "tables")
    shutil.copy(ROOT / "results" / "paper" / "config.yaml", folder / "results" / "paper")
    return folder


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_python_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "docs"}
    for block in named("python"):
        if block.page == str(page.relative_to(ROOT)):
            exec(compile("\n" * block.line + block.code, block.page, "exec"), names)
    plt.close("all")


@pytest.mark.parametrize("block", named("bash"), ids=lambda block: block.name)
def test_commands_run(block: Block, folder: Path) -> None:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    run = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", block.code],
        cwd=folder, capture_output=True, text=True, env={**os.environ, "PATH": path}, timeout=120,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize("block", named("yaml"), ids=lambda block: block.name)
def test_configurations_are_valid(block: Block, tmp_path: Path) -> None:
    content = yaml.safe_load(block.code)
    if "profile" in content:
        (tmp_path / "mine.yaml").write_text(block.code)
        load(DEFAULT, tmp_path / "mine.yaml")


def test_no_other_kind_of_block() -> None:
    kinds = {"bash", "python", "text", "yaml"}
    assert {block.language for block in BLOCKS} <= kinds
    for page in PAGES:  # an indented block would be run by no test
        lines = re.sub(r"^```\w+\n.*?^```", "", page.read_text(), flags=re.M | re.S).splitlines()
        assert not any(line.startswith("```") for line in lines), f"{page.name}: name the language"
        for before, line in itertools.pairwise(lines):
            indented = line.startswith("    ") and not before.strip()
            assert not indented, f"{page.name}: {line!r}: fence it"


def test_a_block_that_is_not_run_has_a_reason() -> None:
    for block in BLOCKS:
        assert block.reason is None or len(block.reason.split()) > 2, block.name


def command_lines() -> list[tuple[str, str]]:
    """Page and line of every `sencom` and `make` that blocks or the text itself name."""
    found = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        lines = [line for block in BLOCKS if block.language == "bash" and page.name in block.page
                 for line in block.code.splitlines()]  # fmt: skip
        lines += re.findall(r"`((?:sencom|sensory-commutativity|make) [^`]*)`", text)
        found += [(page.name, line.split(" # ")[0].strip()) for line in lines]
    return [(page, line) for page, line in found if re.match("sencom|sensory-commut|make ", line)]


@pytest.mark.parametrize(("page", "line"), sorted(set(command_lines())))
def test_commands_exist(page: str, line: str) -> None:
    """Commands that are named, run or not: the command, its options, the target of make."""
    words = shlex.split(line.split(" && ")[0], comments=True)
    if words[0] == "make":
        for target in words[1:]:
            assert target in MAKE_TARGETS or target.startswith(".venv"), line
        return
    command: click.Command = main
    context = click.Context(command)
    for word in words[1:]:
        if isinstance(command, click.Group) and not word.startswith("-"):
            if word.isupper():
                return  # a placeholder
            found = command.get_command(context, word)
            assert found is not None, f"{line}: no command {word!r}"
            command = found
        elif word.startswith("-") and len(word) > 1 and not word[1].isdigit():
            options = [option for one in command.get_params(context) for option in one.opts]
            assert word.split("=")[0] in options, f"{line}: no option {word!r}"

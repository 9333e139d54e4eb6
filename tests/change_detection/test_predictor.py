"""Predictors: what they take, their files, and files that are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from sensory_commutativity.change_detection.decision import DecisionThresholds
from sensory_commutativity.change_detection.models.flownet import MaskFlowNet
from sensory_commutativity.change_detection.models.raft import MaskRaft
from sensory_commutativity.change_detection.models.view_classifier import ViewClassifier
from sensory_commutativity.change_detection.predictor import (
    FORMAT,
    MaskPredictor,
    PredictorError,
    check_pictures,
    load_predictor,
)
from sensory_commutativity.storage.checkpoints import CheckpointError, load_state, save_state
from tests.change_detection.examples import SMALL, SMALL_RAFT, make_pairs

THRESHOLDS = DecisionThresholds(0.4, 0.6, 8.0)


def save_small(path: Path, name: str) -> MaskPredictor:
    torch.manual_seed(0)
    model = {"raft": MaskRaft, "flownet": MaskFlowNet}[name](**SMALL[name])
    predictor = MaskPredictor(name, model, THRESHOLDS, view_classifier=ViewClassifier(4))
    predictor.save(path, {"seed": "1"})
    return predictor


def weights_of(predictor: MaskPredictor) -> dict[str, torch.Tensor]:
    networks = {"model": predictor.model, "view_classifier": predictor.view_classifier}
    return {
        f"{key}.{name}": value
        for key, network in networks.items()
        for name, value in network.state_dict().items()
    }


def test_a_predictor_is_read_as_it_was_saved_up_to_half_precision(tmp_path):
    path = tmp_path / "raft.predictor"
    saved, loaded = save_small(path, "raft"), load_predictor(path, "raft")
    assert loaded.thresholds == THRESHOLDS
    assert load_state(path, "")["about"] == {"seed": "1"}
    expected, weights = weights_of(saved), weights_of(loaded)
    assert expected.keys() == weights.keys()
    for name, value in expected.items():
        assert torch.equal(weights[name], value.half().float().to(value.dtype)), name
    pictures = make_pairs(3).pictures
    probabilities = loaded.predict_proba(pictures)
    assert probabilities.shape == (3, 2, 128, 128) and probabilities.dtype == np.float32
    assert 0 <= probabilities.min() <= probabilities.max() <= 1
    one_by_one = loaded.predict_proba(pictures, batch_size=1)
    assert np.array_equal(load_predictor(path).predict_proba(pictures, batch_size=1), one_by_one)
    assert np.allclose(one_by_one, probabilities, atol=1e-4)

    path = tmp_path / "difference.predictor"  # the image difference has thresholds alone
    MaskPredictor("difference", None, DecisionThresholds(0.3, 0.5, 12.0)).save(path, {})
    loaded = load_predictor(path, "difference")
    assert loaded.thresholds == DecisionThresholds(0.3, 0.5, 12.0)
    assert loaded.predict(*pictures[0]).outcome == "identical"


def test_files_of_format_4_can_still_be_read(tmp_path):
    old_names = {
        "thresholds": "rule",
        "view_classifier": "judge",
        "quarter_channels": "fine",
        "half_channels": "sharp",
        "upsample_logits": "rise",
        "classifier": "verdict",
    }

    def rename(names: dict) -> dict:
        """The same mapping, with the names of format 4 at the beginning of its keys."""
        parts = [(*key.partition("."), value) for key, value in names.items()]
        return {old_names.get(name, name) + dot + rest: value for name, dot, rest, value in parts}

    for name in SMALL:
        path, old_path = tmp_path / f"{name}.predictor", tmp_path / f"{name}-4.predictor"
        save_small(path, name)
        state = rename(load_state(path, "")) | {"format": 4}
        for key in ("model", "judge"):
            state[key] = {part: rename(values) for part, values in state[key].items()}
        encoder = [key for key in state["judge"]["weights"] if key.startswith("encoder.")]
        for key in encoder:
            weight = state["judge"]["weights"].pop(key)
            state["judge"]["weights"][key.replace("encoder.", "view.", 1)] = weight
        save_state(old_path, state)
        loaded, old = load_predictor(path), load_predictor(old_path)
        assert old.thresholds == loaded.thresholds
        weights, old_weights = weights_of(loaded), weights_of(old)
        assert weights.keys() == old_weights.keys()
        assert all(torch.equal(weights[key], old_weights[key]) for key in weights)


def test_files_of_something_else_are_refused(tmp_path):
    path, odd = tmp_path / "raft.predictor", tmp_path / "odd.predictor"
    save_small(path, "raft")
    too_wide = dict(architecture=dict(SMALL_RAFT, hidden=32), weights={})
    for change, message in (
        (dict(format=3), "another version"),
        (dict(format=FORMAT + 1), "another version"),
        (dict(name="unet"), "no mask predictor"),
        (dict(model=too_wide), "does not fit this version's 'raft'"),
        (dict(model=dict(architecture=dict(unknown=1), weights={})), "does not fit"),
        (dict(view_classifier=dict(architecture=dict(width=8), weights={})), "does not fit"),
        (dict(model=None), "does not fit"),
    ):
        save_state(odd, load_state(path, "") | change)
        with pytest.raises(PredictorError, match=message):
            load_predictor(odd)
    with pytest.raises(PredictorError, match="holds the model 'raft', not 'flownet'"):
        load_predictor(path, "flownet")
    odd.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(CheckpointError, match="damaged"):
        load_predictor(odd)


def test_pictures_of_another_type_or_size_are_refused():
    for shape, dtype, message in (
        ((1, 2, 128, 128, 3), float, "must be uint8"),
        ((2, 128, 128, 3), np.uint8, "must be uint8 of the shape"),
        ((1, 2, 100, 128, 3), np.uint8, "100 x 128 pixels; sides must be multiples of 32"),
        ((1, 2, 32, 32, 3), np.uint8, "at least 64"),
    ):
        with pytest.raises(PredictorError, match=message):
            check_pictures(np.zeros(shape, dtype))

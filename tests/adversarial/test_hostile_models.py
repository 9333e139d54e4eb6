"""A predictor whose weights, thresholds or architecture are not those of one is refused."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from sensory_commutativity.change_detection.predictor import PredictorError, load_predictor
from sensory_commutativity.errors import UserError
from sensory_commutativity.storage.checkpoints import load_state, save_state
from tests.adversarial.kinds import small_predictor


@pytest.fixture
def path(tmp_path) -> Path:
    small_predictor(tmp_path / "flownet.predictor")
    return tmp_path / "flownet.predictor"


def first_weight(state: dict[str, Any]) -> tuple[dict[str, Any], str]:
    weights = state["model"]["weights"]
    return weights, next(iter(weights))


def set_weight(value: float) -> Callable[[dict[str, Any]], None]:
    def change(state: dict[str, Any]) -> None:
        weights, key = first_weight(state)
        weights[key] = torch.full_like(weights[key], value)

    return change


def set_variance(state: dict[str, Any]) -> None:
    weights = state["view_classifier"]["weights"]
    key = next(key for key in weights if key.endswith("running_var"))
    weights[key] = weights[key] - 10


def expand(state: dict[str, Any]) -> None:
    """A tensor of very many numbers, of which one is stored."""
    weights, key = first_weight(state)
    weights[key] = torch.zeros(1).expand(10**11)


def replace_weight(make: Callable[[torch.Tensor], Any]) -> Callable[[dict[str, Any]], None]:
    def change(state: dict[str, Any]) -> None:
        weights, key = first_weight(state)
        weights[key] = make(weights[key])

    return change


def architecture(**arguments: Any) -> Callable[[dict[str, Any]], None]:
    return lambda state: state["model"].update(architecture=arguments)


def thresholds(values: Any) -> Callable[[dict[str, Any]], None]:
    return lambda state: state.update(thresholds=values)


def as_raft(**arguments: Any) -> Callable[[dict[str, Any]], None]:
    return lambda state: state.update(
        name="raft", model=dict(architecture=arguments, weights=state["model"]["weights"])
    )


CHANGES: dict[str, Callable[[dict[str, Any]], Any]] = {
    "NaN": set_weight(math.nan),
    "infinite": set_weight(math.inf),
    "a variance below 0": set_variance,
    "expanded": expand,
    "another shape": replace_weight(lambda w: w[:1]),
    "complex": replace_weight(lambda w: w.to(torch.complex64)),
    "sparse": replace_weight(lambda w: w.float().to_sparse()),
    "no tensor": replace_weight(lambda w: 3),
    "no weights": lambda state: state["model"].update(weights={}),
    "weights that are a list": lambda state: state["model"].update(weights=[]),
    "no architecture": lambda state: state["model"].update(architecture=None),
    "a large scale": architecture(scale=1e6),
    "NaN scale": architecture(scale=math.nan),
    "a text as scale": architecture(scale="0.02"),
    "an unknown argument": architecture(scale=0.02, depth=3),
    "very many updates": as_raft(updates=10**9),
    "very many channels": as_raft(widths=[10**6] * 5),
    "many widths": as_raft(widths=[8] * 1000),
    "a large radius": as_raft(radius=10**4),
    "very many levels": as_raft(levels=10**5),
    "no channels": as_raft(hidden=0),
    "True": as_raft(hidden=True),
    "NaN thresholds": thresholds([math.nan, 0.5, 10.0]),
    "infinite thresholds": thresholds([0.5, 0.5, math.inf]),
    "text thresholds": thresholds(["0.5", "0.5", "10"]),
    "one threshold": thresholds([0.5]),
    "no thresholds": thresholds(None),
    "a threshold above 1": thresholds([1.5, 0.5, 10.0]),
    "a negative threshold": thresholds([0.5, 0.5, -1.0]),
    "a name that is a list": lambda state: state.update(name=["flownet"]),
    "a version that is a text": lambda state: state.update(format="5"),
    "another network": lambda state: state.update(name="raft"),
}


@pytest.mark.parametrize("what", CHANGES)
def test_predictors_that_would_answer_wrongly_or_never_are_refused(path, what):
    state = load_state(path, "train it")
    CHANGES[what](state)
    save_state(path, state)
    start = time.monotonic()
    with pytest.raises(UserError) as caught:
        load_predictor(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ") and message.isprintable()
    assert time.monotonic() - start < 2


def test_an_unchanged_predictor_is_taken(path):
    assert load_predictor(path).name == "flownet"


def test_a_predictor_that_gives_no_numbers_is_refused_when_it_predicts(path):
    state = load_state(path, "train it")
    for key, weight in state["model"]["weights"].items():
        state["model"]["weights"][key] = torch.full_like(weight, 6e4)
    save_state(path, state)
    pictures = np.random.default_rng(0).integers(0, 256, (1, 2, 64, 64, 3), np.uint8)
    with pytest.raises(PredictorError, match="gives no numbers"):
        load_predictor(path).predict_proba(pictures)


def test_a_state_that_is_no_mapping_is_refused(tmp_path):
    save_state(tmp_path / "a.predictor", [1, 2])  # type: ignore[arg-type]
    with pytest.raises(UserError, match="holds no model"):
        load_state(tmp_path / "a.predictor", "train it")

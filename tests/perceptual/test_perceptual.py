"""Weights of VGG16 are fetched once, checked, kept; features do not depend on which pictures are asked for together."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity.perceptual import weights as module
from sensory_commutativity.perceptual.features import PerceptualFeatures
from sensory_commutativity.perceptual.weights import (
    CHANNELS,
    Weights,
    WeightsError,
    cache_file,
    load_vgg16_weights,
)


def made_up(source: str = "package", seed: int = 0) -> Weights:
    rng = np.random.default_rng(seed)
    inputs = (3, *CHANNELS[:-1])
    return Weights(
        tuple(
            (
                rng.normal(0, (2 / (9 * i)) ** 0.5, (o, i, 3, 3)).astype(np.float32),
                rng.normal(0, 0.1, o).astype(np.float32),
            )
            for o, i in zip(CHANNELS, inputs, strict=True)
        ),
        source,
    )


@pytest.fixture(scope="module")
def weights() -> Weights:
    return made_up()


@pytest.fixture(scope="module")
def features(weights) -> PerceptualFeatures:
    return PerceptualFeatures(weights)


@pytest.fixture
def elsewhere(tmp_path, monkeypatch, weights):
    """A cache of its own, and sources that are counted; the made-up weights have the right hash."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(module, "SHA256", weights.sha256)
    calls = []

    def fails():
        calls.append("hub")
        raise OSError("no network")

    def works():
        calls.append("package")
        return weights

    monkeypatch.setattr(module, "SOURCES", {"hub": fails, "package": works})
    return calls


def pictures(n: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (n, 48, 48, 3)).astype(np.uint8)


def test_features_are_those_of_torchvisions_network(weights, features):
    import torch
    from torchvision.models import vgg16

    network = vgg16(weights=None).features[:30].eval()  # up to the ReLU of block5_conv3
    convolutions = [layer for layer in network if isinstance(layer, torch.nn.Conv2d)]
    for layer, (kernels, biases) in zip(convolutions, weights.convolutions, strict=True):
        layer.weight.data, layer.bias.data = (
            torch.from_numpy(kernels.copy()),
            torch.from_numpy(biases.copy()),
        )
    images = pictures(2)
    inputs = torch.from_numpy(images[..., ::-1].copy()).permute(0, 3, 1, 2).float() - torch.tensor(
        [103.939, 116.779, 123.68]
    ).reshape(1, 3, 1, 1)
    with torch.inference_mode():
        expected = network(inputs).mean((2, 3)).numpy()
    assert features.features(images).shape == (2, 512)
    assert np.allclose(
        features.features(images), expected, rtol=1e-3, atol=1e-3 * np.abs(expected).max()
    )


def test_features_do_not_depend_on_their_company(features):
    images = pictures(5)
    whole = features.features(images)
    assert np.array_equal(whole[::-1], features.features(images[::-1])) and np.array_equal(
        whole[2:3], features.features(images[2:3])
    )


def test_distances_are_squared_and_zero_for_equal_pictures(features):
    first, second = pictures(3), pictures(3, 1)
    second[1] = first[1]
    found = features.distances(first, second)
    a, b = features.features(first).astype(float), features.features(second).astype(float)
    assert (
        found[1] == 0
        and found == pytest.approx(((a - b) ** 2).sum(1))
        and (found[[0, 2]] > 0).all()
    )


def test_pictures_of_another_kind_are_refused(features):
    with pytest.raises(ValueError, match="must be uint8"):
        features.features(np.zeros((1, 8, 8, 3)))
    with pytest.raises(ValueError, match="compared in pairs"):
        features.distances(pictures(2), pictures(3))


def test_weights_are_fetched_once_and_kept(elsewhere, weights):
    assert load_vgg16_weights().source == "package" and elsewhere == ["hub", "package"]
    again = load_vgg16_weights()
    assert (
        elsewhere == ["hub", "package"]
        and again.sha256 == weights.sha256
        and again.source == "package"
    )
    assert [path.name for path in cache_file().parent.iterdir()] == ["vgg16.npz"]


def test_damaged_weights_are_fetched_anew(elsewhere):
    load_vgg16_weights()
    content = bytearray(cache_file().read_bytes())
    content[len(content) // 2] ^= 255
    cache_file().write_bytes(content)
    load_vgg16_weights()
    assert elsewhere == ["hub", "package"] * 2


def test_a_file_may_be_given(elsewhere, tmp_path):
    load_vgg16_weights()
    cache_file().rename(tmp_path / "mine.npz")
    assert load_vgg16_weights(tmp_path / "mine.npz").source == "package" and elsewhere == [
        "hub",
        "package",
    ]
    with pytest.raises(WeightsError, match="there is no file"):
        load_vgg16_weights(tmp_path / "none.npz")
    (tmp_path / "bad.pth").write_text("no weights")
    with pytest.raises(WeightsError, match="cannot be read as VGG16 weights"):
        load_vgg16_weights(tmp_path / "bad.pth")


def test_torchvisions_file_may_be_given(elsewhere, tmp_path, weights):
    import torch

    places = [0, 2, 5, 7, 10, 12, 14, 17, 19, 21, 24, 26, 28]
    state = {}
    for n, (kernels, biases) in zip(places, weights.convolutions, strict=True):
        state[f"features.{n}.weight"] = torch.from_numpy(
            kernels[:, ::-1].copy() if n == 0 else kernels.copy()
        )
        state[f"features.{n}.bias"] = torch.from_numpy(biases.copy())
    torch.save(state, tmp_path / "vgg16_features.pth")
    assert load_vgg16_weights(tmp_path / "vgg16_features.pth").sha256 == weights.sha256


def test_weights_with_another_hash_are_refused(elsewhere, monkeypatch):
    monkeypatch.setattr(module, "SOURCES", {"package": lambda: made_up(seed=1)})
    with pytest.raises(
        WeightsError, match=r"cannot be had \(package: package: the hash of the weights is"
    ):
        load_vgg16_weights()
    assert not cache_file().exists()


def test_when_no_source_answers_the_remedy_is_told(elsewhere, monkeypatch):
    monkeypatch.setattr(module, "SOURCES", dict.fromkeys(("one", "two"), module.SOURCES["hub"]))
    with pytest.raises(
        WeightsError,
        match=r"one: no network; two: no network\); fetch them where there is internet",
    ) as error:
        load_vgg16_weights()
    assert "apartment.weights" in str(error.value) and "\n" not in str(error.value)


def test_the_published_weights_are_what_is_kept():
    if not cache_file().is_file():
        pytest.skip("the weights have not been fetched on this machine")
    kernels, biases = load_vgg16_weights().convolutions[0]
    assert kernels[0, :, 0, 0] == pytest.approx((0.42947057, 0.55037946, 0.4800154), abs=1e-7)
    assert biases[:4] == pytest.approx((0.73429835, 0.09340367, 0.06775674, 0.8862966), abs=1e-7)

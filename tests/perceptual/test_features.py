"""Features of VGG16 and their distances."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torchvision.models import vgg16

from sensory_commutativity.perceptual.features import MEANS, PerceptualFeatures
from tests.perceptual.random_weights import random_weights


@pytest.fixture(scope="module")
def features() -> PerceptualFeatures:
    return PerceptualFeatures(random_weights())


def random_images(n: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (n, 48, 48, 3)).astype(np.uint8)


def test_features_are_those_of_torchvisions_network(features):
    network = vgg16(weights=None).features[:30].eval()  # up to the ReLU of block5_conv3
    convolutions = [layer for layer in network if isinstance(layer, torch.nn.Conv2d)]
    weights = random_weights().convolutions
    for layer, (kernels, biases) in zip(convolutions, weights, strict=True):
        layer.weight.data = torch.from_numpy(kernels.copy())
        layer.bias.data = torch.from_numpy(biases.copy())
    images = random_images(2)
    bgr = torch.from_numpy(images[..., ::-1].copy()).permute(0, 3, 1, 2).float()
    with torch.inference_mode():
        output = network(bgr - torch.tensor(MEANS).reshape(1, 3, 1, 1))
    expected = output.mean((2, 3)).numpy()
    assert features.compute(images).shape == (2, 512)
    tolerance = 1e-3 * np.abs(expected).max()
    assert np.allclose(features.compute(images), expected, rtol=1e-3, atol=tolerance)


def test_features_do_not_depend_on_the_other_images(features):
    images = random_images(5)
    expected = features.compute(images)
    assert np.array_equal(expected[::-1], features.compute(images[::-1]))
    assert np.array_equal(expected[2:3], features.compute(images[2:3]))
    assert features.compute(images[:0]).shape == (0, 512)


def test_distances_are_squared_and_zero_for_equal_images(features):
    first, second = random_images(3), random_images(3, 1)
    second[1] = first[1]
    distances = features.distances(first, second)
    a, b = features.compute(first).astype(float), features.compute(second).astype(float)
    assert distances == pytest.approx(((a - b) ** 2).sum(1))
    assert distances[1] == 0 and (distances[[0, 2]] > 0).all()


def test_invalid_images_are_rejected(features):
    with pytest.raises(ValueError, match="must be uint8"):
        features.compute(np.zeros((1, 8, 8, 3)))
    with pytest.raises(ValueError, match="compared in pairs"):
        features.distances(random_images(2), random_images(3))

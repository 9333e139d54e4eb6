"""Random weights in the shape of VGG16's."""

from __future__ import annotations

import numpy as np

from sensory_commutativity.perceptual.weights import CHANNELS, Weights


def random_weights(source: str = "package", seed: int = 0) -> Weights:
    rng = np.random.default_rng(seed)
    convolutions = []
    for outputs, inputs in zip(CHANNELS, (3, *CHANNELS[:-1]), strict=True):
        kernels = rng.normal(0, (2 / (9 * inputs)) ** 0.5, (outputs, inputs, 3, 3))
        biases = rng.normal(0, 0.1, outputs)
        convolutions.append((kernels.astype(np.float32), biases.astype(np.float32)))
    return Weights(tuple(convolutions), source)

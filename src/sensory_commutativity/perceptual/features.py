"""Squared distances of VGG16 features: what counts as the same picture (paper, section III-B: "a perceptual distance using the VGG16 features").

The paper does not say which layer it used. Taken is the last convolution, block5_conv3, after its ReLU, averaged over the picture: 512 numbers. Its
squared distance between unrelated pictures of an apartment is about 4,900, so that the paper's thresholds 20 to 100 mean a camera turned by a tenth
of a degree to a degree; those of other layers are ten to three hundred times as large, and the same thresholds would mean nothing but identity.
"""

from __future__ import annotations

import hashlib

import numpy as np

from .weights import BLOCKS, Weights

MEANS = (103.939, 116.779, 123.68)
"""Of blue, green and red over the pictures that the network was trained on (Simonyan and Zisserman 2014)."""


class PerceptualFeatures:
    """Features of pictures.

    Every picture goes through the network alone, so that its features do not depend, not even in the last digit, on which others are asked for with
    it.

    Parameters
    ----------
    weights : Weights

    Attributes
    ----------
    about : dict
        Where the weights are from, and their hash: for what is written of the distances.
    """

    def __init__(self, weights: Weights):
        import torch

        self._torch = torch
        self.about = {"vgg16_source": weights.source, "vgg16_sha256": weights.sha256}
        self._convolutions = [
            tuple(torch.from_numpy(np.array(array, np.float32)) for array in convolution) for convolution in weights.convolutions
        ]  # fmt: skip
        self._convolutions = [
            (kernels.contiguous(memory_format=torch.channels_last), biases)
            for kernels, biases in self._convolutions
        ]
        self._means = torch.tensor(MEANS).reshape(1, 3, 1, 1)

    def features(self, images: np.ndarray) -> np.ndarray:
        """Features of uint8 (n, h, w, 3), red, green, blue: float32 (n, 512)."""
        images = np.asarray(images)
        if images.dtype != np.uint8 or images.ndim != 4 or images.shape[3] != 3:
            raise ValueError(
                f"pictures must be uint8 of the shape (n, height, width, 3); got {images.dtype} {images.shape}"
            )
        return (
            np.stack([self._of_one(image) for image in images])
            if len(images)
            else np.zeros((0, self._convolutions[-1][1].shape[0]), np.float32)
        )

    def distances(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Squared distances of the features of pictures, both uint8 (n, h, w, 3), pair by pair: float64 (n,); exactly 0 for equal pictures."""
        if first.shape != second.shape:
            raise ValueError(
                f"pictures are compared in pairs, but there are {first.shape} and {second.shape}"
            )
        known: dict[bytes, np.ndarray] = {}

        def of(image: np.ndarray) -> np.ndarray:
            key = hashlib.sha256(np.ascontiguousarray(image).tobytes()).digest()
            if key not in known:
                known[key] = self.features(image[None])[0].astype(np.float64)
            return known[key]

        return np.array(
            [
                0.0 if np.array_equal(a, b) else ((of(a) - of(b)) ** 2).sum()
                for a, b in zip(first, second, strict=True)
            ],
            np.float64,
        )

    def _of_one(self, image: np.ndarray) -> np.ndarray:
        torch, functional = self._torch, self._torch.nn.functional
        with torch.inference_mode():
            x = (
                torch.from_numpy(np.ascontiguousarray(image[..., ::-1]))
                .permute(2, 0, 1)[None]
                .float()
                - self._means
            )
            x = x.contiguous(memory_format=torch.channels_last)
            layer = 0
            for block, count in enumerate(BLOCKS):
                for _ in range(count):
                    kernels, biases = self._convolutions[layer]
                    x = functional.relu(functional.conv2d(x, kernels, biases, padding=1))
                    layer += 1
                if block < len(BLOCKS) - 1:
                    x = functional.max_pool2d(x, 2, 2)
            return x.mean((2, 3))[0].numpy().copy()

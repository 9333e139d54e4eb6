"""Squared distances of VGG16 features.

They decide whether two images count as equal (paper, section III-B: "a perceptual distance using
the VGG16 features").

The paper does not say which layer it used. We use the last convolution, block5_conv3, after its
ReLU, averaged over the image: 512 numbers. Its squared distance between unrelated images of an
apartment is about 4,900, so that the paper's thresholds of 20 to 100 correspond to a camera turned
by a tenth of a degree to a degree. Distances of other layers are ten to three hundred times as
large; with them, the same thresholds would accept identical images only.
"""

from __future__ import annotations

import hashlib

import numpy as np
import torch
from torch.nn import functional

from .weights import BLOCKS, Weights

MEANS = (103.939, 116.779, 123.68)
"""Means of blue, green and red over the training images (Simonyan and Zisserman 2014,
https://arxiv.org/abs/1409.1556; the numbers are those of their Caffe model)."""


class PerceptualFeatures:
    """VGG16 features of images.

    Every image passes through the network on its own, so that its features do not depend, not even
    in the last digit, on the other images of a call.

    Parameters
    ----------
    weights : Weights

    Attributes
    ----------
    metadata : dict of str to str
        Source and hash of the weights, for files of distances.
    """

    def __init__(self, weights: Weights):
        self.metadata = {"vgg16_source": weights.source, "vgg16_sha256": weights.sha256}
        self._convolutions: list[tuple[torch.Tensor, torch.Tensor]] = []
        for kernels, biases in weights.convolutions:
            kernel = torch.from_numpy(np.array(kernels, np.float32))
            kernel = kernel.contiguous(memory_format=torch.channels_last)
            self._convolutions.append((kernel, torch.from_numpy(np.array(biases, np.float32))))
        self._means = torch.tensor(MEANS).reshape(1, 3, 1, 1)

    def compute(self, images: np.ndarray) -> np.ndarray:
        """Compute the features of RGB images.

        Parameters
        ----------
        images : uint8 (n, height, width, 3)

        Returns
        -------
        float32 (n, 512)
        """
        images = np.asarray(images)
        if images.dtype != np.uint8 or images.ndim != 4 or images.shape[3] != 3:
            raise ValueError(
                f"images must be uint8 of the shape (n, height, width, 3); "
                f"got {images.dtype} {images.shape}"
            )
        if not len(images):
            return np.zeros((0, self._convolutions[-1][1].shape[0]), np.float32)
        return np.stack([self._compute_one(image) for image in images])

    def distances(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Compute squared feature distances between corresponding images.

        Parameters
        ----------
        first, second : uint8 (n, height, width, 3)

        Returns
        -------
        float64 (n,)
            Exactly 0 for equal images.
        """
        if first.shape != second.shape:
            raise ValueError(
                f"images are compared in pairs, but the shapes are {first.shape} and {second.shape}"
            )
        cache: dict[bytes, np.ndarray] = {}

        def cached_features(image: np.ndarray) -> np.ndarray:
            key = hashlib.sha256(np.ascontiguousarray(image).tobytes()).digest()
            if key not in cache:
                cache[key] = self.compute(image[None])[0].astype(np.float64)
            return cache[key]

        squared = [
            0.0 if np.array_equal(a, b) else ((cached_features(a) - cached_features(b)) ** 2).sum()
            for a, b in zip(first, second, strict=True)
        ]
        return np.array(squared, np.float64)

    @torch.inference_mode()
    def _compute_one(self, image: np.ndarray) -> np.ndarray:
        """Features float32 (512,) of an RGB image uint8 (height, width, 3)."""
        bgr = np.ascontiguousarray(image[..., ::-1])
        x = torch.from_numpy(bgr).permute(2, 0, 1)[None].float() - self._means  # (1, 3, h, w)
        x = x.contiguous(memory_format=torch.channels_last)
        convolutions = iter(self._convolutions)
        for block, count in enumerate(BLOCKS):
            for _ in range(count):
                kernels, biases = next(convolutions)
                x = functional.relu(functional.conv2d(x, kernels, biases, padding=1))
            if block < len(BLOCKS) - 1:
                x = functional.max_pool2d(x, 2, 2)
        return x.mean((2, 3))[0].numpy().copy()  # (512,)

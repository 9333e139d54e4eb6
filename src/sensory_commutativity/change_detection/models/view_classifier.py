"""View classifier: which of the two views of a changed region shows something that moved?

Models find well where something changed, and less well in which of the two views it is: part of
an object, or all of it, is put into the view that shows what is behind it. The whole region tells
more: an object has an outline and colours of its own, and the background continues under that
outline. The view classifier therefore sees a crop of both pictures and of both masks around each
connected region that changed, and predicts for each view whether nothing in it moved.
:mod:`..training.view_classifier_trainer` trains it on regions that the model finds.
"""

from __future__ import annotations

import numpy as np
import torch
from scipy.ndimage import find_objects, label
from torch import Tensor, nn
from torchvision.ops import roi_align

from ..decision import MASK_THRESHOLD

CROP_SIZE = 48
"""Pixels: height and width of a crop; chosen on development tuples against 32."""
CROP_CHANNELS = 9
"""Channels of a crop: RGB of either picture in [-1, 1], the probabilities of either view and the
region in [0, 1]; 0 outside of the picture."""
CONTEXT_FACTOR = 1.7
"""Extent of a crop in longer sides of its region, so that it shows surroundings; chosen."""
MIN_EXTENT = 16
"""Smallest extent of a crop, in pixels of the pictures; chosen."""
EMPTY_THRESHOLD = 0.5
"""Probability above which a view is taken to show nothing that moved."""
_EIGHT_CONNECTED = np.ones((3, 3))


class ViewClassifier(nn.Module):
    """Maps crops to the logits that a view shows nothing that moved.

    Both views pass through the same layers; the last layer sees the features of both.

    Parameters
    ----------
    width : int
        Channels of the first two convolutions; the next two have twice, the last two three times
        as many.
    """

    def __init__(self, width: int = 32):
        super().__init__()
        self.architecture = dict(width=width)
        # of a view: the crop, and the absolute difference of the pictures
        self.encoder = nn.Sequential(
            *_conv_block(CROP_CHANNELS + 3, width),
            nn.MaxPool2d(2),
            *_conv_block(width, 2 * width),
            nn.MaxPool2d(2),
            *_conv_block(2 * width, 3 * width),
            nn.AdaptiveAvgPool2d(1),
            nn.Flatten(),
        )
        self.classifier = nn.Sequential(nn.Dropout(0.3), nn.Linear(6 * width, 1))

    def forward(self, crops: Tensor) -> Tensor:
        """Map crops, float (k, CROP_CHANNELS, CROP_SIZE, CROP_SIZE), to logits, float (k, 2)."""
        first, second, maps, region = crops.split((3, 3, 2, 1), 1)
        difference = (first - second).abs()
        views = [
            torch.cat((first, second, difference, maps, region), 1),
            torch.cat((second, first, difference, maps.flip(1), region), 1),
        ]
        features1, features2 = self.encoder(torch.cat(views)).chunk(2)  # (k, 3 width) each
        logits = [
            self.classifier(torch.cat((features1, features2), 1)),
            self.classifier(torch.cat((features2, features1), 1)),
        ]
        return torch.cat(logits, 1)


def changed_regions(maps: np.ndarray) -> list[np.ndarray]:
    """Return the connected regions that changed in either view, bool (h, w) each.

    `maps` are the probabilities of a pair, float (2, h, w). A pair that is different everywhere
    has no regions.
    """
    if maps.mean() > MASK_THRESHOLD:
        return []
    components, n = label((maps > MASK_THRESHOLD).any(0), _EIGHT_CONNECTED)
    return [components == k + 1 for k in range(n)]


def crop_regions(maps: np.ndarray, pictures: np.ndarray, regions: list[np.ndarray]) -> Tensor:
    """Crop a pair around each of its regions, by RoIAlign.

    Parameters
    ----------
    maps : float (2, h, w)
        Probabilities.
    pictures : uint8 (2, h, w, 3)
    regions : list of bool (h, w)
        At least one.

    Returns
    -------
    float32 (k, CROP_CHANNELS, CROP_SIZE, CROP_SIZE)
    """
    height, width = maps.shape[1:]
    rgb = pictures.transpose(0, 3, 1, 2).reshape(6, height, width) / 127.5 - 1
    shared = np.concatenate([rgb, maps])  # (8, h, w)
    layers = np.stack([np.concatenate([shared, region[None]]) for region in regions])
    boxes = [[k, *_crop_box(region)] for k, region in enumerate(regions)]
    return roi_align(
        torch.from_numpy(layers.astype(np.float32)),
        torch.tensor(boxes, dtype=torch.float32),
        CROP_SIZE,
        aligned=True,
    )


def refine_masks(
    view_classifier: nn.Module, probabilities: np.ndarray, pictures: np.ndarray
) -> np.ndarray:
    """Settle for each changed region which views show something that moved.

    If one view is classified as empty, the other gets the whole region, and the empty one none of
    it. If both are, the region is removed; if none is, it is left as it is.

    Parameters
    ----------
    view_classifier : ViewClassifier
    probabilities : float (n, 2, h, w)
    pictures : uint8 (n, 2, h, w, 3)

    Returns
    -------
    float (n, 2, h, w)
    """
    refined = probabilities.copy()
    for maps, pair in zip(refined, pictures, strict=True):
        regions = changed_regions(maps)
        if not regions:
            continue
        is_empty = predict_empty(view_classifier, crop_regions(maps, pair, regions))
        for region, empty in zip(regions, is_empty > EMPTY_THRESHOLD, strict=True):
            if empty.any():
                maps[:, region] = np.where(empty[:, None], 0, maps[:, region].max(0))
    return refined


def predict_empty(view_classifier: nn.Module, crops: Tensor) -> np.ndarray:
    """Predict the probability that a view shows nothing that moved: float32 (k, 2).

    Logits are averaged over the crops and their mirror images.
    """
    crops = crops.to(next(view_classifier.parameters()).device)
    with torch.inference_mode():
        logits = (view_classifier(crops) + view_classifier(crops.flip(-1))) / 2
    return torch.sigmoid(logits).cpu().numpy()


def swap_views(crops: Tensor) -> Tensor:
    """Exchange the two views of crops, float (k, CROP_CHANNELS, h, w)."""
    first, second, maps, region = crops.split((3, 3, 2, 1), 1)
    return torch.cat([second, first, maps.flip(1), region], 1)


def _crop_box(region: np.ndarray) -> tuple[float, float, float, float]:
    """Left, top, right and bottom of the crop around a region, in pixels."""
    rows, cols = find_objects(region.astype(int))[0]
    extent = max(MIN_EXTENT, CONTEXT_FACTOR * max(rows.stop - rows.start, cols.stop - cols.start))
    half = extent / 2
    y, x = (rows.start + rows.stop) / 2, (cols.start + cols.stop) / 2
    return x - half, y - half, x + half, y + half


def _conv_block(inputs: int, outputs: int) -> list[nn.Module]:
    """Two convolutions with batch normalisation."""
    layers: list[nn.Module] = []
    for channels in (inputs, outputs):
        layers.append(nn.Conv2d(channels, outputs, 3, 1, 1, bias=False))
        layers += [nn.BatchNorm2d(outputs), nn.ReLU()]
    return layers

"""Training of a view classifier on the regions that a trained model finds changed.

The pairs are those that the model was trained on. It fits them no better than others
(docs/differences.md), so its errors on them are representative.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from ...seeding import generator, seed_for
from ..models.view_classifier import (
    CROP_CHANNELS,
    CROP_SIZE,
    ViewClassifier,
    changed_regions,
    crop_regions,
    swap_views,
)
from ..predictor import MaskPredictor, PredictorError
from .trainer import Trainer, TrainingSettings, supports_bfloat16

MIN_COVERAGE = 0.15
"""Fraction of a region from which a view of it shows what moved; chosen: less is the rim of a
neighbouring object."""
MIN_LOG_GAIN, MAX_LOG_GAIN = -0.4, 0.3
"""Range of the logarithm of the brightness gain; chosen: about that of the pairs in training."""


class Regions(NamedTuple):
    """Labelled regions.

    Attributes
    ----------
    crops : float16 (k, CROP_CHANNELS, CROP_SIZE, CROP_SIZE)
    empty : bool (k, 2)
        Whether a view shows nothing that moved.
    """

    crops: np.ndarray
    empty: np.ndarray


def label_regions(predictor: MaskPredictor, pictures: np.ndarray, masks: np.ndarray) -> Regions:
    """Crop the regions that a predictor finds changed, and label them by the true masks.

    Parameters
    ----------
    predictor : MaskPredictor
        Without a view classifier, whose corrections would hide the model's errors.
    pictures : uint8 (n, 2, h, w, 3)
    masks : bool (n, 2, h, w)
        True masks.

    Returns
    -------
    Regions

    Raises
    ------
    PredictorError
        If the predictor has a view classifier.
    """
    if predictor.view_classifier is not None:
        raise PredictorError(
            "the predictor already has a view classifier; give the one that model training wrote"
        )
    crops = [torch.zeros(0, CROP_CHANNELS, CROP_SIZE, CROP_SIZE)]
    empty = [np.zeros((0, 2), bool)]
    probabilities = predictor.predict_proba(pictures)
    for maps, pair, mask in zip(probabilities, pictures, masks, strict=True):
        regions = changed_regions(maps)
        if regions:
            crops.append(crop_regions(maps, pair, regions))
            coverage = np.stack([mask[:, region].mean(1) for region in regions])  # (k, 2)
            empty.append(coverage < MIN_COVERAGE)
    return Regions(torch.cat(crops).half().numpy(), np.concatenate(empty))


class ViewClassifierTrainer(Trainer):
    """Trains a view classifier; crops are mirrored, exchanged and recoloured at random.

    Parameters
    ----------
    regions : Regions
        At least one.
    settings : TrainingSettings
    seed : int
    device : str
        ``cpu`` or ``cuda``.
    **architecture
        Arguments of :class:`ViewClassifier`.
    """

    model: ViewClassifier

    def __init__(
        self,
        regions: Regions,
        settings: TrainingSettings,
        seed: int,
        device: str = "cpu",
        **architecture: int,
    ):
        self.regions = regions
        self.seed = seed
        self.device = device
        # "judge" in the keys of random streams is a former name; weights depend on it
        torch.manual_seed(seed_for(seed, "weights", "judge") % 2**63)
        model = ViewClassifier(**architecture).to(device)
        # channels last is a fifth faster on a CPU
        super().__init__(model.to(memory_format=torch.channels_last), settings)

    def compute_loss(self) -> Tensor:
        """Cross-entropy over both views of the current step's batch: float ()."""
        rng = generator(self.seed, "step", "judge", self.step)
        torch.manual_seed(seed_for(self.seed, "dropout", self.step) % 2**63)
        n = self.settings.batch_size
        indices = rng.integers(len(self.regions.empty), size=n)
        crops = torch.from_numpy(self.regions.crops[indices]).to(self.device).float()
        empty = torch.from_numpy(self.regions.empty[indices]).to(self.device).float()
        mirror = torch.from_numpy(rng.uniform(size=n) < 0.5).to(self.device)
        swap = torch.from_numpy(rng.uniform(size=n) < 0.5).to(self.device)
        crops = torch.where(mirror[:, None, None, None], crops.flip(-1), crops)
        crops = torch.where(swap[:, None, None, None], swap_views(crops), crops)
        empty = torch.where(swap[:, None], empty.flip(1), empty)
        crops = torch.cat([_recolour(crops[:, :6], rng), crops[:, 6:]], 1)
        with torch.autocast(self.device, torch.bfloat16, enabled=supports_bfloat16(self.device)):
            logits = self.model(crops.contiguous(memory_format=torch.channels_last))
        return F.binary_cross_entropy_with_logits(logits.float(), empty)


def _recolour(rgb: Tensor, rng: np.random.Generator) -> Tensor:
    """Permute the colour channels and change the brightness, alike in both pictures.

    Parameters
    ----------
    rgb : float (k, 6, h, w)
        RGB of both pictures in [-1, 1]; 0 outside of the pictures, which stays 0.
    rng : numpy.random.Generator

    Returns
    -------
    float (k, 6, h, w)
    """
    inside = (rgb != 0).any(1, keepdim=True)
    order = torch.from_numpy(rng.permutation(3)).to(rgb.device)
    gain = np.exp(rng.uniform(MIN_LOG_GAIN, MAX_LOG_GAIN, (len(rgb), 1, 1, 1)))
    recoloured = rgb[:, torch.cat([order, order + 3])] + 1
    recoloured = recoloured * torch.from_numpy(gain.astype(np.float32)).to(rgb.device) - 1
    return torch.where(inside, recoloured.clamp(-1, 1), 0)

"""How a judge of places learns: from places that a trained model found changed in pairs whose masks are known.

The pairs are such that the model was trained on. It fits them no better than others (docs/differences.md), so its doubts about them are its doubts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from ...seeding import generator, seed_for
from ..models.view_classifier import (
    CHANNELS,
    SIDE,
    ViewClassifier,
    changed_regions,
    crop_regions,
    exchanged,
)
from ..predictor import MaskPredictor, PredictorError
from .trainer import Trainer, TrainingSettings, has_half_precision

COVERED = 0.15
"""Of a place, from which what moved is there in a view; chosen: less is the rim of what is beside it."""
DIMMEST, BRIGHTEST = -0.4, 0.3
"""Logarithms of how much darker or brighter close-ups are made; chosen: about as the pairs themselves are in training."""


class Regions(NamedTuple):
    """Many places.

    Attributes
    ----------
    crop_regions : float16 (k, CHANNELS, SIDE, SIDE)
    empty : bool (k, 2)
        Whether a view shows nothing there that moved.
    """

    crop_regions: np.ndarray
    empty: np.ndarray


def labelled_regions(predictor: MaskPredictor, pictures: np.ndarray, masks: np.ndarray) -> Regions:
    """Regions that a predictor without a judge finds changed, labelled by the true masks.

    Parameters
    ----------
    predictor : MaskPredictor
    pictures : uint8 (n, 2, h, w, 3)
    masks : bool (n, 2, h, w)

    Returns
    -------
    Regions

    Raises
    ------
    PredictorError
        If the predictor has a judge: what it says is no longer what the model says.
    """
    if predictor.judge is not None:
        raise PredictorError(
            "the predictor has a judge already; give the one that mask-training wrote, under data/mask_training/"
        )
    seen, empty = [torch.zeros(0, CHANNELS, SIDE, SIDE)], [np.zeros((0, 2), bool)]
    for maps, pair, truth in zip(predictor.probabilities(pictures), pictures, masks, strict=True):
        places = changed_regions(maps)
        if places:
            seen.append(crop_regions(maps, pair, places))
            empty.append(np.stack([truth[:, place].mean(1) < COVERED for place in places]))
    return Regions(torch.cat(seen).half().numpy(), np.concatenate(empty))


class ViewClassifierTrainer(Trainer):
    """A judge in training: close-ups are mirrored, exchanged and recoloured alike in both pictures.

    Parameters
    ----------
    places : Regions
        At least one.
    recipe : TrainingSettings
    seed : int
    device : str
        ``cpu`` or ``cuda``.
    architecture
        Of the :class:`ViewClassifier`.
    """

    def __init__(
        self,
        places: Regions,
        recipe: TrainingSettings,
        seed: int,
        device: str = "cpu",
        **architecture: int,
    ):
        self.places, self.seed, self.device = places, seed, device
        torch.manual_seed(seed_for(seed, "weights", "judge") % 2**63)
        super().__init__(
            ViewClassifier(**architecture).to(device, memory_format=torch.channels_last), recipe
        )  # a fifth faster on a CPU

    def loss(self) -> Tensor:
        """Cross-entropy of what both views are found to show."""
        rng = generator(self.seed, "step", "judge", self.step)
        torch.manual_seed(seed_for(self.seed, "dropout", self.step) % 2**63)
        chosen = rng.integers(len(self.places.empty), size=self.recipe.batch_size)
        seen = torch.from_numpy(self.places.crop_regions[chosen]).to(self.device).float()
        empty = torch.from_numpy(self.places.empty[chosen]).to(self.device).float()
        mirrored, swapped = (
            torch.from_numpy(rng.uniform(size=len(chosen)) < 0.5).to(self.device) for _ in range(2)
        )
        seen = torch.where(mirrored[:, None, None, None], seen.flip(-1), seen)
        seen = torch.where(swapped[:, None, None, None], exchanged(seen), seen)
        empty = torch.where(swapped[:, None], empty.flip(1), empty)
        seen = torch.cat([_recoloured(seen[:, :6], rng), seen[:, 6:]], 1)
        with torch.autocast(self.device, torch.bfloat16, enabled=has_half_precision(self.device)):
            logits = self.model(seen.contiguous(memory_format=torch.channels_last))
        return functional.binary_cross_entropy_with_logits(logits.float(), empty)


def _recoloured(pictures: Tensor, rng: np.random.Generator) -> Tensor:
    """Both pictures, float (k, 6, h, w) in [-1, 1], with their colours in another order, and darker or brighter; 0 outside of them stays 0."""
    inside = (pictures != 0).any(1, keepdim=True)
    order = torch.from_numpy(rng.permutation(3)).to(pictures.device)
    light = torch.from_numpy(
        np.exp(rng.uniform(DIMMEST, BRIGHTEST, (len(pictures), 1, 1, 1))).astype(np.float32)
    ).to(pictures.device)
    return torch.where(
        inside, ((pictures[:, torch.cat([order, order + 3])] + 1) * light - 1).clamp(-1, 1), 0
    )

"""Training of a two-mask model by RAFT's recipe, on a CPU or a GPU.

AdamW with clipped gradients (:mod:`.trainer`), in mixed precision where the processor supports it.
Pairs are mirrored, exchanged and recoloured, alike in both pictures, and cropped and scaled as in
RAFT's own recipe. A step shows either whole pictures, or whole pictures at half the resolution,
or, of pairs in which something moved, crops of a quarter of the area around it, which cost a
quarter of the time. As RAFT is trained in stages, so is this: STAGES give the share of each, within
one cycle of the learning rate. Everything random follows from the seed and the step.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from ...seeding import generator, seed_for
from ..outcome import MOVED
from ..pair_files import Pairs
from ..predictor import MODELS, to_tensor
from .loss import mask_loss
from .trainer import Trainer, TrainingSettings, supports_bfloat16

CENTRED_FRACTION = 0.75
"""Fraction of crops around a pixel that moved; the others lie anywhere. Chosen."""
ENLARGED_FRACTION = 0.3
"""Fraction of crops that are smaller and enlarged, up to twice; chosen, since pictures with another
field of view show objects in other sizes too."""


class Stage(NamedTuple):
    """What a part of the training shows.

    Attributes
    ----------
    end : float
        Fraction of all steps at which the stage ends.
    full : float
        Fraction of its steps with whole pictures at full resolution.
    crop : float
        Fraction of its other steps with crops; the rest is at half the resolution.
    moved : float
        Fraction of pairs in which something moved, in steps without crops.
    """

    end: float
    full: float
    crop: float
    moved: float


STAGES = (Stage(0.45, 0.0, 0.6, 0.6), Stage(0.8, 0.4, 0.5, 0.6), Stage(1.0, 0.5, 0.35, 0.6))
"""Chosen by trials (docs/differences.md): first steps with a quarter of the pixels, at a quarter of
the cost; then more and more whole pictures, which alone show the outcome and large objects. Half
the resolution shows objects as small as a camera with twice the field of view does, and near ones
as a whole. Pairs in which something moved are the hardest, hence the most frequent."""


def get_stage(step: int, steps: int) -> Stage:
    """Return the stage of a step out of `steps`."""
    return next(stage for stage in STAGES if step < round(stage.end * steps))


class MaskTrainer(Trainer):
    """Trains a two-mask model on pairs.

    Parameters
    ----------
    name : str
        A key of MODELS.
    settings : TrainingSettings
    pairs : Pairs
    seed : int
    device : str
        ``cpu`` or ``cuda``.
    **architecture
        Arguments of the model.
    """

    def __init__(
        self,
        name: str,
        settings: TrainingSettings,
        pairs: Pairs,
        seed: int,
        device: str = "cpu",
        **architecture: Any,
    ):
        self.name = name
        self.pairs = pairs
        self.seed = seed
        self.device = device
        torch.manual_seed(seed_for(seed, "weights", name) % 2**63)
        super().__init__(MODELS[name](**architecture).to(device), settings)
        self._moved = np.nonzero(pairs.outcome == MOVED)[0]
        self._not_moved = np.nonzero(pairs.outcome != MOVED)[0]
        sizes = np.sqrt(pairs.masks[self._moved].sum((1, 2, 3)))
        self._moved_weights = sizes / sizes.sum()

    def compute_loss(self) -> Tensor:
        """Compute the loss of the current step's batch: float ()."""
        pictures, masks, moved = self._batch()
        with torch.autocast(self.device, torch.bfloat16, enabled=supports_bfloat16(self.device)):
            predictions = self.model(pictures[:, 0], pictures[:, 1])
        return mask_loss([logits.float() for logits in predictions], masks, moved)

    def _batch(self) -> tuple[Tensor, Tensor, Tensor]:
        """Pictures float (n, 2, 3, h, w), masks float (n, 2, h, w), and moved, bool (n,).

        `moved` is true if something moved and the batch, which may be cropped, shows it.
        """
        rng = generator(self.seed, "step", self.name, self.step)
        stage = get_stage(self.step, self.settings.steps)
        full = stage.full > 0 and rng.uniform() < stage.full
        crop = not full and rng.uniform() < stage.crop and len(self._moved) > 0
        indices = self._sample_pairs(1.0 if crop else stage.moved, rng)
        pictures, masks = augment(self.pairs.pictures[indices], self.pairs.masks[indices], rng)
        if crop:
            x, y = self._random_crops(pictures, masks, rng)
        else:
            x = to_tensor(pictures, self.device)
            y = torch.from_numpy(masks).to(self.device).float()
            if not full:
                x = F.avg_pool2d(x.flatten(0, 1), 2).unflatten(0, (-1, 2))
                y = F.avg_pool2d(y, 2)
        moved = torch.from_numpy(self.pairs.outcome[indices] == MOVED).to(self.device)
        return x, y, moved & (y > 0.5).flatten(1).any(1)

    def _sample_pairs(self, moved: float, rng: np.random.Generator) -> np.ndarray:
        """Draw the indices of a batch, int (n,), with a fraction `moved` of that outcome.

        Among those, the probability is proportional to the square root of the masks' area.
        """
        n = self.settings.batch_size
        if not len(self._moved) or not len(self._not_moved):
            return rng.choice(len(self.pairs.outcome), n)
        return np.where(
            rng.uniform(size=n) < moved,
            rng.choice(self._moved, n, p=self._moved_weights),
            rng.choice(self._not_moved, n),
        )

    def _random_crops(
        self, pictures: np.ndarray, masks: np.ndarray, rng: np.random.Generator
    ) -> tuple[Tensor, Tensor]:
        """Crop each pair to half the height and width, at the same place in both pictures.

        Some crops are smaller, and enlarged to that size.

        Parameters
        ----------
        pictures : uint8 (n, 2, h, w, 3)
        masks : bool (n, 2, h, w)
        rng : numpy.random.Generator

        Returns
        -------
        float (n, 2, 3, h / 2, w / 2), float (n, 2, h / 2, w / 2)
        """
        sides = masks.shape[2:]
        half = sides[0] // 2, sides[1] // 2
        xs, ys = [], []
        for picture, mask in zip(pictures, masks, strict=True):
            scale = rng.uniform(0.5, 1.0) if rng.uniform() < ENLARGED_FRACTION else 1.0
            extent = round(half[0] * scale), round(half[1] * scale)
            centre = rng.uniform(size=2) * sides
            changed = np.argwhere(mask.any(0))
            if len(changed) and rng.uniform() < CENTRED_FRACTION:
                centre = changed[rng.integers(len(changed))] + rng.uniform(-0.3, 0.3, 2) * extent
            top, left = (
                int(np.clip(c - n / 2, 0, side - n))
                for c, n, side in zip(centre, extent, sides, strict=True)
            )
            window = (slice(None), slice(top, top + extent[0]), slice(left, left + extent[1]))
            x = to_tensor(picture[window][None], self.device)[0]
            y = torch.from_numpy(mask[window]).to(self.device).float()
            if scale < 1:
                x = F.interpolate(x, half, mode="bilinear", align_corners=False)
                y = F.interpolate(y[None], half, mode="bilinear", align_corners=False)[0]
            xs.append(x)
            ys.append(y)
        return torch.stack(xs), torch.stack(ys)


def augment(
    pictures: np.ndarray, masks: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Mirror, exchange and recolour pairs at random.

    Colours change alike in both pictures of a pair, since a colour that differs is a change.

    Parameters
    ----------
    pictures : uint8 (n, 2, h, w, 3)
    masks : bool (n, 2, h, w)
    rng : numpy.random.Generator

    Returns
    -------
    uint8 (n, 2, h, w, 3), bool (n, 2, h, w)
    """
    pictures, masks = pictures.copy(), masks.copy()
    for i in range(len(pictures)):
        if rng.uniform() < 0.5:
            pictures[i] = pictures[i, :, :, ::-1].copy()
            masks[i] = masks[i, :, :, ::-1].copy()
        if rng.uniform() < 0.5:
            pictures[i] = pictures[i, ::-1].copy()
            masks[i] = masks[i, ::-1].copy()
        if rng.uniform() < 0.5:
            pictures[i] = pictures[i][..., rng.permutation(3)]
        exposure = math.exp(rng.uniform(-0.5, 0.25))  # other apartments are darker
        gain = exposure * rng.uniform(0.85, 1.2, 3)
        offset = rng.uniform(-15, 15, 3)
        pictures[i] = np.clip(pictures[i] * gain + offset, 0, 255)
    return pictures, masks

"""Training a two-mask model by RAFT's recipe, on a CPU or a GPU.

AdamW, gradients clipped (:mod:`.cycle`), mixed precision where the processor has it. Pairs are mirrored, exchanged and recoloured alike in both
pictures, and, as in RAFT's own recipe, cut out and scaled: a step takes whole pictures, or whole ones at half the resolution, or, of pairs in which
something moved, a quarter of each picture around it, which shows more of it in a quarter of the time. As RAFT is trained in stages, so is this:
STAGES say how much of each there is, within one cycle of the learning rate.
Everything random follows from the seed and the step, so a run that was resumed ends as one that was not.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from ...change_detection.pair_files import Pairs
from ...seeding import generator, seed_for
from ..outcome import MOVED
from ..predictor import MODELS, as_tensor
from .loss import mask_loss
from .trainer import Trainer, TrainingSettings, has_half_precision

AIMED, ENLARGED = 0.75, 0.3
"""Of what is cut out, how much is so around a pixel that moved, the rest being anywhere, and how much is smaller still and enlarged up to twice;
chosen: pictures with another field of view are enlarged too."""


class Stage(NamedTuple):
    """What is shown in a part of the training.

    Attributes
    ----------
    until : float
        Of all steps, where it ends.
    whole : float
        Of its steps, those with whole pictures.
    cut : float
        Of the others, those that are cut out; the rest is at half the resolution.
    moved : float
        Of the pairs that are not cut out, those in which something moved.
    """

    until: float
    whole: float
    cut: float
    moved: float


STAGES = (Stage(0.45, 0.0, 0.6, 0.6), Stage(0.8, 0.4, 0.5, 0.6), Stage(1.0, 0.5, 0.35, 0.6))
"""Chosen, as docs/differences.md tells: steps with a quarter of the pixels first, since they cost a quarter; then more and more whole pictures, which
alone show the outcome and large things. Half the resolution shows things as small as through a camera with twice the field of view, and what is
nearest and largest as a whole. What moved is harder to see than that nothing did."""


def stage_of(step: int, steps: int) -> Stage:
    """What a step, of so many, shows."""
    return next(stage for stage in STAGES if step < round(stage.until * steps))


class MaskTrainer(Trainer):
    """A model in training.

    Parameters
    ----------
    name : str
        A key of MODELS.
    recipe : TrainingSettings
    pairs : Pairs
        What it learns from.
    seed : int
    device : str
        ``cpu`` or ``cuda``.
    """

    def __init__(
        self,
        name: str,
        recipe: TrainingSettings,
        pairs: Pairs,
        seed: int,
        device: str = "cpu",
        **architecture: Any,
    ):
        self.name, self.pairs, self.seed, self.device = name, pairs, seed, device
        torch.manual_seed(seed_for(seed, "weights", name) % 2**63)
        super().__init__(MODELS[name](**architecture).to(device), recipe)
        self._moved, self._still = (
            np.nonzero(pairs.outcome == MOVED)[0],
            np.nonzero(pairs.outcome != MOVED)[0],
        )
        sizes = np.sqrt(pairs.masks[self._moved].sum((1, 2, 3)))
        self._chances = sizes / sizes.sum()

    def loss(self) -> Tensor:
        """That of the step at hand; outlines count where something moved."""
        pictures, masks, moved = self._batch()
        with torch.autocast(self.device, torch.bfloat16, enabled=has_half_precision(self.device)):
            refinements = self.model(pictures[:, 0], pictures[:, 1])
        return mask_loss([logits.float() for logits in refinements], masks, moved)

    def _batch(self) -> tuple[Tensor, Tensor, Tensor]:
        rng = generator(self.seed, "step", self.name, self.step)
        stage = stage_of(self.step, self.recipe.steps)
        whole = stage.whole > 0 and rng.uniform() < stage.whole
        cut = not whole and rng.uniform() < stage.cut and len(self._moved) > 0
        chosen = self._chosen(1.0 if cut else stage.moved, rng)
        pictures, masks = augmented(self.pairs.pictures[chosen], self.pairs.masks[chosen], rng)
        if cut:
            x, y = self._cut_out(pictures, masks, rng)
        else:
            x, y = as_tensor(pictures, self.device), torch.from_numpy(masks).to(self.device).float()
            if not whole:
                x, y = (
                    functional.avg_pool2d(x.flatten(0, 1), 2).unflatten(0, (-1, 2)),
                    functional.avg_pool2d(y, 2),
                )
        moved = torch.from_numpy(self.pairs.outcome[chosen] == MOVED).to(self.device)
        return x, y, moved & (y > 0.5).flatten(1).any(1)

    def _chosen(self, moved: float, rng: np.random.Generator) -> np.ndarray:
        """Numbers of the pairs of a step, int (n,), of which so many are such in which something moved; the larger, the more often."""
        n = self.recipe.batch_size
        if not len(self._moved) or not len(self._still):
            return rng.choice(len(self.pairs.outcome), n)
        return np.where(
            rng.uniform(size=n) < moved,
            rng.choice(self._moved, n, p=self._chances),
            rng.choice(self._still, n),
        )

    def _cut_out(
        self, pictures: np.ndarray, masks: np.ndarray, rng: np.random.Generator
    ) -> tuple[Tensor, Tensor]:
        """Of each pair the same part of both pictures, of half the height and width: float (n, 2, 3, h / 2, w / 2) and (n, 2, h / 2, w / 2)."""
        height, width = masks.shape[2:]
        sides = height // 2, width // 2
        found = []
        for picture, mask in zip(pictures, masks, strict=True):
            scale = rng.uniform(0.5, 1.0) if rng.uniform() < ENLARGED else 1.0
            rows, columns = (round(side * scale) for side in sides)
            middle = rng.uniform(size=2) * (height, width)
            somewhere = np.argwhere(mask.any(0))
            if len(somewhere) and rng.uniform() < AIMED:
                middle = somewhere[rng.integers(len(somewhere))] + rng.uniform(-0.3, 0.3, 2) * (
                    rows,
                    columns,
                )
            top, left = (
                int(np.clip(m - n / 2, 0, most - n))
                for m, n, most in zip(middle, (rows, columns), (height, width), strict=True)
            )
            part = (slice(None), slice(top, top + rows), slice(left, left + columns))
            x, y = (
                as_tensor(picture[part][None], self.device)[0],
                torch.from_numpy(mask[part]).to(self.device).float(),
            )
            if scale < 1:
                x = functional.interpolate(x, sides, mode="bilinear", align_corners=False)
                y = functional.interpolate(y[None], sides, mode="bilinear", align_corners=False)[0]
            found.append((x, y))
        return torch.stack([x for x, _ in found]), torch.stack([y for _, y in found])


def augmented(
    pictures: np.ndarray, masks: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Mirrored, exchanged, in other colours: each pair alike in both pictures, since a colour that changes is a change. uint8 and bool, as given."""
    pictures, masks = pictures.copy(), masks.copy()
    for i in range(len(pictures)):
        if rng.uniform() < 0.5:
            pictures[i], masks[i] = pictures[i, :, :, ::-1].copy(), masks[i, :, :, ::-1].copy()
        if rng.uniform() < 0.5:
            pictures[i], masks[i] = pictures[i, ::-1].copy(), masks[i, ::-1].copy()
        if rng.uniform() < 0.5:
            pictures[i] = pictures[i][..., rng.permutation(3)]
        gain, shift = (
            math.exp(rng.uniform(-0.5, 0.25)) * rng.uniform(0.85, 1.2, 3),
            rng.uniform(-15, 15, 3),
        )  # other homes are darker
        pictures[i] = np.clip(pictures[i] * gain + shift, 0, 255)
    return pictures, masks

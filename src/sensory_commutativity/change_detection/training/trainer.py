"""Training in one cycle of the learning rate (AdamW), which a kill sets back by a minute at most, and which then ends as if nothing had been."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor, nn
from tqdm import tqdm

from ...storage.checkpoints import Checkpoint

CLIP = 1.0
"""Largest norm of the gradient (RAFT)."""
WARM = 0.05
"""Of the steps, in which the learning rate rises (RAFT)."""
SAVED_EVERY = 45.0
"""Seconds between checkpoints: a kill loses so much."""


@dataclass(frozen=True)
class TrainingSettings:
    """How something is trained: examples shown, examples per step, highest learning rate, weight decay."""

    samples: int
    batch_size: int = 16
    learning_rate: float = 1e-3
    weight_decay: float = 1e-4

    @property
    def steps(self) -> int:
        return math.ceil(self.samples / self.batch_size)


def learning_rate(recipe: TrainingSettings, step: int) -> float:
    """Up along a line and down along half a cosine."""
    warm = max(1, round(WARM * recipe.steps))
    if step < warm:
        return recipe.learning_rate * (step + 1) / warm
    return (
        recipe.learning_rate
        * 0.5
        * (1 + math.cos(math.pi * (step - warm) / max(1, recipe.steps - warm)))
    )


class Trainer(ABC):
    """A network in training. Whatever is random in a step must follow from its number, :attr:`step`.

    Parameters
    ----------
    model : torch.nn.Module
    recipe : TrainingSettings
    """

    def __init__(self, model: nn.Module, recipe: TrainingSettings):
        self.model, self.recipe = model, recipe
        self.optimiser = torch.optim.AdamW(
            model.parameters(), lr=recipe.learning_rate, weight_decay=recipe.weight_decay, eps=1e-8
        )
        self.step = 0
        self.losses: list[float] = []

    @abstractmethod
    def loss(self) -> Tensor:
        """That of the model on what the step at hand shows: float ()."""

    @property
    def finished(self) -> bool:
        return self.step >= self.recipe.steps

    def advance(self) -> float:
        """One step; returns its loss."""
        for group in self.optimiser.param_groups:
            group["lr"] = learning_rate(self.recipe, self.step)
        self.model.train()
        loss = self.loss()
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(self.model.parameters(), CLIP)
        self.optimiser.step()
        self.step += 1
        self.losses.append(float(loss.detach()))
        return self.losses[-1]

    def state(self) -> dict[str, Any]:
        """Everything that a resumed run needs."""
        return dict(
            model=self.model.state_dict(),
            optimiser=self.optimiser.state_dict(),
            step=self.step,
            losses=torch.tensor(self.losses),
        )

    def resume(self, state: dict[str, Any]) -> None:
        """Go on from a state."""
        self.model.load_state_dict(state["model"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.step, self.losses = state["step"], state["losses"].tolist()


Row = dict[str, float]


def fit(
    cycle: Trainer,
    checkpoint: Checkpoint,
    name: str,
    stops: Sequence[int] = (),
    row: Callable[[list[Row]], Row] = lambda rows: {},
) -> list[Row]:
    """Train to the end, or go on with it where a run was killed.

    Parameters
    ----------
    cycle : Trainer
        At its first step.
    checkpoint : Checkpoint
        The caller takes it away once the result is written.
    name : str
        Of what is trained, for the bar of progress.
    stops : sequence of int
        Steps after which `row` is asked for a row, given those before it.

    Returns
    -------
    list
        The rows.
    """
    saved = checkpoint.load()
    rows: list[Row] = []
    if saved is not None:
        cycle.resume(saved)
        rows = saved["rows"]
    last = time.monotonic()
    with tqdm(
        total=cycle.recipe.steps, initial=cycle.step, desc=name, unit="step", disable=None
    ) as bar:
        while not cycle.finished:
            bar.set_postfix(loss=f"{cycle.advance():.3f}", refresh=False)
            bar.update()
            if cycle.step in stops:
                rows.append(row(rows))
            if cycle.step in stops or time.monotonic() - last > SAVED_EVERY:
                checkpoint.save({**cycle.state(), "rows": rows})
                last = time.monotonic()
    return rows


def has_half_precision(device: str) -> bool:
    """Whether bfloat16 is faster here than it is slow: on GPUs, and processors with instructions for it."""
    return device != "cpu" or bool(getattr(torch.cpu, "_is_avx512_bf16_supported", lambda: False)())

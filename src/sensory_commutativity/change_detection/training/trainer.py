"""Training by AdamW with one cycle of the learning rate, which can be interrupted and resumed.

A run that was resumed ends with the same weights as one that was not.
"""

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

CHECKPOINT_SECONDS = 45.0
"""Seconds between checkpoints, the most that an interruption costs; chosen."""

Row = dict[str, float]
"""A row of a training curve."""


@dataclass(frozen=True)
class TrainingSettings:
    """Settings of a training run.

    Attributes
    ----------
    samples : int
        Number of examples to show.
    batch_size : int
        Examples per step.
    learning_rate : float
        Highest learning rate.
    weight_decay : float
    warmup_fraction : float
        Fraction of the steps in which the learning rate rises (RAFT: 0.05).
    grad_clip : float
        Largest norm of the gradient (RAFT: 1).
    """

    samples: int
    batch_size: int = 16
    learning_rate: float = 1e-3
    weight_decay: float = 1e-4
    warmup_fraction: float = 0.05
    grad_clip: float = 1.0

    @property
    def steps(self) -> int:
        """Number of steps, the last of which may show more than `samples`."""
        return math.ceil(self.samples / self.batch_size)


def get_lr(settings: TrainingSettings, step: int) -> float:
    """Learning rate at a step, from 0: a linear rise, then half a cosine down to 0."""
    warmup = max(1, round(settings.warmup_fraction * settings.steps))
    if step < warmup:
        return settings.learning_rate * (step + 1) / warmup
    progress = math.pi * (step - warmup) / max(1, settings.steps - warmup)
    return settings.learning_rate * 0.5 * (1 + math.cos(progress))


class Trainer(ABC):
    """Trains a network; subclasses define the loss of a step.

    Everything random in a step must follow from its number, :attr:`step`, so that a resumed run
    repeats it.

    Parameters
    ----------
    model : torch.nn.Module
    settings : TrainingSettings

    Attributes
    ----------
    step : int
        Number of steps taken.
    losses : list of float
        Loss of each of them.
    """

    def __init__(self, model: nn.Module, settings: TrainingSettings):
        self.model = model
        self.settings = settings
        self.optimiser = torch.optim.AdamW(
            model.parameters(),
            lr=settings.learning_rate,
            weight_decay=settings.weight_decay,
            eps=1e-8,
        )
        self.step = 0
        self.losses: list[float] = []

    @abstractmethod
    def compute_loss(self) -> Tensor:
        """Compute the loss of the model on the batch of the current step: float ()."""

    @property
    def finished(self) -> bool:
        """Whether all steps have been taken."""
        return self.step >= self.settings.steps

    def fit(
        self,
        checkpoint: Checkpoint,
        name: str,
        evaluate_at: Sequence[int] = (),
        evaluate: Callable[[list[Row]], Row] = lambda rows: {},
    ) -> list[Row]:
        """Train to the end, from the first step or from a checkpoint of an interrupted run.

        Parameters
        ----------
        checkpoint : Checkpoint
            The caller deletes it once the result is written.
        name : str
            Label of the progress bar.
        evaluate_at : sequence of int
            Numbers of steps after which to call `evaluate`.
        evaluate : callable
            Maps the rows so far to the next row of the training curve.

        Returns
        -------
        list of Row
        """
        rows: list[Row] = []
        saved = checkpoint.load()
        if saved is not None:
            self.load_state_dict(saved)
            rows = saved["rows"]
        last_saved = time.monotonic()
        steps = self.settings.steps
        with tqdm(total=steps, initial=self.step, desc=name, unit="step", disable=None) as bar:
            while not self.finished:
                bar.set_postfix(loss=f"{self.advance():.3f}", refresh=False)
                bar.update()
                if self.step in evaluate_at:
                    rows.append(evaluate(rows))
                is_due = time.monotonic() - last_saved > CHECKPOINT_SECONDS
                if self.step in evaluate_at or is_due:
                    checkpoint.save({**self.state_dict(), "rows": rows})
                    last_saved = time.monotonic()
        return rows

    def advance(self) -> float:
        """Take one step and return its loss."""
        for group in self.optimiser.param_groups:
            group["lr"] = get_lr(self.settings, self.step)
        self.model.train()
        loss = self.compute_loss()
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(self.model.parameters(), self.settings.grad_clip)
        self.optimiser.step()
        self.step += 1
        self.losses.append(float(loss.detach()))
        return self.losses[-1]

    def state_dict(self) -> dict[str, Any]:
        """Return everything that a resumed run needs."""
        return dict(
            model=self.model.state_dict(),
            optimiser=self.optimiser.state_dict(),
            step=self.step,
            losses=torch.tensor(self.losses),
        )

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Continue from what :meth:`state_dict` returned."""
        self.model.load_state_dict(state["model"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.step = state["step"]
        self.losses = state["losses"].tolist()


def supports_bfloat16(device: str) -> bool:
    """Whether bfloat16 is fast on a device: on GPUs, and on CPUs with instructions for it."""
    return device != "cpu" or bool(getattr(torch.cpu, "_is_avx512_bf16_supported", lambda: False)())

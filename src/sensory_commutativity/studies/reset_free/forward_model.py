"""A forward model of an environment's sensors: an ensemble that predicts the next observation.

It is trained on babbling alone: random sequences of single degrees of freedom from random starts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from torch import nn

HIDDEN = 128
"""Units of each of two hidden layers. Chosen."""
BATCH = 256
LEARNING_RATE = 1e-3
"""Of Adam; falls to 0 along a cosine. Chosen."""
LARGEST = 6.0
"""Standard deviations to which inputs are clipped: what an open-loop prediction drifts to would
otherwise be worse with every step. Chosen."""


class Babbling(NamedTuple):
    """Recorded sequences.

    Attributes
    ----------
    observations : float (episodes, steps + 1, size)
        In units of each sensor's spread.
    commands : float (episodes, steps, m)
        What the robot knows of its own control at each step: the action, and the targets of its
        servos.
    """

    observations: np.ndarray
    commands: np.ndarray


class ForwardModel:
    """An ensemble of networks, each trained on a bootstrap sample of the episodes.

    Parameters
    ----------
    babbling : Babbling
    members, epochs : int
    seed : int
    """

    def __init__(self, babbling: Babbling, members: int, epochs: int, seed: int):
        torch.manual_seed(seed % 2**63)
        rng = np.random.default_rng(seed)
        observations = torch.from_numpy(babbling.observations.astype(np.float32))
        commands = torch.from_numpy(babbling.commands.astype(np.float32))
        x = torch.cat([observations[:, :-1], commands], dim=-1)
        y = observations[:, 1:] - observations[:, :-1]
        flat = x.reshape(-1, x.shape[-1])
        self._mean, self._std = flat.mean(dim=0), flat.std(dim=0).clamp(min=1e-3)
        self._scale = y.reshape(-1, y.shape[-1]).std(dim=0).clamp(min=1e-6)
        self._networks = []
        for _ in range(members):
            chosen = torch.from_numpy(rng.integers(len(x), size=len(x)))
            self._networks.append(self._train(x[chosen], y[chosen], epochs))

    def _normalise(self, x: torch.Tensor) -> torch.Tensor:
        return ((x - self._mean) / self._std).clamp(-LARGEST, LARGEST)

    def _train(self, x: torch.Tensor, y: torch.Tensor, epochs: int) -> nn.Module:
        x, y = (
            self._normalise(x).reshape(-1, x.shape[-1]),
            (y / self._scale).reshape(-1, y.shape[-1]),
        )
        network = nn.Sequential(
            nn.Linear(x.shape[1], HIDDEN), nn.SiLU(), nn.Linear(HIDDEN, HIDDEN), nn.SiLU(),
            nn.Linear(HIDDEN, y.shape[1]),
        )  # fmt: skip
        optimizer = torch.optim.Adam(network.parameters(), LEARNING_RATE)
        batches = max(1, len(x) // BATCH)
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, epochs * batches)
        for _ in range(epochs):
            order = torch.randperm(len(x))
            for batch in order[: batches * BATCH].split(BATCH):
                # Rare large changes are contacts: they must not rule the loss, nor be ignored.
                loss = nn.functional.smooth_l1_loss(network(x[batch]), y[batch])
                optimizer.zero_grad()
                loss.backward()
                optimizer.step()
                schedule.step()
        return network.eval()

    @torch.inference_mode()
    def imagine(self, start: np.ndarray, commands: np.ndarray) -> np.ndarray:
        """Observations at the end of sequences, predicted open-loop.

        Parameters
        ----------
        start : float (episodes, size)
            In units of each sensor's spread.
        commands : float (episodes, steps, m)

        Returns
        -------
        float64 (members, episodes, size)
        """
        known = torch.from_numpy(commands.astype(np.float32))
        ends = []
        for network in self._networks:
            now = torch.from_numpy(start.astype(np.float32))
            for t in range(known.shape[1]):
                x = self._normalise(torch.cat([now, known[:, t]], dim=-1))
                now = now + network(x) * self._scale
            ends.append(now.double().numpy())
        return np.stack(ends)

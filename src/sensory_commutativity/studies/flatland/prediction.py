"""The prediction-error alternative (paper, appendix A): how hard it is to predict what a degree of
freedom does to the sensors.

A feed-forward network takes sensors and action at time t and predicts the sensors at t + 1; its two
hidden layers are as wide as the input. What the paper leaves open (activation, optimizer and its
settings) is chosen in ``config/`` and explained in ``docs/differences.md``.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import nn

from ...progress import progress
from .config import BaselinesConfig
from .transitions import Transitions


def _inputs_and_targets(transitions: Transitions) -> tuple[torch.Tensor, torch.Tensor]:
    """Inputs float32 (n, pixels * 3 + n_dofs) and targets float32 (n, pixels * 3), colours in
    [0, 1]."""
    before, after = transitions.observations[:, :-1], transitions.observations[:, 1:]
    n = before.shape[0] * before.shape[1]
    sensors = torch.from_numpy(before.reshape(n, -1).astype(np.float32) / 255)
    actions = torch.from_numpy(transitions.actions.reshape(n, -1))
    return torch.cat([sensors, actions], 1), torch.from_numpy(
        after.reshape(n, -1).astype(np.float32) / 255
    )


def make_network(n_inputs: int, n_outputs: int) -> nn.Module:
    """Two hidden layers with as many units as there are inputs."""
    return nn.Sequential(
        nn.Linear(n_inputs, n_inputs),
        nn.ReLU(),
        nn.Linear(n_inputs, n_inputs),
        nn.ReLU(),
        nn.Linear(n_inputs, n_outputs),
    )


def prediction_error(transitions: Transitions, settings: BaselinesConfig, seed: int) -> np.ndarray:
    """Train on the first sequences and test on the rest.

    Whole sequences are for training or for testing, so that no test transition has a neighbour in
    the training set.

    Returns
    -------
    float64 (test sequences,)
        Mean squared error of the predicted observation, averaged over each test sequence; squared
        8-bit colour.
    """
    torch.set_num_threads(1)
    length = transitions.actions.shape[1]
    training = settings.training // length
    inputs, targets = _inputs_and_targets(
        Transitions(transitions.observations[:training], transitions.actions[:training])
    )
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = make_network(inputs.shape[1], targets.shape[1])
    shuffle = torch.Generator().manual_seed(seed)
    optimizer = torch.optim.Adam(network.parameters(), lr=settings.learning_rate)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, settings.epochs)
    for _ in progress(range(settings.epochs), "training the network", "epoch"):
        for chosen in torch.randperm(len(inputs), generator=shuffle).split(settings.batch_size):
            optimizer.zero_grad(set_to_none=True)
            nn.functional.mse_loss(network(inputs[chosen]), targets[chosen]).backward()
            optimizer.step()
        schedule.step()
    inputs, targets = _inputs_and_targets(
        Transitions(transitions.observations[training:], transitions.actions[training:])
    )
    with torch.no_grad():
        squared = ((network(inputs) - targets) * 255).square().mean(1)
    return squared.double().reshape(-1, length).mean(1).numpy()

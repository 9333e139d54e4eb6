"""The learner: PPO with a recurrent policy behind a 1-D convolution over what the eye sees (paper, section IV-B)."""

from __future__ import annotations

from typing import Any

import torch
from gymnasium import spaces
from sb3_contrib import RecurrentPPO
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from torch import nn

from ..studies.navigation.config import LearnerConfig
from .recurrent import RoomBuffer, RoomPolicy
from .rooms import Rooms


class ViewFeatures(BaseFeaturesExtractor):
    """Two 1-D convolutions and a linear layer: uint8 (n, pixels, 3) to float (n, features).

    The second is padded by one: without it the last four of 64 pixels would be seen by no filter.
    """

    def __init__(self, observation_space: spaces.Box, features: int):
        super().__init__(observation_space, features)
        pixels, colours = observation_space.shape
        convolutions = nn.Sequential(
            nn.Conv1d(colours, 16, 8, 4),
            nn.ReLU(),
            nn.Conv1d(16, 32, 4, 2, padding=1),
            nn.ReLU(),
            nn.Flatten(),
        )
        with torch.no_grad():
            n = convolutions(torch.zeros(1, colours, pixels)).shape[1]
        self.network = nn.Sequential(convolutions, nn.Linear(n, features), nn.ReLU())

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        return self.network(observations.transpose(1, 2) / 255)


class RoomPPO(RecurrentPPO):
    """RecurrentPPO that learns from minibatches of whole rooms."""

    def _setup_model(self) -> None:
        super()._setup_model()
        self.rollout_buffer = RoomBuffer(
            self.n_steps,
            self.observation_space,
            self.action_space,
            self.rollout_buffer.hidden_state_shape,
            self.device,
            gamma=self.gamma,
            gae_lambda=self.gae_lambda,
            n_envs=self.n_envs,
        )


def _policy_settings(settings: LearnerConfig) -> dict[str, Any]:
    return dict(
        features_extractor_class=ViewFeatures,
        features_extractor_kwargs=dict(features=settings.features),
        net_arch=[],
        lstm_hidden_size=settings.memory,
        enable_critic_lstm=False,  # the critic sees the features alone, which it helps to shape; an LSTM of its own would double the time
        log_std_init=settings.initial_log_std,
    )


def make_policy(
    observation_space: spaces.Box, action_space: spaces.Box, settings: LearnerConfig
) -> RoomPolicy:
    """A policy alone, to act with weights that a learner left."""
    return RoomPolicy(
        observation_space,
        action_space,
        lambda _: settings.learning_rate,
        **_policy_settings(settings),
    )


def make_learner(rooms: Rooms, settings: LearnerConfig, seed: int) -> RoomPPO:
    """A learner with fresh weights; `seed` in [0, 2**32) draws them."""
    learner = RoomPPO(
        RoomPolicy,
        rooms,
        n_steps=settings.rollout_steps,
        batch_size=settings.batch_size,
        n_epochs=settings.epochs,
        learning_rate=settings.learning_rate,
        gamma=settings.discount,
        gae_lambda=settings.gae_lambda,
        clip_range=settings.clip_range,
        ent_coef=settings.entropy_coefficient,
        vf_coef=settings.value_coefficient,
        max_grad_norm=settings.max_gradient_norm,
        policy_kwargs=_policy_settings(settings),
        seed=seed,
        device="cpu",
    )
    learner.set_logger(
        Logger(folder=None, output_formats=[])
    )  # else every segment leaves a folder in the system's temporary one
    return learner

"""The learner: recurrent PPO on features of a 1-D convolution (paper, section IV-B)."""

from __future__ import annotations

from typing import Any

import torch
from gymnasium import spaces
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from torch import nn

from .recurrent import SegmentedLstmPolicy, WholeRolloutPPO
from .sb3 import Sb3VecEnv
from .settings import LearnerSettings


class ViewFeatures(BaseFeaturesExtractor):
    """Feature extractor for one row of pixels: two 1-D convolutions and a linear layer.

    The second convolution is padded by one: otherwise no filter would cover the last four of 64
    pixels. Kernel sizes and channels are chosen (docs/differences.md).

    Parameters
    ----------
    observation_space : Box (n_pixels, n_channels), uint8
    features : int
        Number of outputs.
    """

    def __init__(self, observation_space: spaces.Box, features: int):
        super().__init__(observation_space, features)
        pixels, channels = observation_space.shape
        convolutions = nn.Sequential(
            nn.Conv1d(channels, 16, 8, 4),
            nn.ReLU(),
            nn.Conv1d(16, 32, 4, 2, padding=1),
            nn.ReLU(),
            nn.Flatten(),
        )
        with torch.no_grad():
            n = convolutions(torch.zeros(1, channels, pixels)).shape[1]
        self.network = nn.Sequential(convolutions, nn.Linear(n, features), nn.ReLU())

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Map pixels in [0, 255], (n, n_pixels, n_channels), to float (n, features)."""
        return self.network(observations.transpose(1, 2) / 255)


def _policy_arguments(settings: LearnerSettings) -> dict[str, Any]:
    return dict(
        features_extractor_class=ViewFeatures,
        features_extractor_kwargs=dict(features=settings.features),
        net_arch=[],
        lstm_hidden_size=settings.memory,
        # The critic acts on the features alone and helps to shape them; an LSTM of its own would
        # double the time.
        enable_critic_lstm=False,
        log_std_init=settings.initial_log_std,
    )


def make_policy(
    observation_space: spaces.Space, action_space: spaces.Space, settings: LearnerSettings
) -> SegmentedLstmPolicy:
    """Create a policy without a learner, to load trained weights into."""
    return SegmentedLstmPolicy(
        observation_space,
        action_space,
        lambda _: settings.learning_rate,
        **_policy_arguments(settings),
    )


def make_learner(environment: Sb3VecEnv, settings: LearnerSettings, seed: int) -> WholeRolloutPPO:
    """Create a learner with random weights drawn from `seed`, in [0, 2**32)."""
    learner = WholeRolloutPPO(
        SegmentedLstmPolicy,
        environment,
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
        policy_kwargs=_policy_arguments(settings),
        seed=seed,
        device="cpu",
    )
    # Without a logger of its own, every call of learn() creates a temporary folder.
    learner.set_logger(Logger(folder=None, output_formats=[]))
    return learner

"""Settings of the learner and of a training run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .task import NavigationTask


@dataclass(frozen=True)
class LearnerSettings:
    """Hyperparameters of recurrent PPO.

    The defaults are chosen; docs/differences.md describes how.

    Attributes
    ----------
    rooms : int
        Rooms that run in parallel, the sub-environments of a vector environment.
    rollout_steps : int
        Steps of each room between two updates.
    batch_size : int
        Transitions per gradient step: `rollout_steps` times a divisor of `rooms`, because a
        minibatch holds the whole rollouts of some rooms.
    epochs : int
        Passes over a rollout.
    learning_rate : float
        Of Adam.
    discount : float
        Gamma, in (0, 1).
    gae_lambda : float
        Lambda of generalised advantage estimation, in [0, 1].
    clip_range : float
        PPO clips the probability ratio to within this distance of 1.
    entropy_coefficient : float
        Weight of the entropy bonus.
    value_coefficient : float
        Weight of the value loss.
    max_gradient_norm : float
        Gradients with a larger norm are scaled down to it.
    features : int
        Outputs of the convolutional feature extractor.
    memory : int
        Units of the LSTM.
    initial_log_std : float
        Logarithm of the standard deviation of the initial action noise; actions lie in [-1, 1].
    reward_scale : float
        Factor applied to rewards for the learner, so that values stay near 1.
    """

    rooms: int = 32
    rollout_steps: int = 64
    batch_size: int = 512
    epochs: int = 4
    learning_rate: float = 1e-3
    discount: float = 0.99
    gae_lambda: float = 0.95
    clip_range: float = 0.2
    entropy_coefficient: float = 0.0
    value_coefficient: float = 0.5
    max_gradient_norm: float = 0.5
    features: int = 64
    memory: int = 64
    initial_log_std: float = -0.5
    reward_scale: float = 0.02

    def __post_init__(self) -> None:
        if self.batch_size % self.rollout_steps or self.rollout % self.batch_size:
            raise ValueError(
                f"batch_size {self.batch_size} must be rollout_steps {self.rollout_steps} times "
                f"a divisor of rooms {self.rooms}"
            )

    @property
    def rollout(self) -> int:
        """Environment steps between two updates, over all rooms."""
        return self.rooms * self.rollout_steps


@dataclass(frozen=True)
class TrainingRun:
    """One training run: an action space and a seed.

    Attributes
    ----------
    task : NavigationTask
    action_space : str
        Name of the action space; part of the key of all random streams.
    seed : int
        Number of the run, in [0, 2**64); part of the key of all random streams.
    scales : mapping of str to float
        Degree of freedom -> scale in [0, 1], in the order of the actions: see
        :func:`.action_spaces.action_scales`.
    learner : LearnerSettings
    steps : int
        Environment steps of the whole run: a multiple of `checkpoints` times `learner.rollout`.
    checkpoints : int
        Number of segments. Each ends with an evaluation and a checkpoint.
    evaluation_seeds : tuple of int
        Seeds of the evaluation episodes, the same at every checkpoint.
    root_seed : int
        Root of the random streams of the run; see :mod:`sensory_commutativity.seeding`.
    settings : str
        Describes all settings of the run. It is stored with the trained policy and compared when
        the policy is loaded.
    """

    task: NavigationTask
    action_space: str
    seed: int
    scales: Mapping[str, float]
    learner: LearnerSettings
    steps: int
    checkpoints: int
    evaluation_seeds: tuple[int, ...]
    root_seed: int
    settings: str = ""

    def __post_init__(self) -> None:
        segment = self.checkpoints * self.learner.rollout
        if self.steps % segment:
            raise ValueError(
                f"steps {self.steps} must be a multiple of checkpoints {self.checkpoints} times "
                f"the learner's rollout of {self.learner.rollout} steps"
            )

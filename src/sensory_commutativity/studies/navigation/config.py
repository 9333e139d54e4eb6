"""Settings of learning to navigate (paper, section IV-B)."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...storage.settings import Name, Section

ActionSpace = Literal["full", "truncated", "adapted", "base-random", "random-half", "inverse"]
PAPER_SPACES = ("full", "truncated", "adapted")
Measure = Literal["final_return", "auc", "success_rate", "steps_to_threshold"]


class ZoneConfig(Section):
    """A disc on the floor that ends the episode when the agent's base touches it."""

    x: float = Field(ge=0, le=5000, description="Center, units.")
    y: float = Field(ge=0, le=5000, description="Center, units.")
    radius: float = Field(gt=0, le=1000, description="Units.")
    reward: float = Field(
        ge=-1000,
        le=1000,
        description="Above 0 for the goal (paper: 50), below 0 for a dead zone (paper: -20).",
    )

    @model_validator(mode="after")
    def _check_reward(self) -> ZoneConfig:
        if self.reward == 0:
            raise ValueError("a zone's reward must be above 0 (goal) or below 0 (dead zone), not 0")
        return self


class LearnerConfig(Section):
    """Recurrent PPO, the same for every action space."""

    rooms: int = Field(32, ge=1, le=1024, description="Rooms that are simulated in parallel.")
    rollout_steps: int = Field(
        64, ge=4, le=4096, description="Steps of every room between two updates."
    )
    batch_size: int = Field(
        512,
        ge=4,
        le=1_000_000,
        description="Transitions per gradient step: those of a whole number of rooms.",
    )
    epochs: int = Field(4, ge=1, le=100, description="Passes over a rollout.")
    learning_rate: float = Field(1e-3, gt=0, le=1, description="Of Adam.")
    discount: float = Field(
        0.99, gt=0, lt=1, description="Gamma: what a reward one step later is worth."
    )
    gae_lambda: float = Field(
        0.95, ge=0, le=1, description="Lambda of generalized advantage estimation."
    )
    clip_range: float = Field(
        0.2, gt=0, le=1, description="PPO's clipping of the probability ratio."
    )
    entropy_coefficient: float = Field(0.0, ge=0, le=1, description="Weight of the entropy bonus.")
    value_coefficient: float = Field(0.5, ge=0, le=10, description="Weight of the value loss.")
    max_gradient_norm: float = Field(
        0.5, gt=0, le=100, description="Gradients are clipped to this norm."
    )
    features: int = Field(64, ge=1, le=4096, description="Outputs of the convolutional extractor.")
    memory: int = Field(64, ge=1, le=4096, description="Units of the LSTM.")
    initial_log_std: float = Field(
        -0.5,
        ge=-5,
        le=2,
        description="Logarithm of the action noise at the start; actions lie in [-1, 1].",
    )
    reward_scale: float = Field(
        0.02,
        gt=0,
        le=1000,
        description="Rewards are multiplied by it for the learner, so that values stay near 1.",
    )

    @property
    def rollout(self) -> int:
        """Environment steps between two updates."""
        return self.rooms * self.rollout_steps

    @model_validator(mode="after")
    def _check_batches(self) -> LearnerConfig:
        if self.batch_size % self.rollout_steps or self.rollout % self.batch_size:
            raise ValueError(
                f"batch_size {self.batch_size} must be rollout_steps {self.rollout_steps} times a "
                f"number of rooms that divides rooms {self.rooms}: a minibatch is the whole "
                "rollout of some rooms"
            )
        return self


class NavigationConfig(Section):
    """The comparison of action spaces on one task."""

    world: Name = Field("arena", description="A key of flatland.worlds: the room of the task.")
    agent: Name = Field(
        "sprinter",
        description="A key of flatland.agents: the agent that learns, whose SCP determines the "
        "action spaces.",
    )
    scp_world: Name = Field(
        "furnished", description="A key of flatland.worlds: where that agent's SCP is measured."
    )
    zones: list[ZoneConfig] = Field(
        min_length=1, max_length=32, description="What ends an episode; one goal at least."
    )
    max_episode_steps: int = Field(
        150, ge=1, le=100_000, description="Episodes are truncated after so many steps."
    )
    action_spaces: list[ActionSpace] = Field(
        min_length=3,
        description="full, truncated and adapted, which the paper compares, and any of the "
        "controls base-random, random-half and inverse.",
    )
    seeds: list[Annotated[int, Field(ge=0, lt=2**32)]] = Field(
        min_length=4, description="A training run of every action space for each of them."
    )
    steps: int = Field(
        ge=1,
        le=1_000_000_000,
        description="Environment steps of a run: a multiple of checkpoints x rooms x "
        "rollout_steps.",
    )
    checkpoints: int = Field(
        ge=2,
        le=1000,
        description="Evaluations of a run, equally far apart; the last one gives the final scores.",
    )
    evaluation_episodes: int = Field(
        ge=2,
        le=100_000,
        description="Deterministic episodes of an evaluation; the same starts for every run.",
    )
    threshold_return: float = Field(
        25.0,
        description="A run has learned the task at its first evaluation with this mean return.",
    )
    sensitivity_thresholds: list[float] = Field(
        [10.0, 35.0, 45.0],
        max_length=20,
        description="Other threshold returns at which the steps are compared; they decide nothing "
        "alone.",
    )
    confirmation_seeds: int = Field(
        0,
        ge=0,
        description="The last so many seeds were drawn after the data of the others had been "
        "looked at; they are also compared alone.",
    )
    solved_success_rate: float = Field(
        0.9,
        gt=0,
        le=1,
        description="A run has solved the task if its last evaluation reaches the goal so often.",
    )
    primary_measure: Measure = Field(
        "final_return", description="The score that decides; a key of the table navigation_scores."
    )
    alpha: float = Field(
        0.05, gt=0, lt=0.5, description="Level of the tests, for each family of pairs together."
    )
    calibration_splits: int = Field(
        2000,
        ge=10,
        le=1_000_000,
        description="Pairs of groups made from the same runs that are compared (A/A).",
    )
    learner: LearnerConfig = Field(default_factory=LearnerConfig)

    @model_validator(mode="after")
    def _check_steps(self) -> NavigationConfig:
        segment = self.checkpoints * self.learner.rollout
        if self.steps % segment:
            remedy = max(1, round(self.steps / segment)) * segment
            raise ValueError(
                f"steps {self.steps} is no multiple of {segment} (checkpoints {self.checkpoints} "
                f"x learner.rooms {self.learner.rooms} x learner.rollout_steps "
                f"{self.learner.rollout_steps}); set it to {remedy}"
            )
        return self

    @model_validator(mode="after")
    def _check_consistency(self) -> NavigationConfig:
        lists: dict[str, list] = {"seeds": self.seeds, "action_spaces": self.action_spaces}
        for key, values in lists.items():
            twice = sorted({str(value) for value in values if values.count(value) > 1})
            if twice:
                raise ValueError(
                    f"{key} holds {', '.join(twice)} more than once; remove what is repeated"
                )
        if self.confirmation_seeds and not 4 <= self.confirmation_seeds <= len(self.seeds) - 4:
            raise ValueError(
                f"confirmation_seeds {self.confirmation_seeds} leaves less than four of the "
                f"{len(self.seeds)} seeds on a side; set 0, or 4 to {max(4, len(self.seeds) - 4)}"
            )
        missing = [name for name in PAPER_SPACES if name not in self.action_spaces]
        if missing:
            raise ValueError(
                f"action_spaces lacks {', '.join(missing)}, which the paper compares; add it"
            )
        if not any(zone.reward > 0 for zone in self.zones):
            raise ValueError("zones holds no goal; give one a reward above 0")
        best = max(zone.reward for zone in self.zones)
        if self.threshold_return > best:
            raise ValueError(
                f"threshold_return {self.threshold_return:g} is more than the best reward "
                f"{best:g}; set it lower"
            )
        for i, one in enumerate(self.zones):
            for other in self.zones[:i]:
                if math.hypot(one.x - other.x, one.y - other.y) < one.radius + other.radius:
                    raise ValueError(
                        f"zones: the one at ({one.x:g}, {one.y:g}) overlaps the one at "
                        f"({other.x:g}, {other.y:g}); move or shrink one of them"
                    )
        return self

    @property
    def runs(self) -> list[tuple[str, int]]:
        """(action space, seed) of every training run."""
        return [(action_space, seed) for action_space in self.action_spaces for seed in self.seeds]

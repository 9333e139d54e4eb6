"""Settings of SC-experiments as on a real robot: without a reset, under noise, and imagined."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...storage.settings import NO_EFFECT, Name, Section
from ..atlas.config import EnvironmentConfig

Experiments = Annotated[int, Field(ge=2, le=1_000_000)]
Level = Annotated[float, Field(gt=0)]


class TrialsConfig(Section):
    """Trials of the return protocol in Flatland, each with the true outcome."""

    world: Name = Field(description="A key of flatland.worlds.")
    lives: int = Field(ge=2, le=1_000_000, description="Resets of the world.")
    trials: int = Field(
        1, ge=1, le=10_000,
        description="Trials of every degree of freedom between two resets. With 1, all degrees of "
        "freedom are tried from the same start; with more, one after the other, without any reset.",
    )  # fmt: skip

    @property
    def experiments(self) -> int:
        """Trials of every degree of freedom."""
        return self.lives * self.trials


class ApartmentTrialsConfig(Section):
    """Trials of the return protocol of a robot in an apartment."""

    robot: Name = Field("fetch", description="A key of apartment.robots.")
    scene: Name = Field("rs-stand-in", description="A key of apartment.scenes.")
    experiments: Experiments = Field(description="Start situations.")


class NoiseConfig(Section):
    """Noise from mild to strong, in a room where nothing moves by itself."""

    world: Name = Field("settled", description="A key of flatland.worlds.")
    sensor: list[Level] = Field(
        [1.0, 4.0, 16.0, 64.0], description="Standard deviations of a colour, of 255."
    )
    actuator: list[Level] = Field(
        [0.003, 0.01, 0.03, 0.1], description="Standard deviations of a motion, as a share of it."
    )
    reset: list[Level] = Field(
        [0.01, 0.03, 0.1, 0.3],
        description="Standard deviations of every coordinate of the start pose, in actions of 1.",
    )
    protocols: list[Literal["reset", "return"]] = Field(
        ["reset", "return"], min_length=1, description="Protocols under which noise is tried."
    )
    quantile: float = Field(
        0.95, gt=0.5, lt=1,
        description="Of the distances of the same order played twice: the calibrated threshold.",
    )  # fmt: skip
    experiments: Experiments = Field(description="Starts at every level.")


class SequentialConfig(Section):
    """Sampling until the order of the degrees of freedom is decided."""

    alpha: float = Field(0.05, gt=0, lt=1, description="Largest probability of any wrong decision.")
    margin: float = Field(
        0.05, gt=0, lt=1, description="Differences of SCPs below this count as a tie."
    )
    largest: int = Field(5000, ge=10, le=100_000, description="Largest number of starts.")
    runs: int = Field(2000, ge=10, le=100_000, description="Simulated runs of every case.")
    power: float = Field(
        0.9, gt=0, lt=1,
        description="Share of runs in which a fixed number of starts must decide as much.",
    )  # fmt: skip


class ImaginedConfig(EnvironmentConfig):
    """An environment whose second orders a forward model imagines."""

    sequences: int = Field(
        ge=20, le=100_000, description="Random sequences, the babbling that trains the model."
    )
    experiments: Experiments = Field(description="Starts at which the model is judged.")
    members: int = Field(3, ge=1, le=20, description="Networks of the ensemble.")
    epochs: int = Field(20, ge=1, le=1000, description="Passes over the babbling.")
    threshold: float = Field(
        0.1, ge=0, description="Of the true distance, in units of the sensors' spread."
    )
    quantile: float = Field(
        0.95, gt=0.5, lt=1,
        description="Of the model's error on the order that was played: the calibrated threshold.",
    )  # fmt: skip


class ResetFreeConfig(Section):
    """SC-experiments on a real robot: without a reset, under noise, and imagined."""

    agent: Name = Field("polyphemus", description="A key of flatland.agents.")
    thresholds: list[Annotated[float, Field(ge=0)]] = Field(
        [0.0, 1.0, 10.0, 100.0], min_length=1,
        description="Largest distances that count as equal in Flatland, squared 8-bit colour.",
    )  # fmt: skip
    flatland: dict[Name, TrialsConfig] = Field(min_length=1)
    apartment: dict[Name, ApartmentTrialsConfig] = Field(min_length=1)
    noise: NoiseConfig
    sequential: SequentialConfig
    imagined: dict[Name, ImaginedConfig] = Field(min_length=1)
    lives_per_job: int = Field(
        1000, ge=1, le=1_000_000, description="Lives in a job; changes no result.",
        json_schema_extra=NO_EFFECT,
    )  # fmt: skip
    experiments_per_job: int = Field(
        25, ge=1, le=1_000_000,
        description="Start situations in apartments in a job; changes no result.",
        json_schema_extra=NO_EFFECT,
    )  # fmt: skip

    @model_validator(mode="after")
    def _check_names(self) -> ResetFreeConfig:
        both = set(self.flatland) & set(self.apartment)
        if both:
            raise ValueError(
                f"flatland and apartment both have a key {min(both)!r}; rename one of them"
            )
        if len(set(self.thresholds)) < len(self.thresholds) or 0.0 not in self.thresholds:
            raise ValueError(
                f"thresholds {self.thresholds} must hold 0.0, the paper's, and no number twice"
            )
        return self

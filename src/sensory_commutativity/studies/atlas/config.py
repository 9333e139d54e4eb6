"""Settings of the atlas: the SCP of standard environments."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ...storage.settings import NO_EFFECT, Name, Section


class EnvironmentConfig(Section):
    """An environment of the atlas."""

    env_id: str = Field(min_length=1, max_length=100, description="Name in Gymnasium's registry.")
    family: str = Field("", max_length=40, description="Heading in the figure.")
    control: Literal["auto", "direct", "increments", "servo"] = Field(
        "auto", description="How actions become commands."
    )
    snapshots: Literal["auto", "native", "replay", "fork"] = Field(
        "auto", description="How its state is restored."
    )
    starts: Annotated[int, Field(ge=2, le=100_000)] | None = Field(
        None, description="Start situations; by default those of the section."
    )
    length: int = Field(20, ge=1, le=1000, description="Actions in a sequence.")
    rest_steps: int = Field(
        40, ge=0, le=1000, description="Most steps of rest at the end of an order."
    )
    avoid_stops: bool = Field(
        True, description="Whether sequences are scaled so that they reach no joint's stop."
    )
    sensors: list[str] | None = Field(
        None, description="Keys of the observation; world: those that move by contact alone."
    )
    approach: Literal["random", "fetch"] = Field(
        "random", description="Way to a start: random actions, or a script to near the object."
    )


class LearningConfig(Section):
    """PPO with the planar arm, in the action spaces that its SCPs make."""

    starts: Annotated[int, Field(ge=2, le=100_000)] = Field(
        500, description="Start situations of the SC-experiments with the arm."
    )
    length: int = Field(20, ge=1, le=1000, description="Actions in a sequence.")
    threshold: float = Field(
        0.01, ge=0, description="Largest distance that counts as equal, in units of the spread."
    )
    action_spaces: list[Literal["full", "truncated", "adapted", "random-half", "inverse"]] = Field(
        ["full", "truncated", "adapted", "random-half"], min_length=2,
        description="Action spaces in which PPO learns; the first is the one compared with.",
    )  # fmt: skip
    seeds: int = Field(20, ge=2, le=1000, description="Training runs per action space.")
    steps: int = Field(61_440, ge=1, description="Steps of a training run: 30 rollouts of PPO.")
    evaluations: int = Field(
        10, ge=1, le=1000, description="Evaluations of a run after its start, evenly spaced."
    )
    evaluation_episodes: int = Field(20, ge=1, le=10_000, description="Episodes of an evaluation.")


class AtlasConfig(Section):
    """The SCP of standard environments."""

    starts: Annotated[int, Field(ge=2, le=100_000)] = Field(
        200, description="Start situations of an environment that does not set its own."
    )
    thresholds: list[Annotated[float, Field(ge=0)]] = Field(
        [0.001, 0.01, 0.1], min_length=1,
        description="Largest distances that count as equal, in units of the sensors' spread.",
    )  # fmt: skip
    main_threshold: float = Field(
        0.1, description="The one of the figure and of the verdicts in the text."
    )
    exactness_tries: int = Field(
        100, ge=1, le=10_000, description="Tries of every way to restore the state."
    )
    environments: dict[Name, EnvironmentConfig] = Field(min_length=1)
    starts_per_job: int = Field(
        100, ge=1, le=100_000, description="Starts in a job; changes no result.",
        json_schema_extra=NO_EFFECT,
    )  # fmt: skip
    learning: LearningConfig = LearningConfig()
    runs_per_job: int = Field(
        5, ge=1, le=1000, description="Training runs in a job; changes no result.",
        json_schema_extra=NO_EFFECT,
    )  # fmt: skip

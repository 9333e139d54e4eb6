"""Settings of Flatland (paper, section III-A and appendices A and B)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, NamedTuple

from pydantic import Field, model_validator

from ...storage.settings import NO_EFFECT, Name, Section, check_defined

Experiments = Annotated[int, Field(ge=2, le=1_000_000)]
Length = Annotated[int, Field(ge=1, le=2000)]


class AgentConfig(Section):
    """How an agent differs from the standard Polyphemus. An empty section is the standard one."""

    arm_length: float = Field(
        50.0, gt=0, le=150,
        description="Length of each of an arm's two segments, units (authors: 50).",
    )  # fmt: skip
    longitudinal_speed: float = Field(
        8.0, gt=0, le=30, description="How far an action of 1 moves the base in one step, units."
    )
    angular_speed: float = Field(
        0.25, gt=0, le=0.5,
        description="How far an action of 1 turns base, head or joint, rad (authors: 0.25).",
    )  # fmt: skip
    joint_range_degrees: float | None = Field(
        None, gt=0, le=360,
        description="Stops of the arm joints, either way from rest, degrees; null for none "
        "(authors: 60).",
    )  # fmt: skip


class WorldConfig(Section):
    """A kind of room. Every experiment draws its own start situation."""

    objects: int = Field(
        10, ge=0, le=24,
        description="Objects in the room; of every four, one is fixed, two are movable, one moves "
        "by itself.",
    )  # fmt: skip
    walls: bool = Field(
        True, description="False: unbounded space; the walls are then visible but not solid."
    )
    width: float = Field(600.0, ge=200, le=5000, description="Units (authors: 600).")
    height: float = Field(800.0, ge=200, le=5000, description="Units (authors: 800).")
    start_margin: float = Field(
        150.0, ge=40, le=1000,
        description="Least distance between the agent's center and any wall at the start, units.",
    )  # fmt: skip
    path_speed: float = Field(
        2.0, ge=0, le=20, description="Speed of objects that move by themselves, units per step."
    )

    @model_validator(mode="after")
    def _check_start(self) -> WorldConfig:
        shorter = min(self.width, self.height)
        if 2 * self.start_margin >= shorter:
            raise ValueError(
                f"start_margin {self.start_margin:g} leaves no place to start in a room of "
                f"{self.width:g} x {self.height:g}; set it below {shorter / 2:g}"
            )
        return self


class ReferenceConfig(Section):
    """The SCP of every degree of freedom, the paper's main figure in 2-D."""

    world: Name = Field("furnished", description="A key of flatland.worlds.")
    agent: Name = Field("polyphemus", description="A key of flatland.agents.")
    experiments: Experiments = Field(description="SC-experiments per degree of freedom.")


class GroupConfig(Section):
    """Every agent in every world."""

    worlds: list[Name] = Field(min_length=1, description="Keys of flatland.worlds.")
    agents: list[Name] = Field(min_length=1, description="Keys of flatland.agents.")
    experiments: Experiments = Field(description="SC-experiments per degree of freedom.")


class SensitivityConfig(Section):
    """Other sequence lengths, in the reference world with the reference agent."""

    lengths: list[Length] = Field(min_length=1, description="Numbers of actions.")
    experiments: Experiments = Field(description="SC-experiments per degree of freedom and length.")


class CommutationConfig(Section):
    """Philipona's conjecture: does a sequence of one degree of freedom commute with another's?

    Tried in the reference world, and in one where nothing moves by itself and everything has time
    to come to rest.
    """

    experiments: Experiments = Field(
        description="Experiments per pair of degrees of freedom and world."
    )
    settled_world: Name = Field(
        "settled", description="A key of flatland.worlds, with path_speed 0."
    )
    settled_rest_steps: int = Field(
        100, ge=0, le=1000,
        description="Steps without a command that end each order in that world; pushed objects "
        "coast.",
    )  # fmt: skip


class BaselinesConfig(Section):
    """The paper's two alternatives to the SCP (appendix A)."""

    transitions: int = Field(
        ge=100, le=10_000_000, description="Transitions per degree of freedom (paper: 100,000)."
    )
    training: int = Field(
        ge=50, le=10_000_000,
        description="How many of them train the network; the rest test it (paper: 80,000).",
    )  # fmt: skip
    epochs: int = Field(
        20, ge=1, le=1000, description="Passes over the training transitions (the paper is silent)."
    )
    batch_size: int = Field(
        256, ge=1, le=100_000, description="Transitions per gradient step (the paper is silent)."
    )
    learning_rate: float = Field(1e-3, gt=0, le=1, description="Of Adam (the paper is silent).")

    @model_validator(mode="after")
    def _check_split(self) -> BaselinesConfig:
        if self.training >= self.transitions:
            raise ValueError(
                f"training {self.training} leaves none of {self.transitions} transitions to test; "
                "set it lower"
            )
        return self


class Run(NamedTuple):
    """SC-experiments of all degrees of freedom of an agent in a world."""

    world: str
    agent: str
    length: int
    experiments: int


class FlatlandConfig(Section):
    """Everything in two dimensions."""

    sequence_length: Length = Field(50, description="Actions in a sequence (authors: 50).")
    rest_steps: int = Field(
        3, ge=0, le=100, description="Steps without a command that end each sequence."
    )
    thresholds: list[Annotated[float, Field(ge=0)]] = Field(
        [0.0, 1.0, 10.0, 100.0, 1000.0], min_length=1,
        description="Largest distances that count as equal, squared 8-bit colour; must include 0, "
        "the paper's.",
    )  # fmt: skip
    agents: dict[Name, AgentConfig] = Field(min_length=1)
    worlds: dict[Name, WorldConfig] = Field(min_length=1)
    reference: ReferenceConfig
    free_space: GroupConfig
    combinations: GroupConfig
    variants: GroupConfig
    sensitivity: SensitivityConfig
    commutation: CommutationConfig
    baselines: BaselinesConfig
    equivalence_margin: float = Field(
        0.02, gt=0, lt=1,
        description="Left and right count as equal if tests show that their SCPs differ by less; "
        "chosen when the committed run was known: no smaller difference can be read from the bars "
        "in the paper.",
    )  # fmt: skip
    experiments_per_job: int = Field(
        2500,
        ge=1,
        le=1_000_000,
        description="Experiments in a job; changes no result.",
        json_schema_extra=NO_EFFECT,
    )

    @model_validator(mode="after")
    def _check_names(self) -> FlatlandConfig:
        for section in ("free_space", "combinations", "variants"):
            group: GroupConfig = getattr(self, section)
            for kind, names in (("worlds", group.worlds), ("agents", group.agents)):
                for name in names:
                    check_defined(
                        name, getattr(self, kind), f"{section}.{kind}", f"flatland.{kind}"
                    )
                if len(set(names)) < len(names):
                    raise ValueError(f"{section}.{kind} names one of {names} twice; remove one")
        check_defined(self.reference.world, self.worlds, "reference.world", "flatland.worlds")
        check_defined(self.reference.agent, self.agents, "reference.agent", "flatland.agents")
        settled = self.commutation.settled_world
        check_defined(settled, self.worlds, "commutation.settled_world", "flatland.worlds")
        if self.worlds[settled].path_speed or settled == self.reference.world:
            raise ValueError(
                f"commutation.settled_world names {settled!r}; choose a world with path_speed: 0.0 "
                "that is not the reference world"
            )
        for name in self.free_space.worlds:
            if self.worlds[name].walls or self.worlds[name].objects:
                raise ValueError(
                    f"free_space.worlds names {name!r}, which has walls or objects; give it "
                    "walls: false and objects: 0"
                )
        return self

    @model_validator(mode="after")
    def _check_numbers(self) -> FlatlandConfig:
        lengths = self.sensitivity.lengths
        for key, values in (("thresholds", self.thresholds), ("sensitivity.lengths", lengths)):
            if len(set(values)) < len(values):
                raise ValueError(f"{key} holds a number twice in {values}; remove one")
        if self.sensitivity.experiments > self.reference.experiments:
            raise ValueError(
                f"sensitivity.experiments {self.sensitivity.experiments} is more than "
                f"reference.experiments {self.reference.experiments}, from which the main length "
                "is taken; set it no higher"
            )
        if self.sequence_length in lengths:
            raise ValueError(
                f"sensitivity.lengths holds the main sequence_length {self.sequence_length}, "
                "which is always included; remove it"
            )
        baselines = self.baselines
        if (
            baselines.transitions % self.sequence_length
            or baselines.training % self.sequence_length
        ):
            raise ValueError(
                "baselines.transitions and baselines.training must be multiples of sequence_length "
                f"{self.sequence_length}: whole sequences are for training or for testing"
            )
        if 0.0 not in self.thresholds:
            raise ValueError(
                "thresholds must hold 0.0, the threshold of the paper's 2-D results; add it"
            )
        runs = [run[:3] for run in self.runs()]
        for run in runs:
            if runs.count(run) > 1:
                raise ValueError(
                    f"{run[1]!r} in {run[0]!r} is asked for by two sections; leave it out of one"
                )
        return self

    @property
    def commutation_per_job(self) -> int:
        """Commutation experiments in a job.

        Each plays the 36 pairs of 8 degrees of freedom, about ten times the work of an
        SC-experiment.
        """
        return max(1, self.experiments_per_job // 10)

    def commutation_worlds(self) -> dict[str, int]:
        """Worlds of the commutation experiments -> steps of rest that end each order there."""
        commutation = self.commutation
        return {
            self.reference.world: self.rest_steps,
            commutation.settled_world: commutation.settled_rest_steps,
        }

    def runs(self) -> list[Run]:
        """All SC-experiments, in the order of the sections."""
        return list(self._runs())

    def _runs(self) -> Iterator[Run]:
        reference, length = self.reference, self.sequence_length
        yield Run(reference.world, reference.agent, length, reference.experiments)
        for group in (self.free_space, self.combinations, self.variants):
            for world in group.worlds:
                for agent in group.agents:
                    yield Run(world, agent, length, group.experiments)
        for other in self.sensitivity.lengths:
            yield Run(reference.world, reference.agent, other, self.sensitivity.experiments)

"""Settings of robots in apartments (paper, sections III-B and III-C, appendix C)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, NamedTuple

from pydantic import Field, model_validator

from ...storage.settings import NO_EFFECT, Name, Section, check_defined

Start = Literal["anywhere", "within-reach"]
Experiments = Annotated[int, Field(ge=2, le=1_000_000)]
Length = Annotated[int, Field(ge=1, le=2000)]


class RobotConfig(Section):
    """A robot."""

    description: str = Field(
        min_length=1,
        description="YAML file that names its URDF, degrees of freedom, camera and start pose.",
    )


class SceneConfig(Section):
    """A scene; without a file, an unbounded empty floor."""

    file: str | None = Field(
        None, description="YAML file: a floor plan, or a mesh file with movable objects."
    )


class ApartmentReferenceConfig(Section):
    """The robot and the scene of the main figure."""

    robot: Name = Field(description="A key of apartment.robots.")
    scene: Name = Field(description="A key of apartment.scenes.")
    threshold: float = Field(
        50.0, gt=0,
        description="The one of apartment.thresholds for figures and tests that need a single one.",
    )  # fmt: skip
    experiments: Experiments = Field(
        description="Start situations; every degree of freedom is tried from each."
    )


class ApartmentGroupConfig(Section):
    """Robots and scenes, all combined."""

    robots: list[Name] = Field(description="Keys of apartment.robots.")
    scenes: list[Name] = Field(description="Keys of apartment.scenes.")
    experiments: Experiments = Field(description="Start situations of every robot in every scene.")


class ApartmentSensitivityConfig(Section):
    """Other lengths of the sequences, in the reference scene."""

    lengths: list[Length] = Field(description="Numbers of actions.")
    experiments: Experiments = Field(description="Start situations per length.")


class ApartmentRun(NamedTuple):
    """SC-experiments of one robot in one scene."""

    robot: str
    scene: str
    start: Start
    length: int
    experiments: int


class ApartmentConfig(Section):
    """Everything in three dimensions."""

    robots: dict[Name, RobotConfig] = Field(min_length=1)
    scenes: dict[Name, SceneConfig] = Field(min_length=1)
    sequence_length: Length = Field(
        50, description="Actions in a sequence, a tenth of a second each."
    )
    rest_steps: int = Field(
        3, ge=1, le=100,
        description="Steps without a command that end each sequence, everywhere in apartments.",
    )  # fmt: skip
    thresholds: list[Annotated[float, Field(ge=0)]] = Field(
        min_length=1, description="Squared distances of VGG16 features that count as equal."
    )
    fields_of_view: list[Annotated[float, Field(ge=5, le=150)]] = Field(
        min_length=1, description="Vertical, degrees; the first is the main one."
    )
    image_size: int = Field(
        128, ge=32, le=1024, description="Height and width of the camera's picture, pixels."
    )
    supersampling: int = Field(
        3, ge=1, le=8,
        description="Samples per pixel, in each direction: without, edges flicker and nothing "
        "commutes.",
    )  # fmt: skip
    reach: float = Field(
        0.15, gt=0, le=2,
        description="Metres: starts within reach have an object this close to the arm.",
    )  # fmt: skip
    weights: str | None = Field(
        None, description="File with the VGG16 weights; null to download them once and keep them."
    )
    reference: ApartmentReferenceConfig
    robots_compared: ApartmentGroupConfig = Field(description="Further robots (appendix C).")
    scenes_compared: ApartmentGroupConfig = Field(description="Further apartments.")
    within_reach: ApartmentGroupConfig = Field(description="Starts within the arm's reach.")
    free_space: ApartmentGroupConfig = Field(
        description="Where everything should commute: scenes without a file."
    )
    sensitivity: ApartmentSensitivityConfig
    experiments_per_job: int = Field(
        50,
        ge=1,
        le=1_000_000,
        description="Start situations in a job; changes no result.",
        json_schema_extra=NO_EFFECT,
    )

    @model_validator(mode="after")
    def _check_names(self) -> ApartmentConfig:
        check_defined(self.reference.robot, self.robots, "reference.robot", "apartment.robots")
        check_defined(self.reference.scene, self.scenes, "reference.scene", "apartment.scenes")
        for section in ("robots_compared", "scenes_compared", "within_reach", "free_space"):
            group: ApartmentGroupConfig = getattr(self, section)
            for kind, names in (("robots", group.robots), ("scenes", group.scenes)):
                for name in names:
                    defined = getattr(self, kind)
                    check_defined(name, defined, f"{section}.{kind}", f"apartment.{kind}")
        for name in self.free_space.scenes:
            if self.scenes[name].file is not None:
                raise ValueError(
                    f"free_space.scenes names {name!r}, which has a file; free space is a scene "
                    "without one: {}"
                )
        return self

    @model_validator(mode="after")
    def _check_numbers(self) -> ApartmentConfig:
        if self.reference.threshold not in self.thresholds:
            raise ValueError(
                f"reference.threshold {self.reference.threshold:g} is not among thresholds; add it"
            )
        for key, values in (
            ("thresholds", self.thresholds),
            ("fields_of_view", self.fields_of_view),
            ("sensitivity.lengths", [self.sequence_length, *self.sensitivity.lengths]),
        ):
            if len(set(values)) < len(values):
                raise ValueError(
                    f"{key} holds a number twice in {values}; remove one (the main "
                    "sequence_length is always included)"
                )
        if self.sensitivity.experiments > self.reference.experiments:
            raise ValueError(
                f"sensitivity.experiments {self.sensitivity.experiments} is more than "
                f"reference.experiments {self.reference.experiments}, from which the main length "
                "is taken; set it no higher"
            )
        if list(self.thresholds) != sorted(self.thresholds):
            raise ValueError(f"thresholds {self.thresholds} do not rise; write the lowest first")
        keys = [run[:4] for run in self.runs()]
        for run in keys:
            if keys.count(run) > 1:
                raise ValueError(
                    f"{run[0]!r} in {run[1]!r} is asked for by two sections; leave it out of one"
                )
        return self

    def views(self, run: ApartmentRun) -> list[float]:
        """Fields of view of a run, degrees: all in the reference, else the main one."""
        reference = run == next(self._runs())
        return list(self.fields_of_view) if reference else self.fields_of_view[:1]

    def runs(self) -> list[ApartmentRun]:
        """All SC-experiments, in the order of the sections."""
        return list(self._runs())

    def _runs(self) -> Iterator[ApartmentRun]:
        reference, length = self.reference, self.sequence_length
        yield ApartmentRun(
            reference.robot, reference.scene, "anywhere", length, reference.experiments
        )
        for group in (self.robots_compared, self.scenes_compared, self.free_space):
            for robot in group.robots:
                for scene in group.scenes:
                    yield ApartmentRun(robot, scene, "anywhere", length, group.experiments)
        within = self.within_reach
        for robot in within.robots:
            for scene in within.scenes:
                yield ApartmentRun(robot, scene, "within-reach", length, within.experiments)
        for other in self.sensitivity.lengths:
            yield ApartmentRun(
                reference.robot, reference.scene, "anywhere", other, self.sensitivity.experiments
            )

"""Settings of change detection and of the map of immovable objects (paper, section IV-A, appendix
D)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...storage.settings import NO_EFFECT, Name, Section

ModelName = Literal["raft", "flownet"]
LEARNED: tuple[ModelName, ...] = ("raft", "flownet")
"""Models that are trained; the image difference, a further model, is not."""

ScenesPerJob = Annotated[
    int,
    Field(
        ge=1,
        le=100_000,
        description="Cluttered scenes in a job; changes no result.",
        json_schema_extra=NO_EFFECT,
    ),
]


class MaskDataConfig(Section):
    """Pairs of pictures to learn from (paper: about 10,000 of each outcome, in Placida)."""

    scene: Name = Field(description="A key of apartment.scenes.")
    field_of_view: float = Field(45.0, ge=5, le=150, description="Vertical, degrees (paper: 45).")
    pairs: int = Field(ge=2, le=1_000_000, description="Training pairs of each outcome.")
    validation_pairs: int = Field(
        ge=2, le=1_000_000,
        description="Further pairs of each outcome, for curves and decision thresholds.",
    )  # fmt: skip
    pairs_per_scene: int = Field(
        150, ge=1, le=100_000,
        description="Pairs of each outcome that are made in one cluttered scene.",
    )  # fmt: skip
    scenes_per_job: ScenesPerJob = 1


class MaskTestConfig(Section):
    """SC-experiments on which the models are tested, labelled by the simulator."""

    scenes: list[Name] = Field(
        min_length=1, description="Apartments that were not trained in, keys of apartment.scenes."
    )
    field_of_view: float = Field(
        90.0, ge=5, le=150,
        description="Of the generalization test, vertical, degrees (paper: 90).",
    )  # fmt: skip
    sequence_length: int = Field(
        20, ge=2, le=2000, multiple_of=2, description="Actions in a sequence (paper: 20)."
    )
    experiments: int = Field(
        ge=2, le=1_000_000,
        description="SC-experiments of each of the four runs; two of them in the training "
        "apartment.",
    )  # fmt: skip
    tuples: int = Field(
        500, ge=2, le=1_000_000,
        description="Most tuples of each outcome in a test set: the first that occur.",
    )  # fmt: skip
    experiments_per_scene: int = Field(
        50, ge=1, le=100_000,
        description="SC-experiments that are played in one cluttered scene.",
    )  # fmt: skip
    scenes_per_job: ScenesPerJob = 1


class MaskModelConfig(Section):
    """How a model is trained (AdamW, one cycle of the learning rate)."""

    samples: int = Field(
        ge=16, le=100_000_000, description="Pairs shown in training, with repetitions."
    )
    batch_size: int = Field(16, ge=1, le=1024, description="Pairs in a training step.")
    learning_rate: float = Field(1e-3, gt=0, le=1, description="Highest, of AdamW.")
    weight_decay: float = Field(1e-4, ge=0, le=1, description="Of AdamW.")
    checkpoints: int = Field(
        10, ge=1, le=1000, description="Evaluations on the validation pairs: points of the curve."
    )
    threads: int = Field(
        1, ge=1, le=256,
        description="Cores of the training job; the last digits of the weights depend on it.",
    )  # fmt: skip


class ViewClassifierConfig(Section):
    """How the view classifier of a model is trained (AdamW, one cycle of the learning rate)."""

    pairs: int = Field(
        200, ge=1, le=1_000_000,
        description="Training pairs of each cluttered scene whose changed regions are learned "
        "from; the first in which something moved.",
    )  # fmt: skip
    samples: int = Field(
        ge=1, le=100_000_000, description="Regions shown in training, with repetitions."
    )
    batch_size: int = Field(64, ge=2, le=1024, description="Regions in a training step.")
    learning_rate: float = Field(2e-3, gt=0, le=1, description="Highest, of AdamW.")
    weight_decay: float = Field(1e-2, ge=0, le=1, description="Of AdamW.")


class MapConfig(Section):
    """The local SCP over a floor (paper: 10 SC-experiments of 100 steps per position, in Rs)."""

    scene: Name = Field(description="A key of apartment.scenes.")
    spacing: float = Field(0.4, ge=0.05, le=10, description="Metres between positions.")
    headings: int = Field(
        4, ge=1, le=360, description="Headings of the robot at each position, evenly spaced."
    )
    experiments: int = Field(10, ge=1, le=100_000, description="SC-experiments at each pose.")
    sequence_length: int = Field(100, ge=1, le=2000, description="Actions in a sequence.")
    cramped_room: str = Field(
        "kitchen", description="Room of the floor plan in which the local SCP should be low."
    )
    low_furniture: list[str] = Field(
        default_factory=list,
        description="Furniture of the floor plan below the arm, above which the local SCP should "
        "stay high.",
    )
    poses_per_job: int = Field(
        40,
        ge=1,
        le=100_000,
        description="Poses in a job; changes no result.",
        json_schema_extra=NO_EFFECT,
    )


class MasksConfig(Section):
    """Detecting what changed between two pictures."""

    robot: Name = Field(description="A key of apartment.robots.")
    fixed: dict[str, float] = Field(
        default_factory=dict,
        description="Positions of joints that are no degree of freedom, rad or m; they replace "
        "those of the robot's description.",
    )
    image_size: int = Field(
        128, ge=128, le=1024, multiple_of=32,
        description="Height and width of pictures, pixels; RAFT needs 64 for half of them.",
    )  # fmt: skip
    objects: int = Field(
        40, ge=1, le=1000,
        description="Movable objects in a cluttered scene; they replace those of the apartment.",
    )  # fmt: skip
    data: MaskDataConfig
    tests: MaskTestConfig
    raft: MaskModelConfig
    flownet: MaskModelConfig
    view_classifier: ViewClassifierConfig
    map: MapConfig

    @model_validator(mode="after")
    def _check_consistency(self) -> MasksConfig:
        data, tests = self.data, self.tests
        if data.scene in tests.scenes:
            raise ValueError(
                f"tests.scenes names {data.scene!r}, which is trained in (data.scene); leave it out"
            )
        if len(set(tests.scenes)) < len(tests.scenes):
            raise ValueError(f"tests.scenes holds a name twice in {tests.scenes}; remove one")
        if tests.field_of_view == data.field_of_view:
            raise ValueError(
                f"tests.field_of_view is data.field_of_view, {data.field_of_view:g}; set another, "
                "so that the test is about a new one"
            )
        return self

    def model(self, name: ModelName) -> MaskModelConfig:
        """How a model is trained."""
        return self.raft if name == "raft" else self.flownet

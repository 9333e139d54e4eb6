"""Everything that can be set about seeing what moved, and about the map of what cannot be moved (paper, section IV-A, appendix D)."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field, model_validator

from ...storage.settings import Name, Section

ModelName = Literal["raft", "flownet"]
LEARNED: tuple[ModelName, ...] = ("raft", "flownet")
"""Models that are trained; beside them stands the image difference, which is not."""


class MaskDataConfig(Section):
    """Pairs of pictures to learn from (paper: about 10,000 of each outcome, in Placida)."""

    scene: Name = Field(description="A key of apartment.scenes.")
    field_of_view: float = Field(45.0, ge=5, le=150, description="Vertical, degrees (paper: 45).")
    pairs: int = Field(ge=2, le=1_000_000, description="Pairs of each outcome to learn from.")
    validation_pairs: int = Field(
        ge=2,
        le=1_000_000,
        description="Further pairs of each outcome, from which curves and decision rules are made.",
    )
    pairs_per_job: int = Field(
        150,
        ge=1,
        le=100_000,
        description="Pairs of each outcome with the same objects in one job; other numbers give other pairs.",
    )


class MaskTestConfig(Section):
    """SC-experiments that the models are tested on, labelled by the simulator."""

    scenes: list[Name] = Field(
        min_length=1, description="Apartments that were not trained in, keys of apartment.scenes."
    )
    field_of_view: float = Field(
        90.0, ge=5, le=150, description="Of the generalisation test, vertical, degrees (paper: 90)."
    )
    sequence_length: int = Field(
        20, ge=2, le=2000, multiple_of=2, description="Actions in a sequence (paper: 20)."
    )
    experiments: int = Field(
        ge=2,
        le=1_000_000,
        description="SC-experiments of each of the four runs, of which two are in the training apartment.",
    )
    tuples: int = Field(
        500,
        ge=2,
        le=1_000_000,
        description="Most tuples of each outcome in a test set: the first that come about.",
    )
    experiments_per_job: int = Field(
        50,
        ge=1,
        le=100_000,
        description="SC-experiments with the same objects in one job; other numbers give others.",
    )


class MaskModelConfig(Section):
    """How a model is trained (AdamW, one cycle of the learning rate)."""

    samples: int = Field(
        ge=16, le=100_000_000, description="Pairs that are shown, each as often as it comes up."
    )
    batch_size: int = Field(16, ge=1, le=1024)
    learning_rate: float = Field(1e-3, gt=0, le=1)
    weight_decay: float = Field(1e-4, ge=0, le=1)
    checkpoints: int = Field(
        10, ge=1, le=1000, description="How often the model is tried on the validation pairs."
    )
    threads: int = Field(
        1,
        ge=1,
        le=256,
        description="Cores of its training job; the last digits of what is learned depend on it.",
    )


class ViewClassifierConfig(Section):
    """How the judge of places of either model is trained (AdamW, one cycle of the learning rate)."""

    pairs: int = Field(
        200,
        ge=1,
        le=1_000_000,
        description="Pairs of each file of training pairs in which something moved, whose places it learns from.",
    )
    samples: int = Field(
        ge=1, le=100_000_000, description="Places that are shown, each as often as it comes up."
    )
    batch_size: int = Field(64, ge=2, le=1024)
    learning_rate: float = Field(2e-3, gt=0, le=1)
    weight_decay: float = Field(1e-2, ge=0, le=1)


class MapConfig(Section):
    """The local SCP over a floor (paper: 10 SC-experiments of 100 steps at each place, in Rs)."""

    scene: Name = Field(description="A key of apartment.scenes.")
    spacing: float = Field(0.4, ge=0.05, le=10, description="Metres between places.")
    headings: int = Field(
        4, ge=1, le=360, description="Directions that the robot faces at each place, evenly spread."
    )
    experiments: int = Field(
        10, ge=1, le=100_000, description="SC-experiments at each place and heading."
    )
    sequence_length: int = Field(100, ge=1, le=2000, description="Actions in a sequence.")
    cramped_room: str = Field(
        "kitchen", description="The room of the floor plan in which the local SCP should be low."
    )
    low_furniture: list[str] = Field(
        default_factory=list,
        description="Furniture of the floor plan over which an arm passes, where it should stay high.",
    )
    poses_per_job: int = Field(
        40, ge=1, le=100_000, description="Places with their heading in a job; changes no result."
    )


class MasksConfig(Section):
    """Seeing what moved."""

    robot: Name = Field(description="A key of apartment.robots.")
    fixed: dict[str, float] = Field(
        default_factory=dict,
        description="Positions of joints that are no degree of freedom, in place of those that the robot's description gives.",
    )
    image_size: int = Field(
        128,
        ge=128,
        le=1024,
        multiple_of=32,
        description="Height and width of pictures, pixels; RAFT needs 64 of half of them.",
    )
    objects: int = Field(
        40,
        ge=1,
        le=1000,
        description="Movable objects that are scattered over an apartment, besides none of its own.",
    )
    data: MaskDataConfig
    tests: MaskTestConfig
    raft: MaskModelConfig
    flownet: MaskModelConfig
    view_classifier: ViewClassifierConfig
    map: MapConfig

    @model_validator(mode="after")
    def _fits_together(self) -> MasksConfig:
        if self.data.scene in self.tests.scenes:
            raise ValueError(
                f"tests.scenes names {self.data.scene!r}, which is trained in (data.scene); leave it out"
            )
        if len(set(self.tests.scenes)) < len(self.tests.scenes):
            raise ValueError(f"tests.scenes holds a name twice in {self.tests.scenes}; remove one")
        if self.tests.field_of_view == self.data.field_of_view:
            raise ValueError(
                f"tests.field_of_view is data.field_of_view, {self.data.field_of_view:g}; set another, or nothing is generalised to"
            )
        return self

    def pair_jobs(self, split: Literal["training", "validation"]) -> int:
        """Into how many jobs the pairs of a split are cut."""
        return math.ceil(
            (self.data.pairs if split == "training" else self.data.validation_pairs)
            / self.data.pairs_per_job
        )

    def model(self, name: ModelName) -> MaskModelConfig:
        """How a model is trained."""
        return self.raft if name == "raft" else self.flownet

"""Settings of the gallery: the SCP of public robots, in free space and in an apartment."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ...storage.settings import NO_EFFECT, Name, Section
from ..apartment.config import Length, RobotConfig, SceneConfig


class GalleryConfig(Section):
    """Robots and scenes, all combined."""

    robots: dict[Name, RobotConfig] = Field(min_length=1)
    scenes: dict[Name, SceneConfig] = Field(min_length=1)
    starts: Annotated[int, Field(ge=2, le=100_000)] = Field(
        200, description="Start situations of every robot in every scene."
    )
    sequence_length: Length = Field(
        20, description="Actions in a sequence, a tenth of a second each."
    )
    rest_steps: int = Field(
        3, ge=1, le=100, description="Steps without a command that end each sequence."
    )
    thresholds: list[Annotated[float, Field(ge=0)]] = Field(
        [0.0, 1.0], min_length=1,
        description="Mean squared errors of the camera's image, in 8-bit levels, that count as "
        "equal; the first is the one of the figure.",
    )  # fmt: skip
    image_size: int = Field(
        64, ge=32, le=1024, description="Height and width of the camera's picture, pixels."
    )
    starts_per_job: int = Field(
        50, ge=1, le=100_000, description="Starts in a job; changes no result.",
        json_schema_extra=NO_EFFECT,
    )  # fmt: skip

"""The whole configuration: what all parts share, and the parts."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path, PurePath
from typing import Annotated

from pydantic import Field, StringConstraints, field_validator, model_validator

from ..storage.settings import Name, Section, known
from .apartment.config import ApartmentConfig
from .flatland.config import FlatlandConfig
from .navigation.config import NavigationConfig
from .objects.config import MasksConfig


class Config(Section):
    """The whole configuration."""

    profile: Name = Field(description="Name of the run; results lie in a folder of this name.")
    results: Annotated[str, StringConstraints(pattern=r"^[^{}~*?\x00-\x1f]+$")] = Field(
        "results",
        max_length=200,
        description="Folder that holds the results of all profiles; no braces, wildcards, ~ or .. in its name.",
    )
    seed: int = Field(
        ge=0, lt=2**63, description="The root seed; everything random follows from it."
    )
    flatland: FlatlandConfig
    apartment: ApartmentConfig
    masks: MasksConfig
    navigation: NavigationConfig

    @model_validator(mode="after")
    def _navigation_is_measured(self) -> Config:
        flatland, navigation = self.flatland, self.navigation
        known(navigation.world, flatland.worlds, "navigation.world", "flatland.worlds")
        known(navigation.scp_world, flatland.worlds, "navigation.scp_world", "flatland.worlds")
        known(navigation.agent, flatland.agents, "navigation.agent", "flatland.agents")
        if (navigation.scp_world, navigation.agent, flatland.sequence_length) not in [
            run[:3] for run in flatland.runs()
        ]:
            raise ValueError(
                f"navigation needs the SCP of {navigation.agent!r} in {navigation.scp_world!r}, which no section of flatland measures; "
                "name them in flatland.variants"
            )
        room = flatland.worlds[navigation.world]
        for zone in navigation.zones:
            if not (
                zone.radius <= zone.x <= room.width - zone.radius
                and zone.radius <= zone.y <= room.height - zone.radius
            ):
                raise ValueError(
                    f"navigation.zones: the one at ({zone.x:g}, {zone.y:g}) leaves the room {navigation.world!r} of "
                    f"{room.width:g} x {room.height:g}; move or shrink it"
                )
        return self

    @model_validator(mode="after")
    def _masks_are_of_the_apartment(self) -> Config:
        apartment, masks = self.apartment, self.masks
        known(masks.robot, apartment.robots, "masks.robot", "apartment.robots")
        for key, names in (
            ("data.scene", [masks.data.scene]),
            ("tests.scenes", masks.tests.scenes),
            ("map.scene", [masks.map.scene]),
        ):
            for name in names:
                known(name, apartment.scenes, f"masks.{key}", "apartment.scenes")
                if apartment.scenes[name].file is None:
                    raise ValueError(
                        f"masks.{key} names {name!r}, an empty floor, where nothing can be moved; choose a scene with a file"
                    )
        if masks.robot != apartment.reference.robot:
            raise ValueError(
                f"masks.robot is {masks.robot!r}, but the SCPs that choose its degree of freedom are measured of apartment.reference.robot "
                f"{apartment.reference.robot!r}; set the same"
            )
        return self

    @field_validator("results")
    @classmethod
    def _results_are_where_it_says(cls, results: str) -> str:
        """``a/../b`` is not ``b`` where ``a`` is a link or not there yet, and a command takes ``-a`` for an option."""
        if ".." in PurePath(results).parts or results.startswith("-"):
            raise ValueError(
                f"{results!r} has a part '..' or begins with '-'; write the folder's whole path, from / if it lies elsewhere"
            )
        return results

    @property
    def folder(self) -> Path:
        """Where this run's results lie."""
        return Path(self.results) / self.profile

    def digest(self) -> str:
        """SHA-256 of all settings, hexadecimal; the same however the file is written."""
        return hashlib.sha256(
            json.dumps(self.model_dump(mode="json"), sort_keys=True).encode()
        ).hexdigest()

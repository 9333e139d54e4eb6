"""The whole configuration: common settings, and a section for each study."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path, PurePath
from typing import Annotated

from pydantic import Field, StringConstraints, field_validator, model_validator

from ..storage.settings import Name, Section, check_defined
from .apartment.config import ApartmentConfig
from .atlas.config import AtlasConfig
from .flatland.config import FlatlandConfig
from .gallery.config import GalleryConfig
from .navigation.config import NavigationConfig
from .objects.config import MasksConfig
from .reset_free.config import ResetFreeConfig


class Config(Section):
    """The whole configuration."""

    profile: Name = Field(description="Name of the run; results lie in a folder of this name.")
    results: Annotated[str, StringConstraints(pattern=r"^[^{}~*?\x00-\x1f]+$")] = Field(
        "results",
        max_length=200,
        description="Folder of the results of all profiles; no braces, wildcards, ~ or .. in its "
        "name.",
    )
    seed: int = Field(ge=0, lt=2**63, description="The root seed; it determines everything random.")
    flatland: FlatlandConfig
    apartment: ApartmentConfig
    masks: MasksConfig
    navigation: NavigationConfig
    reset_free: ResetFreeConfig | None = Field(
        None, description="Without a reset, under noise, and imagined; null leaves it out."
    )
    atlas: AtlasConfig | None = Field(None, description="Environments of the atlas (make atlas).")
    gallery: GalleryConfig | None = Field(None, description="Robots of the gallery (make gallery).")

    @model_validator(mode="after")
    def _check_navigation(self) -> Config:
        flatland, navigation = self.flatland, self.navigation
        check_defined(navigation.world, flatland.worlds, "navigation.world", "flatland.worlds")
        check_defined(
            navigation.scp_world, flatland.worlds, "navigation.scp_world", "flatland.worlds"
        )
        check_defined(navigation.agent, flatland.agents, "navigation.agent", "flatland.agents")
        measured = [run[:3] for run in flatland.runs()]
        if (navigation.scp_world, navigation.agent, flatland.sequence_length) not in measured:
            raise ValueError(
                f"navigation needs the SCP of {navigation.agent!r} in {navigation.scp_world!r}, "
                "which no section of flatland measures; name them in flatland.variants"
            )
        room = flatland.worlds[navigation.world]
        for zone in navigation.zones:
            if not (
                zone.radius <= zone.x <= room.width - zone.radius
                and zone.radius <= zone.y <= room.height - zone.radius
            ):
                raise ValueError(
                    f"navigation.zones: the one at ({zone.x:g}, {zone.y:g}) leaves the room "
                    f"{navigation.world!r} of {room.width:g} x {room.height:g}; move or shrink it"
                )
        return self

    @model_validator(mode="after")
    def _check_reset_free(self) -> Config:
        settings, flatland, apartment = self.reset_free, self.flatland, self.apartment
        if settings is None:
            return self
        check_defined(settings.agent, flatland.agents, "reset_free.agent", "flatland.agents")
        worlds = [run.world for run in settings.flatland.values()] + [settings.noise.world]
        for world in worlds:
            check_defined(world, flatland.worlds, "reset_free", "flatland.worlds")
        for run in settings.apartment.values():
            check_defined(run.robot, apartment.robots, "reset_free.apartment", "apartment.robots")
            check_defined(run.scene, apartment.scenes, "reset_free.apartment", "apartment.scenes")
        return self

    @model_validator(mode="after")
    def _check_masks(self) -> Config:
        apartment, masks = self.apartment, self.masks
        check_defined(masks.robot, apartment.robots, "masks.robot", "apartment.robots")
        for key, names in (
            ("data.scene", [masks.data.scene]),
            ("tests.scenes", masks.tests.scenes),
            ("map.scene", [masks.map.scene]),
        ):
            for name in names:
                check_defined(name, apartment.scenes, f"masks.{key}", "apartment.scenes")
                if apartment.scenes[name].file is None:
                    raise ValueError(
                        f"masks.{key} names {name!r}, an empty floor, where nothing can be moved; "
                        "choose a scene with a file"
                    )
        if masks.robot != apartment.reference.robot:
            raise ValueError(
                f"masks.robot is {masks.robot!r}, but the SCPs by which its degree of freedom is "
                f"chosen are those of apartment.reference.robot {apartment.reference.robot!r}; set "
                "the same"
            )
        return self

    @field_validator("results")
    @classmethod
    def _check_results(cls, results: str) -> str:
        # a/../b is not b where a is a link or missing; a command would take -a as an option.
        if ".." in PurePath(results).parts or results.startswith("-"):
            raise ValueError(
                f"{results!r} has a part '..' or begins with '-'; write the full path of the "
                "folder, from / if it is elsewhere"
            )
        return results

    @property
    def folder(self) -> Path:
        """Folder of the results of this run."""
        return Path(self.results) / self.profile

    def digest(self) -> str:
        """SHA-256 of all settings, hexadecimal; independent of how the file is written."""
        sections = self.model_dump(mode="json")
        for name in ("reset_free", "atlas", "gallery"):
            if sections[name] is None:
                del sections[name]  # so that a run without it does not depend on it
        settings = json.dumps(sections, sort_keys=True)
        return hashlib.sha256(settings.encode()).hexdigest()

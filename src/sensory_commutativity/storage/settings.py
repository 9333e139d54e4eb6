"""Base class and types of settings that are read from YAML files."""

from __future__ import annotations

from collections.abc import Collection
from typing import Annotated, Any, get_origin

from pydantic import BaseModel, ConfigDict, StringConstraints, model_validator

NAME_PATTERN = r"^[a-z0-9]+(-[a-z0-9]+)*$"
Name = Annotated[str, StringConstraints(pattern=NAME_PATTERN, max_length=40)]
"""Lower-case letters and digits, words joined by hyphens: names become parts of file names."""

NO_EFFECT: dict[str, Any] = {"affects_results": False}
"""``json_schema_extra`` of a setting that changes no result, such as how work is cut into jobs."""


class Section(BaseModel):
    """A section of settings: immutable, without unknown keys, without conversion of types.

    In a mapping whose keys are names, an entry that is null is left out, so that a file can remove
    what those before it define.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _leave_out_null_entries(cls, settings: Any) -> Any:
        if not isinstance(settings, dict):
            return settings
        kept = dict(settings)
        for name, field in cls.model_fields.items():
            entries = settings.get(name)
            if get_origin(field.annotation) is dict and isinstance(entries, dict):
                kept[name] = {key: entry for key, entry in entries.items() if entry is not None}
        return kept

    def settings_that_affect_results(self) -> dict[str, Any]:
        """The settings by name, without those that are declared with NO_EFFECT."""
        return {
            name: getattr(self, name)
            for name, field in type(self).model_fields.items()
            if field.json_schema_extra != NO_EFFECT
        }


def check_defined(name: str, defined: Collection[str], key: str, section: str) -> None:
    """Raise ValueError if `name`, the value of `key`, is not one of the names that are `defined`.

    `section` is the key under which they are defined.
    """
    if name not in defined:
        raise ValueError(
            f"{key} names {name!r}, which {section} does not define; "
            f"choose one of {', '.join(defined)}, or define it"
        )

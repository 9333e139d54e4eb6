"""What all sections of the configuration share."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, StringConstraints

Name = Annotated[str, StringConstraints(pattern=r"^[a-z0-9]+(-[a-z0-9]+)*$", max_length=40)]
"""Lower-case letters and digits, words joined by hyphens: names become parts of file names."""


class Section(BaseModel):
    """A part of the configuration: unknown keys and values of another type are refused, and nothing changes later."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


def known(name: str, defined: dict[str, Any], key: str, where: str) -> None:
    """Raise ValueError if `name`, set at `key`, is none of those `defined` under the key `where`."""
    if name not in defined:
        raise ValueError(
            f"{key} names {name!r}, which {where} does not define; choose one of {', '.join(defined)}, or define it"
        )

"""Parts of a scene file that floor plans and mesh scenes share."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field

from ....storage.settings import Name, Section
from .objects import OBJECTS, make_object
from .scene import Movable, SceneError

Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
SizeTriple = Annotated[list[Annotated[float, Field(gt=0)]], Field(min_length=3, max_length=3)]
Colour = Annotated[list[Annotated[float, Field(ge=0, le=1)]], Field(min_length=3, max_length=3)]

Surface = tuple[float, float, float, float]
"""A horizontal surface: x, y and height of its centre, metres, and its heading, rad."""
GROUND: Surface = (0.0, 0.0, 0.0, 0.0)


class ObjectDescription(Section):
    """A movable object."""

    type: str = Field(description="An object type listed in config/apartments/README.md.")
    name: Name | None = Field(None, description="Default: the type and a number.")
    stands_on: Name | None = Field(
        None, description="Name of the furniture that supports the object. Default: the floor."
    )
    at: Pair = Field(
        description=(
            "x and y in metres: in the plan, or on furniture from its centre to its front and left."
        )
    )
    height: float = Field(
        0.0, ge=0, le=5, description="Metres above the floor or the furniture's surface."
    )
    heading: float = Field(0.0, description="Degrees, counter-clockwise.")


def place_object(
    description: ObjectDescription, number: int, source: str, surface: Surface = GROUND
) -> Movable:
    """Build an object that stands on a surface.

    Parameters
    ----------
    description : ObjectDescription
    number : int
        Number of the object in the scene, for its default name.
    source : str
        The scene file, for error messages.
    surface : Surface

    Raises
    ------
    SceneError
        The object type is unknown.
    """
    if description.type not in OBJECTS:
        raise SceneError(
            f"{source}: objects: there is no type {description.type!r}; "
            f"choose among {', '.join(OBJECTS)}"
        )
    x, y, height, heading = surface
    forward, left = description.at
    return make_object(
        description.type,
        description.name or f"{description.type}-{number}",
        x + math.cos(heading) * forward - math.sin(heading) * left,
        y + math.sin(heading) * forward + math.cos(heading) * left,
        height + description.height,
        heading + math.radians(description.heading),
    )


def check_unique_names(names: list[str], key: str, source: str) -> None:
    """Raise SceneError if a name under `key` of the file `source` occurs twice."""
    duplicate = next((name for name in names if names.count(name) > 1), None)
    if duplicate is not None:
        raise SceneError(f"{source}: {key}: two are called {duplicate!r}; rename one")

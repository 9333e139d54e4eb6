"""A scene from its YAML file: a floor plan or a mesh, with objects that can be pushed.

The key ``kind`` says which. What is common to both is here: reading, checking, and putting objects down.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import Field, ValidationError

from ....errors import ConfigError
from ....storage.settings import Name, Section
from ....storage.settings_errors import explain, refuse_what_json_has_not
from ....storage.yamlfile import read_yaml
from .objects import OBJECTS, make
from .scene import Movable, Scene, SceneError

Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
SizeTriple = Annotated[list[Annotated[float, Field(gt=0)]], Field(min_length=3, max_length=3)]
Colour = Annotated[list[Annotated[float, Field(ge=0, le=1)]], Field(min_length=3, max_length=3)]
WANTED = "a scene, e.g. config/apartments/rs-stand-in.yaml"
"""What messages ask for."""
AnySection = TypeVar("AnySection", bound=Section)


class ObjectDescription(Section):
    """Something that can be pushed."""

    type: str = Field(description="A type of object; config/apartments/README.md lists them.")
    name: Name | None = Field(
        None, description="What it is called; its type and a number if not given."
    )
    stands_on: Name | None = Field(
        None, description="Name of the furniture that it stands on; without it, the floor."
    )
    at: Pair = Field(
        description="x and y, metres: of the plan, or from the middle of the furniture along its depth (to the front) and width."
    )
    height: float = Field(
        0.0, ge=0, le=5, description="Metres above the floor or the furniture's surface."
    )
    heading: float = Field(0.0, description="Degrees, counter-clockwise.")


def load_scene(file: str | Path) -> Scene:
    """Read a scene. Raises SceneError with one line: the file, what is wrong, and the remedy."""
    from .floorplan import FloorPlan, build_floor_plan
    from .meshscene import MeshScene, build_mesh_scene

    path = Path(file)
    settings = read_yaml(path, SceneError, WANTED)
    kind = settings.get("kind") if isinstance(settings, dict) else None
    if kind == "floor-plan":
        return build_floor_plan(_parsed(FloorPlan, settings, path), path)
    if kind == "mesh":
        return build_mesh_scene(_parsed(MeshScene, settings, path), path)
    raise SceneError(
        f"{path}: kind: expected floor-plan or mesh, got {kind!r}; see config/apartments/README.md"
    )


def scene_files(file: str | Path) -> list[Path]:
    """All files that a scene which can be loaded is made from: its YAML file and, if it has one, its mesh."""
    path = Path(file)
    mesh = read_yaml(path, SceneError, WANTED).get("mesh")
    return [path] if mesh is None else [path, path.parent / mesh]


def _parsed(section: type[AnySection], settings: Any, path: Path) -> AnySection:
    try:
        refuse_what_json_has_not(settings, "scene")
        return section.model_validate_json(json.dumps(settings))
    except ConfigError as error:
        raise SceneError(f"{path}: {error}") from None
    except ValidationError as error:
        raise SceneError(f"{path}: {explain(error, section).removeprefix('config: ')}") from None


def put_down(
    what: ObjectDescription,
    number: int,
    where: str,
    surface: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
) -> Movable:
    """Make an object stand on a surface.

    Parameters
    ----------
    number : int
        Which object of the scene, for its name.
    where : str
        The file, for messages.
    surface : tuple
        x, y and height of the surface's middle, metres, and its heading, rad.
    """
    if what.type not in OBJECTS:
        raise SceneError(
            f"{where}: objects: there is no type {what.type!r}; choose among {', '.join(OBJECTS)}"
        )
    x, y, height, heading = surface
    forward, left = what.at
    at_x, at_y = (
        x + math.cos(heading) * forward - math.sin(heading) * left,
        y + math.sin(heading) * forward + math.cos(heading) * left,
    )
    return make(
        what.type,
        what.name or f"{what.type}-{number}",
        at_x,
        at_y,
        height + what.height,
        heading + math.radians(what.heading),
    )


def no_name_twice(names: list[str], what: str, where: str) -> None:
    """Raise SceneError if a name is there twice."""
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise SceneError(f"{where}: {what}: two are called {twice!r}; rename one")

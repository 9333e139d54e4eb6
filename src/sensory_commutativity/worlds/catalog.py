"""The worlds of this package by name."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ..data import data_file, data_names
from ..errors import ArgumentError
from ..extras import extra_needed
from ..scp.world import World

FREE_SPACE = "free-space"
"""The scene that is an endless empty floor."""


def make_world(name: str, **options: Any) -> World:
    """Build a world of this package.

    Parameters
    ----------
    name : {"corridor", "flatland", "flatland-free-space", "apartment"}
        ``flatland`` is Polyphemus in a furnished room, in two dimensions; ``apartment`` a robot in
        a scene, in three.
    **options
        Of :class:`.Corridor` (wall, box); of :class:`.Room` (objects, width, height, ...); of
        :func:`make_apartment` (robot, scene, image_size, within).

    Raises
    ------
    ArgumentError
        If there is no such world or option.
    MissingExtraError
        If the world needs packages that are not installed.
    """
    if name not in WORLDS:
        near = difflib.get_close_matches(str(name), WORLDS, 1, 0.4)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise ArgumentError(
            f"name: there is no world {name!r}; {hint}choose one of {', '.join(WORLDS)}"
        )
    extra = "apartment" if name == "apartment" else "flatland"
    with extra_needed(extra):
        try:
            return WORLDS[name](**options)
        except TypeError as error:
            if "unexpected keyword" not in str(error):
                raise
            option = str(error).partition("argument ")[2]
            raise ArgumentError(
                f"options: the world {name!r} has no option {option}; it has {_options(name)}"
            ) from None


def make_apartment(
    robot: str | Path = "fetch",
    scene: str | Path = "rs-stand-in",
    image_size: int = 128,
    field_of_view: float | None = None,
    within: float | None = None,
) -> World:
    """Build a robot in a scene.

    Parameters
    ----------
    robot, scene : str or Path
        A name, ``fetch`` or ``rs-stand-in`` for example, or a YAML file. The scene ``free-space``
        is an endless empty floor.
    image_size : int
        Height and width of the camera's image, pixels.
    field_of_view : float, optional
        Vertical, degrees; by default that of the robot's description.
    within : float, optional
        Metres: in every start something is nearer to the arm than this.

    Raises
    ------
    ArgumentError
        If there is no robot or scene of this name.
    UserError
        If a file cannot be read as a robot or a scene.
    """
    robot_file = _find_file("robot", robot, "robots", ())
    empty = str(scene) == FREE_SPACE
    scene_file = None if empty else _find_file("scene", scene, "apartments", (FREE_SPACE,))
    from .apartment.rendering.camera import Camera  # these import PyBullet
    from .apartment.robots.loading import load_robot
    from .apartment.scenes.empty import empty_floor
    from .apartment.scenes.scenefile import load_scene
    from .apartment.world import ApartmentWorld

    loaded = load_robot(robot_file)
    built = empty_floor(FREE_SPACE) if scene_file is None else load_scene(scene_file)
    view = loaded.description.camera.field_of_view if field_of_view is None else field_of_view
    camera = Camera(image_size, image_size, view)
    return ApartmentWorld(built, loaded, [camera], within)


def list_robots() -> list[str]:
    """Names of the robots that belong to the package."""
    return data_names("config", "robots")


def list_scenes() -> list[str]:
    """Names of the scenes that belong to the package."""
    return [*data_names("config", "apartments"), FREE_SPACE]


def _find_file(kind: str, name: str | Path, folder: str, others: Sequence[str]) -> Path:
    names = data_names("config", folder)
    if str(name) in names:
        return data_file("config", folder, f"{name}.yaml")
    path = Path(name)
    if path.suffix in (".yaml", ".yml"):
        return path  # whoever reads it says what is wrong
    raise ArgumentError(
        f"{kind}: there is no {kind} {str(name)!r}; choose one of {', '.join([*names, *others])}, "
        "or give a YAML file"
    )


def _corridor(wall: int | None = 3, box: int | None = None) -> World:
    from .corridor import Corridor

    return Corridor(wall, box)


def _flatland(**room: Any) -> World:
    from .flatland.room import Room
    from .flatland.world import FlatlandWorld

    return FlatlandWorld(Room(**room))


def _flatland_free_space() -> World:
    return _flatland(objects=0, walls=False)


def _options(name: str) -> str:
    """Names of the options of a world."""
    builder: Callable[..., Any] = WORLDS[name]
    if builder is _flatland:
        from .flatland.room import Room

        builder = Room
    return ", ".join(inspect.signature(builder).parameters) or "none"


WORLDS: dict[str, Callable[..., World]] = {
    "corridor": _corridor,
    "flatland": _flatland,
    "flatland-free-space": _flatland_free_space,
    "apartment": make_apartment,
}
"""Name of a world -> its builder."""

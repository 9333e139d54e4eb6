"""Build an apartment from a floor plan: rectangular rooms, doors, furniture and movable objects.

A room is bounded by the centre lines of its walls, so adjacent rooms share a coordinate. Each room
has its own half of every wall, with its own colour and texture. A door is a gap in both halves
with a lintel above.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from pydantic import Field

from ....storage.settings import Name, Section
from .. import frames as fr
from ..geometry import box, cylinder, panel, transform
from ..rendering.textures import TEXTURES
from .descriptions import (
    Colour,
    ObjectDescription,
    Pair,
    SizeTriple,
    Surface,
    check_unique_names,
    place_object,
)
from .furniture import FURNITURE, Block
from .scene import (
    Area,
    Fixture,
    Movable,
    Part,
    Quaternion,
    Scene,
    SceneError,
    Solid,
    Vector,
    as_vector,
)

SLAB_THICKNESS = 0.02
"""Metres: drawn thickness of floors and ceilings; chosen: any, since only one face is visible."""


class Room(Section):
    """A rectangular room."""

    x: Pair = Field(description="From the centre line of one wall to that of the other, metres.")
    y: Pair
    floor: str = Field("planks", description="Texture.")
    floor_colour: Colour = Field([0.9, 0.85, 0.8])
    walls: str = Field("plaster", description="Texture.")
    wall_colour: Colour = Field([0.92, 0.9, 0.86])


class Door(Section):
    """A permanent opening between two rooms, without a door leaf."""

    at: Pair = Field(description="Its centre, on the line that two rooms share, metres.")
    width: float = Field(0.9, gt=0.3, le=4)
    height: float = Field(2.05, gt=0.5)


class Furniture(Section):
    """A piece of furniture."""

    type: str = Field(description="A furniture type listed in config/apartments/README.md.")
    name: Name | None = Field(None, description="Default: the type and a number.")
    at: Pair = Field(description="x and y of its centre, metres.")
    heading: float = Field(
        0.0,
        description="Degrees, counter-clockwise; at 0 the front faces x and the width is along y.",
    )
    size: SizeTriple | None = Field(None, description="Depth, width and height, metres.")
    colour: Colour | None = None
    texture: str | None = None
    lift: float | None = Field(None, ge=0, description="Metres above the floor.")


class FloorPlan(Section):
    """An apartment."""

    kind: Literal["floor-plan"]
    name: Name
    about: str = Field("", description="What the plan represents.")
    height: float = Field(2.5, gt=1, le=10, description="Height of the rooms, metres.")
    wall: float = Field(
        0.12, gt=0.01, le=1, description="Thickness of the walls between rooms, metres."
    )
    ceiling_colour: Colour = Field([0.95, 0.95, 0.94])
    rooms: dict[Name, Room] = Field(description="At least one: without rooms there is no floor.")
    doors: list[Door] = Field(default_factory=list)
    furniture: list[Furniture] = Field(default_factory=list)
    objects: list[ObjectDescription] = Field(default_factory=list)


def build_floor_plan(plan: FloorPlan, path: Path) -> Scene:
    """Build the scene of a floor plan.

    Parameters
    ----------
    plan : FloorPlan
    path : Path
        The scene file, for error messages.

    Raises
    ------
    SceneError
        With one line: the file, the problem and the remedy.
    """
    source = str(path)
    _check_rooms(plan, source)
    _check_doors(plan, source)
    names = [item.name or f"{item.type}-{i + 1}" for i, item in enumerate(plan.furniture)]
    check_unique_names(names, "furniture", source)
    fixtures = [
        fixture for name, room in plan.rooms.items() for fixture in _build_room(plan, name, room)
    ]
    surfaces: dict[str, Surface | None] = {}
    for name, item in zip(names, plan.furniture, strict=True):
        fixtures.append(_build_furniture(plan, name, item, source))
        surfaces[name] = _find_surface(item)
    movables = tuple(
        _build_object(description, i + 1, surfaces, plan, source)
        for i, description in enumerate(plan.objects)
    )
    check_unique_names([movable.name for movable in movables], "objects", source)
    inset = plan.wall / 2
    areas = tuple(
        Area(name, (room.x[0] + inset, room.x[1] - inset), (room.y[0] + inset, room.y[1] - inset))
        for name, room in plan.rooms.items()
    )
    return Scene(plan.name, tuple(fixtures), movables, areas)


# ---- checks --------------------------------------------------------------------------------------


def _check_rooms(plan: FloorPlan, source: str) -> None:
    if not plan.rooms:
        raise SceneError(
            f"{source}: rooms: there are none, so there is no floor to stand on; "
            "add a room with x and y"
        )
    rooms = list(plan.rooms.items())
    for i, (name, room) in enumerate(rooms):
        for axis in ("x", "y"):
            low, high = getattr(room, axis)
            if high - low < 2 * plan.wall:
                raise SceneError(
                    f"{source}: rooms.{name}.{axis}: from {low:g} to {high:g} is no room; "
                    "write the lower number first, metres apart"
                )
        for other_name, other_room in rooms[:i]:
            if _overlap(room, other_room):
                raise SceneError(
                    f"{source}: rooms: {other_name!r} and {name!r} overlap; "
                    "let them share a wall at most"
                )
        for key in ("floor", "walls"):
            _check_texture(getattr(room, key), f"{source}: rooms.{name}.{key}")


def _overlap(first: Room, second: Room) -> bool:
    """Whether two rooms share more than a wall."""
    return all(
        min(a_high, b_high) > max(a_low, b_low) + 1e-9
        for (a_low, a_high), (b_low, b_high) in ((first.x, second.x), (first.y, second.y))
    )


def _check_doors(plan: FloorPlan, source: str) -> None:
    for i, door in enumerate(plan.doors):
        sides = [side for room in plan.rooms.values() for side in _list_sides(room)]
        if sum(_is_in(door, side) for side in sides) != 2:
            raise SceneError(
                f"{source}: doors[{i}]: no wall between two rooms has a place for a door "
                f"{door.width:g} m wide at {door.at}; "
                "put its middle on the line that they share, away from corners"
            )
        if door.height >= plan.height:
            raise SceneError(
                f"{source}: doors[{i}].height: {door.height:g} m does not fit under the ceiling "
                f"at {plan.height:g} m; make it lower"
            )


def _check_texture(name: str, key: str) -> None:
    if name and name not in TEXTURES:
        raise SceneError(f"{key}: there is no texture {name!r}; choose among {', '.join(TEXTURES)}")


# ---- rooms ---------------------------------------------------------------------------------------


class _Side(NamedTuple):
    """One side of a room: the segment from `low` to `high` along an axis (0: x, 1: y)."""

    name: str
    axis: int
    across: float  # coordinate on the other axis
    low: float
    high: float


def _list_sides(room: Room) -> Iterator[_Side]:
    yield _Side("south", 0, room.y[0], room.x[0], room.x[1])
    yield _Side("north", 0, room.y[1], room.x[0], room.x[1])
    yield _Side("west", 1, room.x[0], room.y[0], room.y[1])
    yield _Side("east", 1, room.x[1], room.y[0], room.y[1])


def _is_in(door: Door, side: _Side) -> bool:
    """Whether a door lies completely within a side."""
    return (
        abs(door.at[1 - side.axis] - side.across) < 1e-6
        and side.low < door.at[side.axis] - door.width / 2
        and door.at[side.axis] + door.width / 2 < side.high
    )


def _build_room(plan: FloorPlan, name: str, room: Room) -> Iterator[Fixture]:
    x, y = (room.x[0] + room.x[1]) / 2, (room.y[0] + room.y[1]) / 2
    half = ((room.x[1] - room.x[0]) / 2, (room.y[1] - room.y[0]) / 2, SLAB_THICKNESS / 2)
    floor = transform(box(half), (x, y, -SLAB_THICKNESS / 2))
    ceiling = transform(box(half), (x, y, plan.height + SLAB_THICKNESS / 2))
    # Neither has a solid: the ground plane supports the objects and nothing reaches the ceiling.
    floor_part = Part(floor, as_vector(room.floor_colour), room.floor)
    yield Fixture(f"{name} floor", (floor_part,), ())
    ceiling_part = Part(ceiling, as_vector(plan.ceiling_colour), "plaster")
    yield Fixture(f"{name} ceiling", (ceiling_part,), (), overhead=True)
    for side in _list_sides(room):
        doors = sorted(
            (door for door in plan.doors if _is_in(door, side)),
            key=lambda door: door.at[side.axis],
        )
        start = side.low
        for number, door in enumerate([*doors, None], start=1):
            end = side.high if door is None else door.at[side.axis] - door.width / 2
            label = f"{name} {side.name} wall {number}"
            yield _build_wall(plan, room, label, side, (start, end), (0.0, plan.height))
            if door is not None:
                start = door.at[side.axis] + door.width / 2
                label = f"{name} {side.name} lintel {number}"
                yield _build_wall(
                    plan, room, label, side, (end, start), (door.height, plan.height), True
                )


def _build_wall(
    plan: FloorPlan,
    room: Room,
    name: str,
    side: _Side,
    run: tuple[float, float],
    rise: tuple[float, float],
    overhead: bool = False,
) -> Fixture:
    """Build the room's half of a wall over the horizontal range `run` and vertical range `rise`."""
    inward = 1 if side.name in ("south", "west") else -1
    thickness = plan.wall / 2
    half, centre = [0.0] * 3, [0.0] * 3
    half[side.axis], centre[side.axis] = (run[1] - run[0]) / 2, (run[0] + run[1]) / 2
    half[1 - side.axis], centre[1 - side.axis] = thickness / 2, side.across + inward * thickness / 2
    half[2], centre[2] = (rise[1] - rise[0]) / 2, (rise[0] + rise[1]) / 2
    position = as_vector(centre)
    part = Part(transform(box(half), position), as_vector(room.wall_colour), room.walls)
    return Fixture(name, (part,), (Solid("box", tuple(half), position),), overhead)


# ---- furniture and objects -----------------------------------------------------------------------


def _build_furniture(plan: FloorPlan, name: str, item: Furniture, source: str) -> Fixture:
    if item.type not in FURNITURE:
        raise SceneError(
            f"{source}: furniture: there is no type {item.type!r}; "
            f"choose among {', '.join(FURNITURE)}"
        )
    x, y = item.at
    if not any(
        room.x[0] < x < room.x[1] and room.y[0] < y < room.y[1] for room in plan.rooms.values()
    ):
        raise SceneError(
            f"{source}: furniture: {name!r} at {item.at} is in no room; move it into one"
        )
    kind = FURNITURE[item.type]
    texture = kind.texture if item.texture is None else item.texture
    _check_texture(texture, f"{source}: furniture: {name!r}")
    size, colour = as_vector(item.size or kind.size), as_vector(item.colour or kind.colour)
    lift = kind.lift if item.lift is None else item.lift
    frame = fr.on_floor(x, y, math.radians(item.heading), lift)
    half_heading = math.radians(item.heading) / 2
    rotation: Quaternion = (0.0, 0.0, math.sin(half_heading), math.cos(half_heading))
    blocks = kind.build(size, colour, texture)
    parts = tuple(_build_part(block, frame, rotation) for block in blocks)
    solids = tuple(
        Solid(block.kind, block.size, _to_world(frame, block.centre), rotation)
        for block in blocks
        if block.solid
    )
    return Fixture(name, parts, solids, overhead=item.type == "hanging-lamp")


def _to_world(frame: np.ndarray, point: Vector) -> Vector:
    x, y, z = fr.apply(frame, np.array([point]))[0]
    return float(x), float(y), float(z)


def _build_part(block: Block, frame: np.ndarray, rotation: Quaternion) -> Part:
    if block.kind == "cylinder":
        radius, half_height = block.size
        mesh = cylinder(radius, half_height, sides=14)
    else:
        mesh = (panel if block.fit_texture else box)(block.size)
    mesh = transform(mesh, _to_world(frame, block.centre), rotation)
    return Part(mesh, block.colour, block.texture)


def _find_surface(item: Furniture) -> Surface | None:
    """Find the surface that objects stand on, or None if the furniture has none."""
    kind = FURNITURE[item.type]
    if kind.surface is None:
        return None
    lift = kind.lift if item.lift is None else item.lift
    height = kind.surface(as_vector(item.size or kind.size)) + lift
    return item.at[0], item.at[1], height, math.radians(item.heading)


def _build_object(
    description: ObjectDescription,
    number: int,
    surfaces: Mapping[str, Surface | None],
    plan: FloorPlan,
    source: str,
) -> Movable:
    support = description.stands_on
    if support is None:
        return place_object(description, number, source)
    if support not in surfaces:
        raise SceneError(
            f"{source}: objects: {description.type!r} stands on {support!r}, which is no furniture "
            f"of {plan.name!r}; it has {', '.join(surfaces)}"
        )
    surface = surfaces[support]
    if surface is None:
        usable = ", ".join(name for name, surface in surfaces.items() if surface)
        raise SceneError(
            f"{source}: objects: nothing can stand on {support!r}; choose among {usable}"
        )
    return place_object(description, number, source, surface)

"""An apartment from a floor plan: rectangular rooms, doors between them, furniture, and things that can be pushed.

Rooms are given by the middle lines of their walls, so neighbours share a coordinate. Each room has its own half of every wall, in its own colour and
texture; a door leaves a gap in both halves and a lintel above.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from pydantic import Field

from ....storage.settings import Name, Section
from .. import frames as fr
from ..geometry import box, cylinder, panel, placed
from ..rendering.textures import TEXTURES
from .furniture import FURNITURE, Block
from .scene import Area, Fixture, Part, Quaternion, Scene, SceneError, Solid, Vector
from .scenefile import Colour, ObjectDescription, Pair, SizeTriple, no_name_twice, put_down

FLOOR = 0.02
"""Metres: how thick floors and ceilings are drawn; only their surface is seen."""


class Room(Section):
    """A rectangular room."""

    x: Pair = Field(description="From the middle of one wall to the middle of the other, metres.")
    y: Pair
    floor: str = Field("planks", description="Texture.")
    floor_colour: Colour = Field([0.9, 0.85, 0.8])
    walls: str = Field("plaster", description="Texture.")
    wall_colour: Colour = Field([0.92, 0.9, 0.86])


class Door(Section):
    """An opening between two rooms; there is nothing to open."""

    at: Pair = Field(description="Its middle, on the line that two rooms share, metres.")
    width: float = Field(0.9, gt=0.3, le=4)
    height: float = Field(2.05, gt=0.5)


class Furniture(Section):
    """A piece of furniture."""

    type: str = Field(description="A type of furniture; config/apartments/README.md lists them.")
    name: Name | None = Field(
        None, description="What it is called; its type and a number if not given."
    )
    at: Pair = Field(description="x and y of its middle, metres.")
    heading: float = Field(
        0.0,
        description="Degrees, counter-clockwise; at 0 its front looks along x, its width lies along y.",
    )
    size: SizeTriple | None = Field(None, description="Depth, width and height, metres.")
    colour: Colour | None = None
    texture: str | None = None
    lift: float | None = Field(None, ge=0, description="Metres above the floor.")


class FloorPlan(Section):
    """An apartment."""

    kind: Literal["floor-plan"]
    name: Name
    about: str = Field("", description="What it stands in for.")
    height: float = Field(2.5, gt=1, le=10, description="Of the rooms, metres.")
    wall: float = Field(
        0.12, gt=0.01, le=1, description="Thickness of the walls between rooms, metres."
    )
    ceiling_colour: Colour = Field([0.95, 0.95, 0.94])
    rooms: dict[Name, Room] = Field(description="At least one: without rooms there is no floor.")
    doors: list[Door] = Field(default_factory=list)
    furniture: list[Furniture] = Field(default_factory=list)
    objects: list[ObjectDescription] = Field(default_factory=list)


def build_floor_plan(plan: FloorPlan, path: Path) -> Scene:
    """The scene that a plan describes; `path` is what messages name. Raises SceneError."""
    where = str(path)
    _check_rooms(plan, where)
    names = [piece.name or f"{piece.type}-{i + 1}" for i, piece in enumerate(plan.furniture)]
    no_name_twice(names, "furniture", where)
    fixtures = [fixture for name, room in plan.rooms.items() for fixture in _room(plan, name, room)]
    surfaces: dict[str, tuple[float, float, float, float] | None] = {}
    for name, piece in zip(names, plan.furniture, strict=True):
        fixtures.append(_furniture(plan, name, piece, where))
        surfaces[name] = _surface(piece)
    movables = tuple(
        _object(thing, i + 1, surfaces, plan, where) for i, thing in enumerate(plan.objects)
    )
    no_name_twice([movable.name for movable in movables], "objects", where)
    inner = plan.wall / 2
    areas = tuple(
        Area(name, (room.x[0] + inner, room.x[1] - inner), (room.y[0] + inner, room.y[1] - inner))
        for name, room in plan.rooms.items()
    )
    return Scene(plan.name, tuple(fixtures), movables, areas)


# ---- checks --------------------------------------------------------------------------------------------------------------------


def _check_rooms(plan: FloorPlan, where: str) -> None:
    if not plan.rooms:
        raise SceneError(
            f"{where}: rooms: there are none, so there is no floor to stand on; add a room with x and y"
        )
    rooms = list(plan.rooms.items())
    for i, (name, room) in enumerate(rooms):
        for axis in ("x", "y"):
            low, high = getattr(room, axis)
            if high - low < 2 * plan.wall:
                raise SceneError(
                    f"{where}: rooms.{name}.{axis}: from {low:g} to {high:g} is no room; write the lower number first, metres apart"
                )
        for other_name, other in rooms[:i]:
            if all(min(room_, other_) > low for room_, other_, low in _overlaps(room, other)):
                raise SceneError(
                    f"{where}: rooms: {other_name!r} and {name!r} overlap; let them share a wall at most"
                )
        for key in ("floor", "walls"):
            _check_texture(getattr(room, key), f"{where}: rooms.{name}.{key}")
    for i, door in enumerate(plan.doors):
        if (
            sum(
                1
                for room in plan.rooms.values()
                for _, along, across, low, high in _sides(room)
                if _is_in(door, along, across, low, high)
            )
            != 2
        ):
            raise SceneError(
                f"{where}: doors[{i}]: no wall between two rooms has a place for a door {door.width:g} m wide at {door.at}; "
                "put its middle on the line that they share, away from corners"
            )
        if door.height >= plan.height:
            raise SceneError(
                f"{where}: doors[{i}].height: {door.height:g} m does not fit under the ceiling at {plan.height:g} m; make it lower"
            )


def _overlaps(room: Room, other: Room) -> Iterator[tuple[float, float, float]]:
    for axis in ("x", "y"):
        (a, b), (c, d) = getattr(room, axis), getattr(other, axis)
        yield b, d, max(a, c) + 1e-9


def _check_texture(name: str, where: str) -> None:
    if name and name not in TEXTURES:
        raise SceneError(
            f"{where}: there is no texture {name!r}; choose among {', '.join(TEXTURES)}"
        )


# ---- rooms ---------------------------------------------------------------------------------------------------------------------


def _sides(room: Room) -> Iterator[tuple[str, int, float, float, float]]:
    """Name, axis along which it runs (0: x), where on the other axis, from where, to where: of each wall."""
    yield "south", 0, room.y[0], room.x[0], room.x[1]
    yield "north", 0, room.y[1], room.x[0], room.x[1]
    yield "west", 1, room.x[0], room.y[0], room.y[1]
    yield "east", 1, room.x[1], room.y[0], room.y[1]


def _is_in(door: Door, along: int, across: float, low: float, high: float) -> bool:
    return (
        abs(door.at[1 - along] - across) < 1e-6
        and low < door.at[along] - door.width / 2
        and door.at[along] + door.width / 2 < high
    )


def _room(plan: FloorPlan, name: str, room: Room) -> Iterator[Fixture]:
    middle = ((room.x[0] + room.x[1]) / 2, (room.y[0] + room.y[1]) / 2)
    half = ((room.x[1] - room.x[0]) / 2, (room.y[1] - room.y[0]) / 2, FLOOR / 2)
    floor = placed(box(half), (*middle, -FLOOR / 2))
    ceiling = placed(box(half), (*middle, plan.height + FLOOR / 2))
    yield Fixture(
        f"{name} floor", (Part(floor, tuple(room.floor_colour), room.floor),), ()
    )  # the ground carries what stands on it
    yield Fixture(
        f"{name} ceiling",
        (Part(ceiling, tuple(plan.ceiling_colour), "plaster"),),
        (),
        overhead=True,
    )
    for side, along, across, low, high in _sides(room):
        inward = 1 if side in ("south", "west") else -1
        start = low
        doors = sorted(
            (door for door in plan.doors if _is_in(door, along, across, low, high)),
            key=lambda door: door.at[along],
        )
        for number, door in enumerate([*doors, None], start=1):
            end = high if door is None else door.at[along] - door.width / 2
            yield _wall(
                plan,
                room,
                f"{name} {side} wall {number}",
                along,
                across,
                inward,
                (start, end),
                (0.0, plan.height),
                False,
            )
            if door is not None:
                start = door.at[along] + door.width / 2
                yield _wall(
                    plan,
                    room,
                    f"{name} {side} lintel {number}",
                    along,
                    across,
                    inward,
                    (end, start),
                    (door.height, plan.height),
                    True,
                )


def _wall(
    plan: FloorPlan,
    room: Room,
    name: str,
    along: int,
    across: float,
    inward: int,
    run: tuple[float, float],
    rise: tuple[float, float],
    overhead: bool,
) -> Fixture:
    thick = plan.wall / 2
    half, middle = [0.0] * 3, [0.0] * 3
    half[along], middle[along] = (run[1] - run[0]) / 2, (run[0] + run[1]) / 2
    half[1 - along], middle[1 - along] = thick / 2, across + inward * thick / 2
    half[2], middle[2] = (rise[1] - rise[0]) / 2, (rise[0] + rise[1]) / 2
    at: Vector = (middle[0], middle[1], middle[2])
    part = Part(placed(box(half), at), tuple(room.wall_colour), room.walls)  # type: ignore[arg-type]
    return Fixture(name, (part,), (Solid("box", tuple(half), at),), overhead)


# ---- furniture and things ------------------------------------------------------------------------------------------------------


def _furniture(plan: FloorPlan, name: str, piece: Furniture, where: str) -> Fixture:
    if piece.type not in FURNITURE:
        raise SceneError(
            f"{where}: furniture: there is no type {piece.type!r}; choose among {', '.join(FURNITURE)}"
        )
    x, y = piece.at
    if not any(
        room.x[0] < x < room.x[1] and room.y[0] < y < room.y[1] for room in plan.rooms.values()
    ):
        raise SceneError(
            f"{where}: furniture: {name!r} at {piece.at} is in no room; move it into one"
        )
    what = FURNITURE[piece.type]
    texture = what.texture if piece.texture is None else piece.texture
    _check_texture(texture, f"{where}: furniture: {name!r}")
    size, colour = tuple(piece.size or what.size), tuple(piece.colour or what.colour)
    lift = what.lift if piece.lift is None else piece.lift
    frame = fr.on_floor(x, y, math.radians(piece.heading), lift)
    half = math.radians(piece.heading) / 2
    rotation: Quaternion = (0.0, 0.0, math.sin(half), math.cos(half))
    blocks = what.build(size, colour, texture)  # type: ignore[arg-type]
    parts = tuple(_part(block, frame, rotation) for block in blocks)
    solids = tuple(
        Solid(block.kind, block.size, _at(frame, block.middle), rotation)
        for block in blocks
        if block.solid
    )
    return Fixture(name, parts, solids, overhead=piece.type == "hanging-lamp")


def _at(frame, point: Vector) -> Vector:
    x, y, z = fr.apply(frame, [point])[0]
    return float(x), float(y), float(z)


def _part(block: Block, frame, rotation: Quaternion) -> Part:
    mesh = (
        cylinder(*block.size, sides=14)
        if block.kind == "cylinder"
        else (panel if block.once else box)(block.size)
    )
    return Part(placed(mesh, _at(frame, block.middle), rotation), block.colour, block.texture)


def _surface(piece: Furniture) -> tuple[float, float, float, float] | None:
    """x, y and height of what things stand on, and its heading in rad; None where nothing can."""
    what = FURNITURE[piece.type]
    if what.surface is None:
        return None
    height = what.surface(tuple(piece.size or what.size)) + (
        what.lift if piece.lift is None else piece.lift
    )  # type: ignore[arg-type]
    return piece.at[0], piece.at[1], height, math.radians(piece.heading)


def _object(thing: ObjectDescription, number: int, surfaces: dict, plan: FloorPlan, where: str):
    if thing.stands_on is None:
        return put_down(thing, number, where)
    if thing.stands_on not in surfaces:
        raise SceneError(
            f"{where}: objects: {thing.type!r} stands on {thing.stands_on!r}, which is no furniture of {plan.name!r}; it has {', '.join(surfaces)}"
        )
    if surfaces[thing.stands_on] is None:
        raise SceneError(
            f"{where}: objects: nothing can stand on {thing.stands_on!r}; choose among {', '.join(name for name, s in surfaces.items() if s)}"
        )
    return put_down(thing, number, where, surfaces[thing.stands_on])

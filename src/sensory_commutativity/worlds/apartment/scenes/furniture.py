"""Furniture types: how each is assembled from blocks, at sizes common in homes.

Blocks are boxes and cylinders, most of them solid. The origin of a frame is on the floor below
the centre of the furniture, whose front faces x. Sizes are (depth x, width y, height z) in metres.

All dimensions in the builder functions are chosen by eye after common products.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from .scene import Vector, as_vector

Range = tuple[float, float]


@dataclass(frozen=True)
class Block:
    """A box or an upright cylinder.

    Attributes
    ----------
    kind : {"box", "cylinder"}
    size : tuple of float
        Half extents (x, y, z) of a box or (radius, half height) of a cylinder, metres.
    centre, colour, texture
    solid : bool
        Whether the block collides.
    fit_texture : bool
        Whether the texture fills each side of a box exactly once instead of repeating.
    """

    kind: Literal["box", "cylinder"]
    size: tuple[float, ...]
    centre: Vector
    colour: Vector
    texture: str = ""
    solid: bool = True
    fit_texture: bool = False


@dataclass(frozen=True)
class FurnitureType:
    """A type of furniture.

    Attributes
    ----------
    size : tuple
        Default depth, width and height.
    colour, texture
        Defaults.
    build : callable
        (size, colour, texture) -> blocks.
    surface : callable or None
        size -> height of the surface that objects stand on, metres; None if there is none.
    lift : float
        Default height above the floor, metres, of furniture that hangs.
    """

    size: Vector
    colour: Vector
    texture: str
    build: Callable[[Vector, Vector, str], list[Block]]
    surface: Callable[[Vector], float] | None = None
    lift: float = 0.0


WHITE, DARK, STEEL = (0.93, 0.93, 0.92), (0.13, 0.13, 0.14), (0.72, 0.73, 0.75)
_GREEN, _LINEN, _STONE = (0.25, 0.5, 0.22), (0.94, 0.92, 0.88), (0.8, 0.79, 0.77)


# ---- building blocks -----------------------------------------------------------------------------


def _box(
    x: Range, y: Range, z: Range, colour: Vector, texture: str = "", solid: bool = True
) -> Block:
    """A box given by its extents."""
    half = as_vector((high - low) / 2 for low, high in (x, y, z))
    centre = as_vector((low + high) / 2 for low, high in (x, y, z))
    return Block("box", half, centre, colour, texture, solid)


def _span(length: float, inset: float = 0.0) -> Range:
    """The centred range of a length, shortened by `inset` at both ends."""
    return -length / 2 + inset, length / 2 - inset


def _edges(half: float, inset: float = 0.0, thickness: float = 0.0) -> tuple[Range, Range]:
    """Two ranges of equal thickness at both ends of -half to half."""
    a, b = half - inset - thickness, half - inset
    return (-b, -a), (a, b)


def _legs(
    d: float, w: float, top: float, thickness: float, colour: Vector, texture: str, inset: float
) -> list[Block]:
    return [
        _box(x, y, (0, top), colour, texture)
        for x in _edges(d / 2, inset, thickness)
        for y in _edges(w / 2, inset, thickness)
    ]


# ---- tables and seats ----------------------------------------------------------------------------


def _table(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    top = _box(_span(d), _span(w), (h - 0.035, h), colour, texture)
    return [top, *_legs(d, w, h - 0.035, 0.055, colour, texture, 0.03)]


def _low_table(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, _ = size
    shelf = _box(_span(d, 0.05), _span(w, 0.05), (0.12, 0.14), colour, texture)
    return [*_table(size, colour, texture), shelf]


def _desk(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    top = _box(_span(d), _span(w), (h - 0.03, h), colour, texture)
    drawers_y, fronts_y = (w / 2 - 0.45, w / 2 - 0.02), (w / 2 - 0.43, w / 2 - 0.04)
    drawers = _box(_span(d, 0.03), drawers_y, (0.05, h - 0.03), colour, texture)
    fronts = [
        _box((d / 2 - 0.03, d / 2 - 0.02), fronts_y, (z, z + 0.19), WHITE, "", False)
        for z in (0.08, 0.29, 0.5)
    ]
    side_y = (-w / 2 + 0.02, -w / 2 + 0.05)
    side = _box(_span(d, 0.03), side_y, (0, h - 0.03), colour, texture)
    return [top, drawers, side, *fronts]


def _chair(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    seat = _box(_span(d), _span(w), (0.43, 0.46), colour, texture)
    posts = [
        _box((-d / 2, -d / 2 + 0.03), y, (0.46, 0.58), colour, texture, False)
        for y in _edges(w / 2, 0.02, 0.035)
    ]
    back = _box((-d / 2, -d / 2 + 0.025), _span(w), (0.58, h), colour, texture)
    return [seat, *_legs(d, w, 0.43, 0.035, colour, texture, 0.0), *posts, back]


def _stool(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    seat = Block("cylinder", (min(d, w) / 2, 0.02), (0, 0, h - 0.02), colour, texture)
    return [seat, *_legs(d * 0.75, w * 0.75, h - 0.04, 0.03, STEEL, "metal", 0.0)]


def _sofa(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    arm = min(0.18, w / 6)
    seats = max(1, round((w - 2 * arm) / 0.75))
    seat_width = (w - 2 * arm) / seats
    blocks = [
        _box(_span(d), _span(w, arm), (0.08, 0.3), colour, texture),
        _box((-d / 2, -d / 2 + 0.2), _span(w, arm), (0.3, h), colour, texture),
        *[_box(_span(d), y, (0.05, 0.6), colour, texture) for y in _edges(w / 2, 0, arm)],
    ]
    light = as_vector(min(1.0, 1.12 * c) for c in colour)
    for k in range(seats):
        y = -w / 2 + arm + k * seat_width
        cushion_x, cushion_y = (-d / 2 + 0.2, d / 2 + 0.01), (y + 0.01, y + seat_width - 0.01)
        blocks.append(_box(cushion_x, cushion_y, (0.3, 0.43), light, texture))
    return blocks


def _bed(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    mattress_x = (-d / 2 + 0.06, d / 2 - 0.02)
    blocks = [
        _box(_span(d), _span(w), (0.08, h * 0.55), colour, "wood"),
        _box(mattress_x, _span(w, 0.02), (h * 0.55, h), _LINEN, "fabric"),
        _box((-d / 2 + 0.55, d / 2), _span(w), (h * 0.5, h + 0.03), colour, texture),
        _box((-d / 2, -d / 2 + 0.05), _span(w), (0, h + 0.45), colour, "wood"),
    ]
    pillows = 2 if w > 1.2 else 1
    pillow_x = (-d / 2 + 0.1, -d / 2 + 0.48)
    for k in range(pillows):
        y = (k + 0.5) * w / pillows - w / 2
        blocks.append(_box(pillow_x, (y - 0.28, y + 0.28), (h, h + 0.1), WHITE, "fabric"))
    return blocks


# ---- cabinets and shelves ------------------------------------------------------------------------


def _chest(size: Vector, colour: Vector, texture: str) -> list[Block]:
    """A closed body with drawers."""
    d, w, h = size
    rows = max(1, round(h / 0.25))
    row_height = (h - 0.08) / rows
    front_x, knob_x = (d / 2 - 0.01, d / 2 + 0.006), (d / 2, d / 2 + 0.02)
    blocks = [_box(_span(d), _span(w), (0, h), colour, texture)]
    for k in range(rows):
        low, middle = 0.05 + k * row_height, 0.04 + (k + 0.5) * row_height
        front_z = (low, low + row_height - 0.02)
        blocks.append(_box(front_x, _span(w, 0.02), front_z, colour, texture, False))
        knob_z = (middle - 0.01, middle + 0.01)
        blocks.append(_box(knob_x, (-0.05, 0.05), knob_z, DARK, "", False))
    return blocks


def _doors(size: Vector, colour: Vector, texture: str) -> list[Block]:
    """A closed body with doors: wardrobes, kitchen cabinets."""
    d, w, h = size
    count = max(1, round(w / 0.5))
    door_width = w / count
    door_x, grip_x = (d / 2 - 0.01, d / 2 + 0.006), (d / 2, d / 2 + 0.025)
    blocks = [_box(_span(d), _span(w), (0, h), colour, texture)]
    for k in range(count):
        left = k * door_width - w / 2
        door_y = (left + 0.008, left + door_width - 0.008)
        blocks.append(_box(door_x, door_y, (0.04, h - 0.02), colour, texture, False))
        grip = left + 0.85 * door_width
        grip_y, grip_z = (grip - 0.01, grip + 0.01), (h * 0.45, h * 0.6)
        blocks.append(_box(grip_x, grip_y, grip_z, STEEL, "metal", False))
    return blocks


def _bookcase(size: Vector, colour: Vector, texture: str) -> list[Block]:
    """Full shelves as a single solid, because no arm fits between the books."""
    d, w, h = size
    boards = max(2, round(h / 0.38)) + 1
    step = (h - 0.03) / (boards - 1)
    inner_y = _span(w, 0.025)
    blocks = [
        Block("box", (d / 2 - 0.01, w / 2, h / 2), (-0.01, 0, h / 2), colour, texture),
        *[_box(_span(d), y, (0, h), colour, texture, False) for y in _edges(w / 2, 0, 0.025)],
    ]
    for k in range(boards):
        z = k * step
        blocks.append(_box(_span(d), inner_y, (z, z + 0.03), colour, texture, False))
        if k < boards - 1:
            books = _box((0, d / 2 - 0.015), inner_y, (z + 0.03, z + step), WHITE, "books", False)
            blocks.append(Block("box", books.size, books.centre, WHITE, "books", False, True))
    return blocks


def _shelf(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    board = _box(_span(d), _span(w), (0, h), colour, texture)
    bracket_x = (-d / 2, d / 2 - 0.08)
    brackets = [_box(bracket_x, y, (-0.12, 0), colour, texture) for y in _edges(w / 2, 0.1, 0.02)]
    return [board, *brackets]


def _tv(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    wide = min(w * 0.8, 1.1)
    half_height = wide * 0.29
    z = h + 0.06 + wide * 0.29
    screen = Block("box", (0.02, wide / 2, half_height), (-d / 4, 0, z), DARK)
    picture_half, picture_at = (0.002, wide / 2 - 0.02, half_height - 0.02), (-d / 4 + 0.021, 0, z)
    picture = Block("box", picture_half, picture_at, (0.55, 0.65, 0.9), "art-2", False, True)
    foot = _box((-d / 4 - 0.1, -d / 4 + 0.1), (-0.2, 0.2), (h, h + 0.06), DARK)
    return [*_chest(size, colour, texture), screen, picture, foot]


# ---- kitchen and bathroom ------------------------------------------------------------------------


def _counter(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    blocks = []
    for b in _doors((d - 0.04, w, h - 0.12), colour, texture):
        centre = (b.centre[0] - 0.02, b.centre[1], b.centre[2] + 0.08)
        blocks.append(Block(b.kind, b.size, centre, b.colour, b.texture, b.solid))
    plinth = _box((-d / 2, d / 2 - 0.07), _span(w), (0, 0.08), DARK)
    top = _box(_span(d), _span(w), (h - 0.04, h), _STONE, "marble")
    return [*blocks, plinth, top]


def _sink(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, _, h = size
    basin_x, spout_x = (-d / 2 + 0.12, d / 2 - 0.08), (-d / 2 + 0.06, -d / 2 + 0.24)
    basin = _box(basin_x, (-0.22, 0.22), (h, h + 0.012), STEEL, "metal")
    tap = Block("cylinder", (0.015, 0.14), (-d / 2 + 0.07, 0, h + 0.14), STEEL, "metal")
    spout = _box(spout_x, (-0.012, 0.012), (h + 0.26, h + 0.285), STEEL, "metal")
    return [*_counter(size, colour, texture), basin, tap, spout]


def _stove(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    body = _box(_span(d), _span(w), (0, h), colour, texture)
    window = _box((d / 2, d / 2 + 0.01), _span(w, 0.06), (0.2, h - 0.22), DARK, "", False)
    grip = _box((d / 2, d / 2 + 0.045), _span(w, 0.06), (h - 0.19, h - 0.165), STEEL, "metal")
    plates = [
        Block("cylinder", (0.085, 0.006), (x, y, h + 0.006), DARK)
        for x in (-d / 5, d / 5)
        for y in (-w / 4, w / 4)
    ]
    return [body, window, grip, *plates]


def _fridge(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    body = _box((-d / 2, d / 2 - 0.055), _span(w), (0, h), colour, texture)
    doors_z = ((0.05, h * 0.62), (h * 0.63, h))
    grips_z = ((h * 0.3, h * 0.58), (h * 0.67, h * 0.85))
    doors = [_box((d / 2 - 0.05, d / 2), _span(w), z, colour, texture) for z in doors_z]
    grip_y = (w / 2 - 0.08, w / 2 - 0.055)
    grips = [_box((d / 2, d / 2 + 0.045), grip_y, z, DARK) for z in grips_z]
    return [body, *doors, *grips]


def _bathtub(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    sides = [_box(x, _span(w), (0, h), colour, texture) for x in _edges(d / 2, 0, 0.07)]
    ends = [_box(_span(d, 0.07), y, (0, h), colour, texture) for y in _edges(w / 2, 0, 0.09)]
    bottom = _box(_span(d, 0.07), _span(w, 0.09), (0, 0.15), colour, texture)
    return [*sides, *ends, bottom]


def _toilet(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    return [
        _box((-d / 2, -d / 2 + 0.18), _span(w), (0.38, h), colour, texture),
        Block("cylinder", (w / 2 * 0.6, 0.2), (0.05, 0, 0.2), colour, texture),
        Block("cylinder", (w / 2, 0.025), (d / 2 - w / 2, 0, 0.42), colour, texture),
    ]


def _washbasin(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    foot = (h - 0.14) / 2
    return [
        _box(_span(d), _span(w), (h - 0.14, h), colour, texture),
        Block("cylinder", (0.09, foot), (-d / 5, 0, foot), colour, texture),
        Block("cylinder", (0.014, 0.08), (-d / 2 + 0.06, 0, h + 0.08), STEEL, "metal"),
    ]


# ---- decoration ----------------------------------------------------------------------------------


def _lamp(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    return [
        Block("cylinder", (0.14, 0.015), (0, 0, 0.015), DARK),
        Block("cylinder", (0.014, h / 2 - 0.1), (0, 0, h / 2 - 0.07), STEEL, "metal"),
        Block("cylinder", (min(d, w) / 2, 0.14), (0, 0, h - 0.14), colour, texture),
    ]


def _pendant(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    return [
        Block("cylinder", (min(d, w) / 2, 0.11), (0, 0, 0.11), colour, texture),
        Block("cylinder", (0.008, (h - 0.22) / 2), (0, 0, (h + 0.22) / 2), DARK),
    ]


def _plant(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    pot, crown = min(0.3, h * 0.3), min(d, w) / 2
    stem = (h - pot) * 0.45
    blocks = [
        Block("cylinder", (crown * 0.6, pot / 2), (0, 0, pot / 2), colour, texture),
        Block("cylinder", (0.02, stem), (0, 0, pot + stem), (0.4, 0.3, 0.2)),
    ]
    for radius, z, brightness in ((0.6, 0.3, 0.8), (1.0, 0.55, 1.0), (0.7, 0.85, 1.3)):
        leaf_colour = as_vector(c * brightness for c in _GREEN)
        at = (0, 0, pot + (h - pot) * z)
        blocks.append(Block("cylinder", (crown * radius, h * 0.09), at, leaf_colour, "carpet"))
    return blocks


def _flat(size: Vector, colour: Vector, texture: str) -> list[Block]:
    """A flat decoration that does not collide: rugs and pictures."""
    d, w, h = size
    return [Block("box", (d / 2, w / 2, h / 2), (0, 0, h / 2), colour, texture, False, True)]


def _window(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    glass = Block("box", (d / 4, w / 2, h / 2), (0, 0, h / 2), (0.75, 0.88, 1.0), "", False)
    bars_y = (*_edges(w / 2, 0, 0.05), (-0.02, 0.02))
    bars = [_box(_span(d), y, (0, h), colour, texture, False) for y in bars_y]
    rails_z = ((0, 0.05), (h - 0.05, h))
    rails = [_box(_span(d), _span(w), z, colour, texture, False) for z in rails_z]
    return [glass, *bars, *rails]


def _top(size: Vector) -> float:
    return size[2]


_WOOD = (0.85, 0.72, 0.55)
FURNITURE: dict[str, FurnitureType] = {
    "table": FurnitureType((0.8, 1.4, 0.74), _WOOD, "wood", _table, _top),
    "low-table": FurnitureType((0.6, 1.1, 0.42), _WOOD, "wood", _low_table, _top),
    "desk": FurnitureType((0.65, 1.3, 0.74), _WOOD, "wood", _desk, _top),
    "chair": FurnitureType((0.43, 0.43, 0.9), _WOOD, "wood", _chair, lambda size: 0.46),
    "stool": FurnitureType((0.36, 0.36, 0.64), _WOOD, "wood", _stool, _top),
    "sofa": FurnitureType((0.88, 1.9, 0.8), (0.45, 0.5, 0.62), "fabric", _sofa),
    "armchair": FurnitureType((0.82, 0.85, 0.82), (0.62, 0.45, 0.4), "fabric", _sofa),
    "bed": FurnitureType(
        (2.03, 1.5, 0.48), (0.6, 0.45, 0.5), "plaid", _bed, lambda size: size[2] + 0.03
    ),
    "nightstand": FurnitureType((0.4, 0.45, 0.52), _WOOD, "wood", _chest, _top),
    "dresser": FurnitureType((0.45, 1.0, 0.85), _WOOD, "wood", _chest, _top),
    "wardrobe": FurnitureType((0.6, 1.2, 2.05), _WOOD, "wood", _doors),
    "bookcase": FurnitureType((0.3, 0.9, 1.9), _WOOD, "wood", _bookcase),
    "shelf": FurnitureType((0.25, 0.9, 0.03), _WOOD, "wood", _shelf, _top, 1.15),
    "kitchen-counter": FurnitureType((0.6, 1.2, 0.9), WHITE, "", _counter, _top),
    "sink-counter": FurnitureType((0.6, 1.0, 0.9), WHITE, "", _sink),
    "stove": FurnitureType((0.6, 0.6, 0.9), STEEL, "metal", _stove),
    "fridge": FurnitureType((0.65, 0.65, 1.8), (0.88, 0.89, 0.9), "metal", _fridge),
    "wall-cabinet": FurnitureType((0.35, 1.2, 0.7), WHITE, "", _doors, None, 1.4),
    "tv-stand": FurnitureType((0.42, 1.4, 0.48), (0.4, 0.32, 0.28), "darkwood", _tv, _top),
    "floor-lamp": FurnitureType((0.42, 0.42, 1.6), (0.98, 0.9, 0.7), "fabric", _lamp),
    "hanging-lamp": FurnitureType((0.4, 0.4, 0.95), (0.95, 0.85, 0.6), "", _pendant, None, 1.55),
    "plant": FurnitureType((0.5, 0.5, 1.2), (0.75, 0.45, 0.32), "", _plant),
    "bathtub": FurnitureType((0.75, 1.65, 0.55), WHITE, "", _bathtub),
    "toilet": FurnitureType((0.66, 0.38, 0.78), WHITE, "", _toilet),
    "washbasin": FurnitureType((0.45, 0.58, 0.85), WHITE, "", _washbasin),
    "rug": FurnitureType((1.6, 2.3, 0.006), WHITE, "rug", _flat),
    "picture": FurnitureType((0.02, 0.7, 0.7), WHITE, "art-1", _flat, None, 1.3),
    "window": FurnitureType((0.03, 1.2, 1.2), WHITE, "", _window, None, 0.95),
}
"""Every type of furniture by name."""

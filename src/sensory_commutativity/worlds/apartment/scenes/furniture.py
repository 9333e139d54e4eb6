"""Furniture: what a piece of each type is made of, at sizes that are common in homes.

A piece is blocks: boxes and cylinders, most of which are solid, in its own frame, whose origin is on the floor below its middle. Its front looks
along x; sizes are depth (x), width (y) and height (z) in metres.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from .scene import Vector


@dataclass(frozen=True)
class Block:
    """A box (half sizes) or an upright cylinder (radius, half height) at `middle`."""

    kind: Literal["box", "cylinder"]
    size: tuple[float, ...]
    middle: Vector
    colour: Vector
    texture: str = ""
    solid: bool = True
    once: bool = False  # the texture fills each side once rather than repeat


@dataclass(frozen=True)
class FurnitureType:
    """A type of furniture.

    Attributes
    ----------
    size : tuple
        Depth, width, height unless a plan says otherwise.
    colour, texture
        Unless a plan says otherwise.
    build : callable
        (size, colour, texture) -> blocks.
    surface : callable or None
        (size) -> metres: how high things stand on it; None where nothing can.
    lift : float
        Metres above the floor of what hangs.
    """

    size: Vector
    colour: Vector
    texture: str
    build: Callable[[Vector, Vector, str], list[Block]]
    surface: Callable[[Vector], float] | None = None
    lift: float = 0.0


WHITE, DARK, STEEL = (0.93, 0.93, 0.92), (0.13, 0.13, 0.14), (0.72, 0.73, 0.75)
_GREEN, _LINEN = (0.25, 0.5, 0.22), (0.94, 0.92, 0.88)


def _box(
    x: tuple[float, float],
    y: tuple[float, float],
    z: tuple[float, float],
    colour: Vector,
    texture: str = "",
    solid: bool = True,
) -> Block:
    """A box from its extents."""
    low, high = zip(x, y, z, strict=True)
    half = tuple((b - a) / 2 for a, b in zip(low, high, strict=True))
    return Block(
        "box",
        half,
        tuple((a + b) / 2 for a, b in zip(low, high, strict=True)),
        colour,
        texture,
        solid,
    )  # type: ignore[arg-type]


def _mirrored(
    half: float, inset: float = 0.0, thick: float = 0.0
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Two equal ranges at both ends of -half..half."""
    a, b = half - inset - thick, half - inset
    return (-b, -a), (a, b)


def _legs(
    d: float,
    w: float,
    top: float,
    thick: float,
    colour: Vector,
    texture: str = "",
    inset: float = 0.03,
) -> list[Block]:
    return [
        _box(x, y, (0, top), colour, texture)
        for x in _mirrored(d / 2, inset, thick)
        for y in _mirrored(w / 2, inset, thick)
    ]


def _table(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    return [
        _box((-d / 2, d / 2), (-w / 2, w / 2), (h - 0.035, h), colour, texture),
        *_legs(d, w, h - 0.035, 0.055, colour, texture),
    ]


def _low_table(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, _ = size
    shelf = _box(
        (-d / 2 + 0.05, d / 2 - 0.05), (-w / 2 + 0.05, w / 2 - 0.05), (0.12, 0.14), colour, texture
    )
    return [*_table(size, colour, texture), shelf]


def _desk(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    drawers = _box(
        (-d / 2 + 0.03, d / 2 - 0.03),
        (w / 2 - 0.45, w / 2 - 0.02),
        (0.05, h - 0.03),
        colour,
        texture,
    )
    fronts = [
        _box(
            (d / 2 - 0.03, d / 2 - 0.02),
            (w / 2 - 0.43, w / 2 - 0.04),
            (z, z + 0.19),
            WHITE,
            "",
            False,
        )
        for z in (0.08, 0.29, 0.5)
    ]
    side = _box(
        (-d / 2 + 0.03, d / 2 - 0.03),
        (-w / 2 + 0.02, -w / 2 + 0.05),
        (0, h - 0.03),
        colour,
        texture,
    )
    return [
        _box((-d / 2, d / 2), (-w / 2, w / 2), (h - 0.03, h), colour, texture),
        drawers,
        side,
        *fronts,
    ]


def _chair(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    seat = _box((-d / 2, d / 2), (-w / 2, w / 2), (0.43, 0.46), colour, texture)
    posts = [
        _box((-d / 2, -d / 2 + 0.03), y, (0.46, 0.58), colour, texture, False)
        for y in _mirrored(w / 2, 0.02, 0.035)
    ]
    back = _box((-d / 2, -d / 2 + 0.025), (-w / 2, w / 2), (0.58, h), colour, texture)
    return [seat, *_legs(d, w, 0.43, 0.035, colour, texture, 0.0), *posts, back]


def _stool(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    return [
        Block("cylinder", (min(d, w) / 2, 0.02), (0, 0, h - 0.02), colour, texture),
        *_legs(d * 0.75, w * 0.75, h - 0.04, 0.03, STEEL, "metal", 0.0),
    ]


def _sofa(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    arm = min(0.18, w / 6)
    seats = max(1, round((w - 2 * arm) / 0.75))
    wide = (w - 2 * arm) / seats
    blocks = [
        _box((-d / 2, d / 2), (-w / 2 + arm, w / 2 - arm), (0.08, 0.3), colour, texture),
        _box((-d / 2, -d / 2 + 0.2), (-w / 2 + arm, w / 2 - arm), (0.3, h), colour, texture),
        *[_box((-d / 2, d / 2), y, (0.05, 0.6), colour, texture) for y in _mirrored(w / 2, 0, arm)],
    ]
    light = tuple(min(1.0, 1.12 * c) for c in colour)
    for k in range(seats):
        y = -w / 2 + arm + k * wide
        blocks.append(
            _box(
                (-d / 2 + 0.2, d / 2 + 0.01),
                (y + 0.01, y + wide - 0.01),
                (0.3, 0.43),
                light,
                texture,
            )
        )  # type: ignore[arg-type]
    return blocks


def _bed(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    blocks = [
        _box((-d / 2, d / 2), (-w / 2, w / 2), (0.08, h * 0.55), colour, "wood"),
        _box(
            (-d / 2 + 0.06, d / 2 - 0.02),
            (-w / 2 + 0.02, w / 2 - 0.02),
            (h * 0.55, h),
            _LINEN,
            "fabric",
        ),
        _box((-d / 2 + 0.55, d / 2), (-w / 2, w / 2), (h * 0.5, h + 0.03), colour, texture),
        _box((-d / 2, -d / 2 + 0.05), (-w / 2, w / 2), (0, h + 0.45), colour, "wood"),
    ]
    pillows = 2 if w > 1.2 else 1
    for k in range(pillows):
        y = (k + 0.5) * w / pillows - w / 2
        blocks.append(
            _box((-d / 2 + 0.1, -d / 2 + 0.48), (y - 0.28, y + 0.28), (h, h + 0.1), WHITE, "fabric")
        )
    return blocks


def _chest(size: Vector, colour: Vector, texture: str) -> list[Block]:
    """A closed body with drawers."""
    d, w, h = size
    rows = max(1, round(h / 0.25))
    tall = (h - 0.08) / rows
    blocks = [_box((-d / 2, d / 2), (-w / 2, w / 2), (0, h), colour, texture)]
    for k in range(rows):
        low, middle = 0.05 + k * tall, 0.04 + (k + 0.5) * tall
        blocks.append(
            _box(
                (d / 2 - 0.01, d / 2 + 0.006),
                (-w / 2 + 0.02, w / 2 - 0.02),
                (low, low + tall - 0.02),
                colour,
                texture,
                False,
            )
        )
        blocks.append(
            _box(
                (d / 2, d / 2 + 0.02),
                (-0.05, 0.05),
                (middle - 0.01, middle + 0.01),
                DARK,
                "",
                False,
            )
        )
    return blocks


def _doors(size: Vector, colour: Vector, texture: str) -> list[Block]:
    """A closed body with doors: wardrobes, kitchen cabinets."""
    d, w, h = size
    count = max(1, round(w / 0.5))
    wide = w / count
    blocks = [_box((-d / 2, d / 2), (-w / 2, w / 2), (0, h), colour, texture)]
    for k in range(count):
        left = k * wide - w / 2
        blocks.append(
            _box(
                (d / 2 - 0.01, d / 2 + 0.006),
                (left + 0.008, left + wide - 0.008),
                (0.04, h - 0.02),
                colour,
                texture,
                False,
            )
        )
        grip = left + 0.85 * wide
        blocks.append(
            _box(
                (d / 2, d / 2 + 0.025),
                (grip - 0.01, grip + 0.01),
                (h * 0.45, h * 0.6),
                STEEL,
                "metal",
                False,
            )
        )
    return blocks


def _bookcase(size: Vector, colour: Vector, texture: str) -> list[Block]:
    """Shelves full of books, which together are one solid: no arm gets between them."""
    d, w, h = size
    boards = max(2, round(h / 0.38)) + 1
    step = (h - 0.03) / (boards - 1)
    whole = Block("box", (d / 2 - 0.01, w / 2, h / 2), (-0.01, 0, h / 2), colour, texture)
    blocks = [
        whole,
        *[
            _box((-d / 2, d / 2), y, (0, h), colour, texture, False)
            for y in _mirrored(w / 2, 0, 0.025)
        ],
    ]
    for k in range(boards):
        z = k * step
        blocks.append(
            _box(
                (-d / 2, d / 2),
                (-w / 2 + 0.025, w / 2 - 0.025),
                (z, z + 0.03),
                colour,
                texture,
                False,
            )
        )
        if k < boards - 1:
            books = _box(
                (0, d / 2 - 0.015),
                (-w / 2 + 0.025, w / 2 - 0.025),
                (z + 0.03, z + step),
                WHITE,
                "books",
                False,
            )
            blocks.append(Block("box", books.size, books.middle, WHITE, "books", False, True))
    return blocks


def _shelf(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    return [
        _box((-d / 2, d / 2), (-w / 2, w / 2), (0, h), colour, texture),
        *[
            _box((-d / 2, d / 2 - 0.08), y, (-0.12, 0), colour, texture)
            for y in _mirrored(w / 2, 0.1, 0.02)
        ],
    ]


def _counter(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    body = [
        Block(
            b.kind,
            b.size,
            (b.middle[0] - 0.02, b.middle[1], b.middle[2] + 0.08),
            b.colour,
            b.texture,
            b.solid,
        )
        for b in _doors((d - 0.04, w, h - 0.12), colour, texture)
    ]
    plinth = _box((-d / 2, d / 2 - 0.07), (-w / 2, w / 2), (0, 0.08), DARK)
    return [
        *body,
        plinth,
        _box((-d / 2, d / 2), (-w / 2, w / 2), (h - 0.04, h), (0.8, 0.79, 0.77), "marble"),
    ]


def _sink(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, _, h = size
    basin = _box((-d / 2 + 0.12, d / 2 - 0.08), (-0.22, 0.22), (h, h + 0.012), STEEL, "metal")
    tap = [
        Block("cylinder", (0.015, 0.14), (-d / 2 + 0.07, 0, h + 0.14), STEEL, "metal"),
        _box(
            (-d / 2 + 0.06, -d / 2 + 0.24), (-0.012, 0.012), (h + 0.26, h + 0.285), STEEL, "metal"
        ),
    ]
    return [*_counter(size, colour, texture), basin, *tap]


def _stove(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    plates = [
        Block("cylinder", (0.085, 0.006), (x, y, h + 0.006), DARK)
        for x in (-d / 5, d / 5)
        for y in (-w / 4, w / 4)
    ]
    window = _box(
        (d / 2, d / 2 + 0.01), (-w / 2 + 0.06, w / 2 - 0.06), (0.2, h - 0.22), DARK, "", False
    )
    return [
        _box((-d / 2, d / 2), (-w / 2, w / 2), (0, h), colour, texture),
        window,
        _box(
            (d / 2, d / 2 + 0.045),
            (-w / 2 + 0.06, w / 2 - 0.06),
            (h - 0.19, h - 0.165),
            STEEL,
            "metal",
        ),
        *plates,
    ]


def _fridge(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    doors = [
        _box((d / 2 - 0.05, d / 2), (-w / 2, w / 2), z, colour, texture)
        for z in ((0.05, h * 0.62), (h * 0.63, h))
    ]
    grips = [
        _box((d / 2, d / 2 + 0.045), (w / 2 - 0.08, w / 2 - 0.055), z, DARK)
        for z in ((h * 0.3, h * 0.58), (h * 0.67, h * 0.85))
    ]
    return [_box((-d / 2, d / 2 - 0.055), (-w / 2, w / 2), (0, h), colour, texture), *doors, *grips]


def _tv(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    wide = min(w * 0.8, 1.1)
    screen = Block("box", (0.02, wide / 2, wide * 0.29), (-d / 4, 0, h + 0.06 + wide * 0.29), DARK)
    picture = Block(
        "box",
        (0.002, wide / 2 - 0.02, wide * 0.29 - 0.02),
        (-d / 4 + 0.021, 0, h + 0.06 + wide * 0.29),
        (0.55, 0.65, 0.9),
        "art-2",
        False,
        True,
    )
    return [
        *_chest(size, colour, texture),
        screen,
        picture,
        _box((-d / 4 - 0.1, -d / 4 + 0.1), (-0.2, 0.2), (h, h + 0.06), DARK),
    ]


def _lamp(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    return [
        Block("cylinder", (0.14, 0.015), (0, 0, 0.015), DARK), Block("cylinder", (0.014, h / 2 - 0.1), (0, 0, h / 2 - 0.07), STEEL, "metal"),
        Block("cylinder", (min(d, w) / 2, 0.14), (0, 0, h - 0.14), colour, texture),
    ]  # fmt: skip


def _hanging(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    return [
        Block("cylinder", (min(d, w) / 2, 0.11), (0, 0, 0.11), colour, texture),
        Block("cylinder", (0.008, (h - 0.22) / 2), (0, 0, (h + 0.22) / 2), DARK),
    ]


def _plant(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    pot, crown = min(0.3, h * 0.3), min(d, w) / 2
    leaves = [Block("cylinder", (crown * r, h * 0.09), (0, 0, pot + (h - pot) * z), tuple(c * f for c in _GREEN), "carpet")  # type: ignore[arg-type]
              for r, z, f in ((0.6, 0.3, 0.8), (1.0, 0.55, 1.0), (0.7, 0.85, 1.3))]  # fmt: skip
    return [
        Block("cylinder", (crown * 0.6, pot / 2), (0, 0, pot / 2), colour, texture),
        Block(
            "cylinder", (0.02, (h - pot) * 0.45), (0, 0, pot + (h - pot) * 0.45), (0.4, 0.3, 0.2)
        ),
        *leaves,
    ]


def _bathtub(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    sides = [_box(x, (-w / 2, w / 2), (0, h), colour, texture) for x in _mirrored(d / 2, 0, 0.07)]
    ends = [
        _box((-d / 2 + 0.07, d / 2 - 0.07), y, (0, h), colour, texture)
        for y in _mirrored(w / 2, 0, 0.09)
    ]
    return [
        *sides,
        *ends,
        _box(
            (-d / 2 + 0.07, d / 2 - 0.07), (-w / 2 + 0.09, w / 2 - 0.09), (0, 0.15), colour, texture
        ),
    ]


def _toilet(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    tank = _box((-d / 2, -d / 2 + 0.18), (-w / 2, w / 2), (0.38, h), colour, texture)
    return [
        tank,
        Block("cylinder", (w / 2 * 0.6, 0.2), (0.05, 0, 0.2), colour, texture),
        Block("cylinder", (w / 2, 0.025), (d / 2 - w / 2, 0, 0.42), colour, texture),
    ]


def _washbasin(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    basin = _box((-d / 2, d / 2), (-w / 2, w / 2), (h - 0.14, h), colour, texture)
    foot = Block("cylinder", (0.09, (h - 0.14) / 2), (-d / 5, 0, (h - 0.14) / 2), colour, texture)
    return [
        basin,
        foot,
        Block("cylinder", (0.014, 0.08), (-d / 2 + 0.06, 0, h + 0.08), STEEL, "metal"),
    ]


def _flat(size: Vector, colour: Vector, texture: str) -> list[Block]:
    """Something to look at: no solid."""
    d, w, h = size
    return [Block("box", (d / 2, w / 2, h / 2), (0, 0, h / 2), colour, texture, False, True)]


def _window(size: Vector, colour: Vector, texture: str) -> list[Block]:
    d, w, h = size
    glass = Block("box", (d / 4, w / 2, h / 2), (0, 0, h / 2), (0.75, 0.88, 1.0), "", False)
    frame = [
        _box((-d / 2, d / 2), y, (0, h), colour, texture, False)
        for y in (*_mirrored(w / 2, 0, 0.05), (-0.02, 0.02))
    ]
    return [
        glass,
        *frame,
        *[
            _box((-d / 2, d / 2), (-w / 2, w / 2), z, colour, texture, False)
            for z in ((0, 0.05), (h - 0.05, h))
        ],
    ]


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
    "hanging-lamp": FurnitureType((0.4, 0.4, 0.95), (0.95, 0.85, 0.6), "", _hanging, None, 1.55),
    "plant": FurnitureType((0.5, 0.5, 1.2), (0.75, 0.45, 0.32), "", _plant),
    "bathtub": FurnitureType((0.75, 1.65, 0.55), WHITE, "", _bathtub),
    "toilet": FurnitureType((0.66, 0.38, 0.78), WHITE, "", _toilet),
    "washbasin": FurnitureType((0.45, 0.58, 0.85), WHITE, "", _washbasin),
    "rug": FurnitureType((1.6, 2.3, 0.006), WHITE, "rug", _flat),
    "picture": FurnitureType((0.02, 0.7, 0.7), WHITE, "art-1", _flat, None, 1.3),
    "window": FurnitureType((0.03, 1.2, 1.2), WHITE, "", _window, None, 0.95),
}
"""Every type of furniture by its name."""

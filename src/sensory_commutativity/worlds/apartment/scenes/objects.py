"""SceneSampler things that can be pushed, in two families that share none: one to learn from, one to test on.

Sizes are those of common products, masses those of their usual content. The origin is the middle, where the centre of mass is taken to be.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..geometry import box, cylinder, handle, joined, lathe, panel, placed, sphere
from .scene import Mesh, Movable, Part, Solid, Vector

Family = Literal["training", "testing"]
FAMILIES: tuple[Family, ...] = ("training", "testing")
GAP = 0.001
"""Metres above the surface on which an object is put down; it settles before anything else happens."""


@dataclass(frozen=True)
class ObjectType:
    """A kind of thing.

    Attributes
    ----------
    category : str
        box, can, bottle, mug, ball, bowl, ...
    family : str
        ``training`` or ``testing``.
    mass : float
        Kilograms.
    half_height : float
        Metres from the middle to where it stands.
    parts, solids : tuple
        What it looks like and collides with, around the middle.
    """

    category: str
    family: Family
    mass: float
    half_height: float
    parts: tuple[Part, ...]
    solids: tuple[Solid, ...]


def make(kind: str, name: str, x: float, y: float, height: float, heading: float) -> Movable:
    """An object of the type `kind` that stands at (x, y) on a surface at `height`, turned by `heading` rad."""
    what = OBJECTS[kind]
    half = heading / 2
    return Movable(
        name,
        what.category,
        what.mass,
        what.parts,
        what.solids,
        (x, y, height + what.half_height + GAP),
        (0.0, 0.0, float(np.sin(half)), float(np.cos(half))),
    )


# ---- shapes --------------------------------------------------------------------------------------------------------------------


def _box(
    category: str,
    family: Family,
    mass: float,
    size: Vector,
    colour: Vector,
    texture: str = "",
    label: Vector | None = None,
) -> ObjectType:
    """A box; with a `label` its sides have a band in another colour."""
    half = tuple(length / 2 for length in size)
    parts = [Part((panel if texture.startswith("art") else box)(half), colour, texture)]
    if label is not None:
        parts.append(Part(box((half[0] * 1.004, half[1] * 1.004, half[2] * 0.35)), label))
    return ObjectType(category, family, mass, half[2], tuple(parts), (Solid("box", half),))


def _can(
    category: str,
    family: Family,
    mass: float,
    radius: float,
    height: float,
    colour: Vector,
    lid: Vector = (0.8, 0.8, 0.82),
) -> ObjectType:
    """A cylinder with a lid of another colour."""
    rim = height * 0.06
    body = Part(placed(cylinder(radius, height / 2 - rim / 2), (0.0, 0.0, -rim / 2)), colour)
    top = Part(
        placed(cylinder(radius * 0.96, rim / 2), (0.0, 0.0, height / 2 - rim / 2)), lid, "metal"
    )
    return ObjectType(
        category, family, mass, height / 2, (body, top), (Solid("cylinder", (radius, height / 2)),)
    )


def _turned(
    category: str,
    family: Family,
    mass: float,
    profile: list[tuple[float, float]],
    colour: Vector,
    texture: str = "",
    cap: float = 0.0,
) -> ObjectType:
    """Something turned on a lathe, from its foot at z = 0 up; `cap` metres at the top are of another colour."""
    outer = max(z for _, z in profile)
    centred = [(r, z - outer / 2) for r, z in profile]
    parts = [Part(lathe(centred, 14), colour, texture)]
    if cap:
        radius = max(r for r, z in profile if z > outer - cap) * 1.15
        parts.append(
            Part(
                placed(cylinder(radius, cap / 2, 10), (0.0, 0.0, outer / 2 - cap / 2 + 0.001)),
                (0.85, 0.2, 0.15),
            )
        )
    hull = lathe(centred, 10).vertices
    return ObjectType(
        category, family, mass, outer / 2, tuple(parts), (Solid("hull", vertices=hull),)
    )


def _mug(family: Family, mass: float, radius: float, height: float, colour: Vector) -> ObjectType:
    wall, half = 0.004, height / 2
    cup: Mesh = lathe(
        [
            (0.0, -half),
            (radius, -half),
            (radius, half),
            (radius - wall, half),
            (radius - wall, wall - half),
            (0.0, wall - half),
        ],
        14,
    )
    bow, rod = height * 0.3, 0.009
    whole = joined([cup, placed(handle(bow, rod), (radius - 0.002, 0.0, 0.0))])
    return ObjectType(
        "mug", family, mass, half, (Part(whole, colour),), (Solid("hull", vertices=whole.vertices),)
    )


def _ball(
    family: Family, mass: float, radius: float, colour: Vector, texture: str = ""
) -> ObjectType:
    return ObjectType(
        "ball",
        family,
        mass,
        radius,
        (Part(sphere(radius), colour, texture),),
        (Solid("sphere", (radius,)),),
    )


def _bowl(family: Family, mass: float, radius: float, height: float, colour: Vector) -> ObjectType:
    foot, wall = radius * 0.5, 0.005
    outside = [(0.0, 0.0), (foot, 0.0), (radius * 0.85, height * 0.5), (radius, height)]
    inside = [
        (radius - wall, height),
        (radius * 0.85 - wall, height * 0.5 + wall),
        (foot - wall, wall),
        (0.0, wall),
    ]
    return _turned("bowl", family, mass, outside + inside, colour)


def _bottle(
    category: str,
    family: Family,
    mass: float,
    radius: float,
    height: float,
    neck: float,
    colour: Vector,
) -> ObjectType:
    shoulder = height * 0.62
    profile = [
        (0.0, 0.0),
        (radius, 0.0),
        (radius, shoulder),
        (neck, height * 0.8),
        (neck, height),
        (0.0, height),
    ]
    return _turned(category, family, mass, profile, colour, cap=height * 0.07)


def _vase(
    family: Family, mass: float, radius: float, height: float, colour: Vector, texture: str
) -> ObjectType:
    profile = [
        (0.0, 0.0),
        (radius * 0.6, 0.0),
        (radius, height * 0.4),
        (radius * 0.45, height * 0.8),
        (radius * 0.65, height),
        (0.0, height),
    ]
    return _turned("vase", family, mass, profile, colour, texture)


_MAKERS: dict[str, Callable[[], ObjectType]] = {
    # to learn from
    "cereal-box": lambda: _box(
        "box", "training", 0.45, (0.07, 0.19, 0.29), (0.95, 0.75, 0.2), "", (0.8, 0.2, 0.2)
    ),
    "tissue-box": lambda: _box(
        "box", "training", 0.25, (0.12, 0.23, 0.09), (0.6, 0.8, 0.9), "wallpaper"
    ),
    "shoe-box": lambda: _box(
        "box", "training", 1.1, (0.21, 0.33, 0.13), (0.85, 0.5, 0.3), "", (0.95, 0.95, 0.9)
    ),
    "carton": lambda: _box(
        "box", "training", 3.0, (0.3, 0.4, 0.3), (0.8, 0.65, 0.45), "fabric", (0.7, 0.55, 0.35)
    ),
    "book": lambda: _box(
        "book", "training", 0.5, (0.15, 0.22, 0.035), (0.2, 0.35, 0.7), "", (0.95, 0.93, 0.85)
    ),
    "soup-can": lambda: _can("can", "training", 0.4, 0.038, 0.11, (0.85, 0.15, 0.15)),
    "paint-tin": lambda: _can("can", "training", 1.3, 0.055, 0.13, (0.3, 0.55, 0.85)),
    "water-bottle": lambda: _bottle(
        "bottle", "training", 0.8, 0.037, 0.26, 0.014, (0.35, 0.65, 0.85)
    ),
    "juice-bottle": lambda: _bottle(
        "bottle", "training", 1.1, 0.043, 0.24, 0.02, (0.95, 0.55, 0.1)
    ),
    "mug": lambda: _mug("training", 0.35, 0.041, 0.095, (0.9, 0.9, 0.85)),
    "football": lambda: _ball("training", 0.43, 0.11, (0.95, 0.95, 0.95), "checker"),
    "bowl": lambda: _bowl("training", 0.4, 0.08, 0.065, (0.3, 0.6, 0.45)),
    "vase": lambda: _vase("training", 0.8, 0.07, 0.24, (0.75, 0.55, 0.8), "marble"),
    "waste-bin": lambda: _can(
        "bin", "training", 1.2, 0.13, 0.32, (0.35, 0.35, 0.4), (0.2, 0.2, 0.22)
    ),
    # to test on
    "tea-box": lambda: _box(
        "box", "testing", 0.15, (0.07, 0.13, 0.08), (0.35, 0.6, 0.3), "", (0.95, 0.9, 0.6)
    ),
    "milk-carton": lambda: _box(
        "box", "testing", 1.05, (0.07, 0.07, 0.2), (0.95, 0.95, 0.97), "", (0.15, 0.35, 0.75)
    ),
    "parcel": lambda: _box(
        "box", "testing", 2.0, (0.25, 0.35, 0.2), (0.72, 0.56, 0.38), "", (0.9, 0.85, 0.75)
    ),
    "magazine-box": lambda: _box(
        "book", "testing", 0.9, (0.24, 0.3, 0.06), (0.8, 0.3, 0.35), "", (0.95, 0.95, 0.95)
    ),
    "spray-can": lambda: _can(
        "can", "testing", 0.35, 0.028, 0.19, (0.2, 0.7, 0.65), (0.95, 0.95, 0.95)
    ),
    "coffee-tin": lambda: _can("can", "testing", 0.6, 0.05, 0.15, (0.45, 0.28, 0.16)),
    "wine-bottle": lambda: _bottle("bottle", "testing", 1.25, 0.038, 0.3, 0.015, (0.2, 0.38, 0.22)),
    "syrup-bottle": lambda: _bottle(
        "bottle", "testing", 0.9, 0.033, 0.21, 0.013, (0.65, 0.15, 0.35)
    ),
    "tall-mug": lambda: _mug("testing", 0.4, 0.038, 0.12, (0.25, 0.45, 0.8)),
    "handball": lambda: _ball("testing", 0.35, 0.09, (0.95, 0.6, 0.2), "stripes"),
    "salad-bowl": lambda: _bowl("testing", 0.7, 0.12, 0.09, (0.85, 0.7, 0.5)),
    "tall-vase": lambda: _vase("testing", 1.0, 0.06, 0.3, (0.5, 0.75, 0.85), "tile"),
    "bucket": lambda: _can("bin", "testing", 0.9, 0.15, 0.26, (0.85, 0.3, 0.25), (0.3, 0.3, 0.32)),
}
OBJECTS: dict[str, ObjectType] = {kind: maker() for kind, maker in _MAKERS.items()}
"""Every type of object by its name."""


def of_family(family: Family) -> tuple[str, ...]:
    """Names of the types of a family."""
    return tuple(kind for kind, what in OBJECTS.items() if what.family == family)

"""Types of movable everyday objects, in two disjoint families: one for training, one for testing.

Sizes follow common products and masses their usual content. The origin of an object's frame is its
centre, which is also taken as its centre of mass. All other dimensions are chosen by eye.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from ..geometry import box, concatenate, cylinder, handle, lathe, panel, sphere, transform
from .scene import Movable, Part, Solid, Vector

Family = Literal["training", "testing"]
FAMILIES: tuple[Family, ...] = ("training", "testing")
PLACEMENT_GAP = 0.001
"""Metres: initial gap between an object and its surface; chosen: avoids an initial penetration.
Objects settle before an experiment starts."""

Profile = list[tuple[float, float]]  # (radius, z) from the lowest point on the axis outwards


@dataclass(frozen=True)
class ObjectType:
    """A type of movable object.

    Attributes
    ----------
    category : str
        box, can, bottle, mug, ball, bowl, ...
    family : {"training", "testing"}
    mass : float
        Kilograms.
    half_height : float
        Height of the centre above the supporting surface, metres.
    parts, solids : tuple
        Visible parts and collision shapes, relative to the centre.
    """

    category: str
    family: Family
    mass: float
    half_height: float
    parts: tuple[Part, ...]
    solids: tuple[Solid, ...]


def make_object(kind: str, name: str, x: float, y: float, height: float, heading: float) -> Movable:
    """Make an object of type `kind` that stands at (x, y) on a surface at `height`.

    Lengths are in metres; `heading` is the yaw in rad.
    """
    object_type = OBJECTS[kind]
    half = heading / 2
    return Movable(
        name,
        object_type.category,
        object_type.mass,
        object_type.parts,
        object_type.solids,
        (x, y, height + object_type.half_height + PLACEMENT_GAP),
        (0.0, 0.0, float(np.sin(half)), float(np.cos(half))),
    )


def list_object_types(family: Family) -> tuple[str, ...]:
    """Return the names of the object types of a family."""
    return tuple(kind for kind, object_type in OBJECTS.items() if object_type.family == family)


# ---- shapes --------------------------------------------------------------------------------------


def _box(
    category: str,
    family: Family,
    mass: float,
    size: Vector,
    colour: Vector,
    texture: str = "",
    label: Vector | None = None,
) -> ObjectType:
    """A box, with a band in the colour `label` around its sides if one is given."""
    x, y, z = half = (size[0] / 2, size[1] / 2, size[2] / 2)
    parts = [Part((panel if texture.startswith("art") else box)(half), colour, texture)]
    if label is not None:
        parts.append(Part(box((x * 1.004, y * 1.004, z * 0.35)), label))
    return ObjectType(category, family, mass, z, tuple(parts), (Solid("box", half),))


def _can(
    category: str,
    family: Family,
    mass: float,
    radius: float,
    height: float,
    colour: Vector,
    lid: Vector = (0.8, 0.8, 0.82),
) -> ObjectType:
    """A cylinder with a lid in another colour."""
    rim, half = height * 0.06, height / 2
    body = Part(transform(cylinder(radius, half - rim / 2), (0.0, 0.0, -rim / 2)), colour)
    top = transform(cylinder(radius * 0.96, rim / 2), (0.0, 0.0, half - rim / 2))
    parts = (body, Part(top, lid, "metal"))
    return ObjectType(category, family, mass, half, parts, (Solid("cylinder", (radius, half)),))


def _revolve(
    category: str,
    family: Family,
    mass: float,
    profile: Profile,
    colour: Vector,
    texture: str = "",
    cap: float = 0.0,
) -> ObjectType:
    """A solid of revolution with its foot at z = 0; the top `cap` metres have another colour."""
    height = max(z for _, z in profile)
    half = height / 2
    centred = [(r, z - half) for r, z in profile]
    parts = [Part(lathe(centred, 14), colour, texture)]
    if cap:
        radius = max(r for r, z in profile if z > height - cap) * 1.15
        lid = transform(cylinder(radius, cap / 2, 10), (0.0, 0.0, half - cap / 2 + 0.001))
        parts.append(Part(lid, (0.85, 0.2, 0.15)))
    hull = Solid("hull", vertices=lathe(centred, 10).vertices)
    return ObjectType(category, family, mass, half, tuple(parts), (hull,))


def _mug(family: Family, mass: float, radius: float, height: float, colour: Vector) -> ObjectType:
    wall, half = 0.004, height / 2
    outside = [(0.0, -half), (radius, -half), (radius, half)]
    inside = [(radius - wall, half), (radius - wall, wall - half), (0.0, wall - half)]
    cup = lathe(outside + inside, 14)
    grip = transform(handle(height * 0.3, 0.009), (radius - 0.002, 0.0, 0.0))
    mesh = concatenate([cup, grip])
    hull = Solid("hull", vertices=mesh.vertices)
    return ObjectType("mug", family, mass, half, (Part(mesh, colour),), (hull,))


def _ball(
    family: Family, mass: float, radius: float, colour: Vector, texture: str = ""
) -> ObjectType:
    part, solid = Part(sphere(radius), colour, texture), Solid("sphere", (radius,))
    return ObjectType("ball", family, mass, radius, (part,), (solid,))


def _bowl(family: Family, mass: float, radius: float, height: float, colour: Vector) -> ObjectType:
    foot, middle, wall = radius * 0.5, radius * 0.85, 0.005
    outside = [(0.0, 0.0), (foot, 0.0), (middle, height * 0.5), (radius, height)]
    inside = [(radius - wall, height), (middle - wall, height * 0.5 + wall)]
    bottom = [(foot - wall, wall), (0.0, wall)]
    return _revolve("bowl", family, mass, outside + inside + bottom, colour)


def _bottle(
    family: Family, mass: float, radius: float, height: float, neck: float, colour: Vector
) -> ObjectType:
    body = [(0.0, 0.0), (radius, 0.0), (radius, height * 0.62)]
    top = [(neck, height * 0.8), (neck, height), (0.0, height)]
    return _revolve("bottle", family, mass, body + top, colour, cap=height * 0.07)


def _vase(
    family: Family, mass: float, radius: float, height: float, colour: Vector, texture: str
) -> ObjectType:
    body = [(0.0, 0.0), (radius * 0.6, 0.0), (radius, height * 0.4)]
    neck = [(radius * 0.45, height * 0.8), (radius * 0.65, height), (0.0, height)]
    return _revolve("vase", family, mass, body + neck, colour, texture)


# ---- types ---------------------------------------------------------------------------------------


def _training_types() -> dict[str, ObjectType]:
    family: Family = "training"
    box_type, book_type = partial(_box, "box", family), partial(_box, "book", family)
    can_type, bin_type = partial(_can, "can", family), partial(_can, "bin", family)
    return {
        "cereal-box": box_type(0.45, (0.07, 0.19, 0.29), (0.95, 0.75, 0.2), "", (0.8, 0.2, 0.2)),
        "tissue-box": box_type(0.25, (0.12, 0.23, 0.09), (0.6, 0.8, 0.9), "wallpaper"),
        "shoe-box": box_type(1.1, (0.21, 0.33, 0.13), (0.85, 0.5, 0.3), "", (0.95, 0.95, 0.9)),
        "carton": box_type(3.0, (0.3, 0.4, 0.3), (0.8, 0.65, 0.45), "fabric", (0.7, 0.55, 0.35)),
        "book": book_type(0.5, (0.15, 0.22, 0.035), (0.2, 0.35, 0.7), "", (0.95, 0.93, 0.85)),
        "soup-can": can_type(0.4, 0.038, 0.11, (0.85, 0.15, 0.15)),
        "paint-tin": can_type(1.3, 0.055, 0.13, (0.3, 0.55, 0.85)),
        "water-bottle": _bottle(family, 0.8, 0.037, 0.26, 0.014, (0.35, 0.65, 0.85)),
        "juice-bottle": _bottle(family, 1.1, 0.043, 0.24, 0.02, (0.95, 0.55, 0.1)),
        "mug": _mug(family, 0.35, 0.041, 0.095, (0.9, 0.9, 0.85)),
        "football": _ball(family, 0.43, 0.11, (0.95, 0.95, 0.95), "checker"),
        "bowl": _bowl(family, 0.4, 0.08, 0.065, (0.3, 0.6, 0.45)),
        "vase": _vase(family, 0.8, 0.07, 0.24, (0.75, 0.55, 0.8), "marble"),
        "waste-bin": bin_type(1.2, 0.13, 0.32, (0.35, 0.35, 0.4), (0.2, 0.2, 0.22)),
    }


def _testing_types() -> dict[str, ObjectType]:
    family: Family = "testing"
    box_type, book_type = partial(_box, "box", family), partial(_box, "book", family)
    can_type, bin_type = partial(_can, "can", family), partial(_can, "bin", family)
    return {
        "tea-box": box_type(0.15, (0.07, 0.13, 0.08), (0.35, 0.6, 0.3), "", (0.95, 0.9, 0.6)),
        "milk-carton": box_type(
            1.05, (0.07, 0.07, 0.2), (0.95, 0.95, 0.97), "", (0.15, 0.35, 0.75)
        ),
        "parcel": box_type(2.0, (0.25, 0.35, 0.2), (0.72, 0.56, 0.38), "", (0.9, 0.85, 0.75)),
        "magazine-box": book_type(0.9, (0.24, 0.3, 0.06), (0.8, 0.3, 0.35), "", (0.95, 0.95, 0.95)),
        "spray-can": can_type(0.35, 0.028, 0.19, (0.2, 0.7, 0.65), (0.95, 0.95, 0.95)),
        "coffee-tin": can_type(0.6, 0.05, 0.15, (0.45, 0.28, 0.16)),
        "wine-bottle": _bottle(family, 1.25, 0.038, 0.3, 0.015, (0.2, 0.38, 0.22)),
        "syrup-bottle": _bottle(family, 0.9, 0.033, 0.21, 0.013, (0.65, 0.15, 0.35)),
        "tall-mug": _mug(family, 0.4, 0.038, 0.12, (0.25, 0.45, 0.8)),
        "handball": _ball(family, 0.35, 0.09, (0.95, 0.6, 0.2), "stripes"),
        "salad-bowl": _bowl(family, 0.7, 0.12, 0.09, (0.85, 0.7, 0.5)),
        "tall-vase": _vase(family, 1.0, 0.06, 0.3, (0.5, 0.75, 0.85), "tile"),
        "bucket": bin_type(0.9, 0.15, 0.26, (0.85, 0.3, 0.25), (0.3, 0.3, 0.32)),
    }


OBJECTS: dict[str, ObjectType] = {**_training_types(), **_testing_types()}
"""Every object type by name."""

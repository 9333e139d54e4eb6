"""Appearance randomisation (domain randomisation) of objects and scenes: size, colour, texture."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ...worlds.apartment.geometry import scale
from ...worlds.apartment.rendering.textures import TEXTURES
from ...worlds.apartment.scenes.objects import OBJECTS, Family, list_object_types
from ...worlds.apartment.scenes.scene import Movable, Part, Scene, Solid, Vector

ORIGINAL_FRACTION = 0.5
"""Fraction of the training objects that keep their original size and colours. Chosen, so that
models also train on objects as the tests show them."""


def sample_object(
    name: str, family: Family, position: Vector, rng: np.random.Generator, randomize: bool
) -> Movable:
    """Sample an object of a family.

    Parameters
    ----------
    name : str
    family : str
        ``training`` or ``testing``.
    position : tuple of float
        Metres.
    rng : numpy.random.Generator
    randomize : bool
        Whether to scale and recolour the object, but for ORIGINAL_FRACTION of them.
    """
    kind = OBJECTS[str(rng.choice(list_object_types(family)))]
    if not randomize or rng.uniform() < ORIGINAL_FRACTION:
        return Movable(name, kind.category, kind.mass, kind.parts, kind.solids, position)
    factors = rng.uniform(0.75, 1.3) * rng.uniform(0.85, 1.18, 3)  # along x, y, z; chosen
    factors[1] = factors[0]  # cylinders stay cylinders
    if any(solid.kind == "sphere" for solid in kind.solids):
        factors[2] = factors[0]
    parts = tuple(
        _recolour_object_part(replace(part, mesh=scale(part.mesh, factors.tolist())), rng)
        for part in kind.parts
    )
    solids = tuple(_scale_solid(solid, factors) for solid in kind.solids)
    mass = kind.mass * float(factors.prod())
    return Movable(name, kind.category, mass, parts, solids, position)


def recolour_scene(scene: Scene, rng: np.random.Generator) -> Scene:
    """Return the same scene with other colours and textures of rooms, furniture and objects."""
    fixtures = tuple(
        replace(fixture, parts=tuple(_recolour_fixture_part(part, rng) for part in fixture.parts))
        for fixture in scene.fixtures
    )
    movables = tuple(
        replace(movable, parts=tuple(_recolour_object_part(part, rng) for part in movable.parts))
        for movable in scene.movables
    )
    return replace(scene, fixtures=fixtures, movables=movables)


def _recolour_object_part(part: Part, rng: np.random.Generator) -> Part:
    """Give a part of an object any colour, and in some cases another texture or none."""
    texture = part.texture
    if rng.uniform() < 0.4:
        texture = "" if rng.uniform() < 0.4 else str(rng.choice(TEXTURES))
    return replace(part, colour=_to_vector(rng.uniform(0.1, 1.0, 3)), texture=texture)


def _recolour_fixture_part(part: Part, rng: np.random.Generator) -> Part:
    """Vary the colour of a part of a fixture around its own, in 60 % of the cases."""
    if rng.uniform() > 0.6:
        return part
    colour = np.array(part.colour) * rng.uniform(0.5, 1.3, 3) + rng.uniform(-0.2, 0.2, 3)
    texture = str(rng.choice(TEXTURES)) if rng.uniform() < 0.3 else part.texture
    return replace(part, colour=_to_vector(np.clip(colour, 0.05, 1)), texture=texture)


def _scale_solid(solid: Solid, factors: np.ndarray) -> Solid:
    if solid.kind == "box":
        size = tuple(float(s * f) for s, f in zip(solid.size, factors, strict=True))
    elif solid.kind == "cylinder":
        size = float(solid.size[0] * factors[0]), float(solid.size[1] * factors[2])
    else:
        size = tuple(float(s * factors[0]) for s in solid.size)
    return replace(
        solid,
        size=size,
        position=_to_vector(p * f for p, f in zip(solid.position, factors, strict=True)),
        vertices=None if solid.vertices is None else solid.vertices * factors,
    )


def _to_vector(values: Iterable[float]) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z

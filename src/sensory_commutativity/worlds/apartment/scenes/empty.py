"""An empty floor without end, where everything that a robot does should commute."""

from __future__ import annotations

from .. import geometry
from .scene import Area, Fixture, Part, Scene

FLOOR_EXTENT = 30.0
"""Metres from the centre of an empty floor to its visible edge; it has no physical one. Chosen:
from a camera 1.3 m above the floor, the edge is less than three of 128 pixels below the horizon."""
START_EXTENT = 2.0
"""Metres from the centre of an empty floor within which a robot starts, along x and y. Chosen: the
size of a large room."""


def empty_floor(name: str) -> Scene:
    """An endless floor with nothing on it, tiled, so that camera images show where the robot is."""
    mesh = geometry.transform(geometry.box((FLOOR_EXTENT, FLOOR_EXTENT, 0.01)), (0.0, 0.0, -0.01))
    floor = Fixture("floor", (Part(mesh, (0.8, 0.75, 0.7), "checker"),), ())
    extent = -START_EXTENT, START_EXTENT
    return Scene(name, (floor,), (), (Area("floor", extent, extent),))

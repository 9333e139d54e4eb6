"""Pictures of apartments for people: from above, and of a robot from outside."""

from __future__ import annotations

import math

import numpy as np

from ..physics.simulation import Simulation
from ..scenes.scene import IDENTITIES, Scene
from ..world import drawables
from .camera import Camera, Drawable, Picture, Renderer, look_at

ABOVE = 30.0
"""Metres above the floor of the eye for plans; chosen: walls then hide little."""
MARGIN = 0.25
"""Metres around an apartment on its plan."""


def extent(scene: Scene) -> tuple[float, float, float, float]:
    """Lowest and highest x, lowest and highest y of a scene's areas, metres."""
    return (
        min(area.x[0] for area in scene.areas), max(area.x[1] for area in scene.areas),
        min(area.y[0] for area in scene.areas), max(area.y[1] for area in scene.areas),
    )  # fmt: skip


def plan(
    simulation: Simulation, pixels_per_metre: float = 90.0, robot: bool = False
) -> tuple[np.ndarray, tuple[float, float, float, float]]:
    """A scene from above without ceilings, white where there is nothing.

    Returns
    -------
    uint8 (h, w, 3), tuple
        The picture, x to the right and y up, and its extent (left, right, bottom, top) in metres on the floor.
    """
    left, right, bottom, top = (
        value + margin
        for value, margin in zip(extent(simulation.scene), (-MARGIN, MARGIN) * 2, strict=True)
    )
    width, height = (
        round((right - left) * pixels_per_metre),
        round((top - bottom) * pixels_per_metre),
    )
    seen = [
        piece
        for piece in drawables(simulation, overhead=False)
        if robot or piece.identity != IDENTITIES["robot"]
    ]
    view = math.degrees(2 * math.atan((top - bottom) / 2 / ABOVE))
    middle = (left + right) / 2, (bottom + top) / 2
    picture = _picture(
        simulation, seen, Camera(width, height, view, 3), (*middle, ABOVE), (*middle, 0.0)
    )
    return picture.rgb, (left, right, bottom, top)


def outside(
    simulation: Simulation,
    pixels: int = 480,
    distance: float = 3.2,
    height: float = 2.6,
    bearings: int = 12,
) -> np.ndarray:
    """The robot and what is around it, seen from outside: uint8 (pixels, pixels, 3).

    Of several directions the one is taken from which most of the robot is seen; tall things right before the eye are left out.
    """
    x, y, _ = simulation.base()
    pictures = []
    for bearing in np.arange(bearings) * (2 * math.pi / bearings):
        eye = x + distance * math.cos(bearing), y + distance * math.sin(bearing), height
        seen = [
            piece
            for piece in drawables(simulation, overhead=False)
            if not _hides(piece, eye, (x, y))
        ]
        pictures.append(
            _picture(simulation, seen, Camera(pixels, pixels, 50.0, 3), eye, (x, y, 0.75))
        )
    return max(pictures, key=lambda picture: (picture.identity == IDENTITIES["robot"]).sum()).rgb


def _picture(simulation: Simulation, seen: list[Drawable], camera: Camera, eye, target) -> Picture:
    poses = simulation.poses()
    picture = Renderer(seen, len(poses)).render(camera, look_at(eye, target), poses)
    picture.rgb[picture.identity == IDENTITIES["nothing"]] = 255
    return picture


def _hides(piece: Drawable, eye: tuple[float, float, float], robot: tuple[float, float]) -> bool:
    """Whether something tall is on the way from the eye to the robot, or around the eye."""
    if piece.body != 0:
        return False
    vertices = piece.part.mesh.vertices
    low, high = vertices.min(0), vertices.max(0)
    if high[2] < 1.0:
        return False
    way = np.linspace(eye[:2], np.array(robot) + 0.25 * (np.array(eye[:2]) - robot), 40)
    return bool(((way > low[:2] - 0.05) & (way < high[:2] + 0.05)).all(1).any())

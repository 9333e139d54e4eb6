"""Figures of an apartment: a plan from above, and the robot seen from outside."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..physics.simulation import Simulation
from ..scenes.scene import SEGMENTATION_IDS, Scene
from ..world import collect_drawables
from .camera import Camera, Drawable, Picture, Renderer, look_at

CAMERA_HEIGHT = 30.0
"""Metres: height of the camera of plans; chosen: so high that walls hide little."""
MARGIN = 0.25
"""Metres around an apartment on its plan; chosen: shows the outer walls."""
MAX_LOW_HEIGHT = 1.0
"""Metres: what is lower never hides the robot; chosen: the height of tables and counters."""


def compute_extent(scene: Scene) -> tuple[float, float, float, float]:
    """Return the extent (left, right, bottom, top) of a scene's areas, metres."""
    return (
        min(area.x[0] for area in scene.areas),
        max(area.x[1] for area in scene.areas),
        min(area.y[0] for area in scene.areas),
        max(area.y[1] for area in scene.areas),
    )


def render_plan(
    simulation: Simulation, pixels_per_metre: float = 90.0, robot: bool = False
) -> tuple[np.ndarray, tuple[float, float, float, float]]:
    """Render a scene from above, without ceilings and on a white background.

    Parameters
    ----------
    simulation : Simulation
    pixels_per_metre : float
        Resolution on the floor.
    robot : bool
        Whether to show the robot.

    Returns
    -------
    uint8 (h, w, 3)
        The image, x to the right and y up.
    tuple of float
        Its extent (left, right, bottom, top) on the floor, metres.
    """
    left, right, bottom, top = compute_extent(simulation.scene)
    left, right, bottom, top = left - MARGIN, right + MARGIN, bottom - MARGIN, top + MARGIN
    width = round((right - left) * pixels_per_metre)
    height = round((top - bottom) * pixels_per_metre)
    shown = [
        drawable
        for drawable in collect_drawables(simulation, overhead=False)
        if robot or drawable.segmentation_id != SEGMENTATION_IDS["robot"]
    ]
    field_of_view = math.degrees(2 * math.atan((top - bottom) / 2 / CAMERA_HEIGHT))
    camera = Camera(width, height, field_of_view, 3)
    x, y = (left + right) / 2, (bottom + top) / 2
    picture = _render(simulation, shown, camera, (x, y, CAMERA_HEIGHT), (x, y, 0.0))
    return picture.rgb, (left, right, bottom, top)


def render_third_person(
    simulation: Simulation,
    pixels: int = 480,
    distance: float = 3.2,
    height: float = 2.6,
    bearings: int = 12,
) -> np.ndarray:
    """Render the robot and its surroundings from outside.

    Of several camera positions around the robot, the one that shows most of the robot is used.
    Ceilings and tall fixtures between the camera and the robot are left out.

    Parameters
    ----------
    simulation : Simulation
    pixels : int
        Width and height of the image.
    distance, height : float
        Horizontal distance from the robot and height of the camera, metres.
    bearings : int
        Number of camera positions.

    Returns
    -------
    uint8 (pixels, pixels, 3)
    """
    x, y, _ = simulation.base()
    camera = Camera(pixels, pixels, 50.0, 3)
    pictures = []
    for bearing in np.arange(bearings) * (2 * math.pi / bearings):
        eye = x + distance * math.cos(bearing), y + distance * math.sin(bearing), height
        shown = [
            drawable
            for drawable in collect_drawables(simulation, overhead=False)
            if not _hides_robot(drawable, eye, (x, y))
        ]
        pictures.append(_render(simulation, shown, camera, eye, (x, y, 0.75)))
    return max(pictures, key=_count_robot_pixels).rgb


def _count_robot_pixels(picture: Picture) -> int:
    return int((picture.segmentation == SEGMENTATION_IDS["robot"]).sum())


def _render(
    simulation: Simulation,
    shown: Sequence[Drawable],
    camera: Camera,
    eye: tuple[float, float, float],
    target: tuple[float, float, float],
) -> Picture:
    poses = simulation.poses()
    picture = Renderer(shown, len(poses)).render(camera, look_at(eye, target), poses)
    picture.rgb[picture.segmentation == SEGMENTATION_IDS["nothing"]] = 255
    return picture


def _hides_robot(
    drawable: Drawable, eye: tuple[float, float, float], robot: tuple[float, float]
) -> bool:
    """Whether a tall static drawable is around the camera or between it and the robot."""
    if drawable.body != 0:
        return False
    vertices = drawable.part.mesh.vertices
    low, high = vertices.min(0), vertices.max(0)
    if high[2] < MAX_LOW_HEIGHT:
        return False
    # The line of sight on the floor, up to a quarter of its length before the robot: (40, 2).
    line = np.linspace(eye[:2], np.array(robot) + 0.25 * (np.array(eye[:2]) - robot), 40)
    return bool(((line > low[:2] - 0.05) & (line < high[:2] + 0.05)).all(1).any())

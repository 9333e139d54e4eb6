"""Draws a robot from two sides, with what its camera sees."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..physics.simulation import Simulation
from ..rendering.camera import Camera, Drawable, Renderer, look_at
from ..robots.robot import Robot
from ..scenes.empty import empty_floor
from ..scenes.scene import SEGMENTATION_IDS
from ..world import collect_drawables

PIXELS = 360
VIEW = 40.0
"""Vertical field of view of the cameras beside the robot, degrees; chosen: little distortion."""


def render_portrait(robot: Robot) -> dict[str, np.ndarray]:
    """Render a robot in the middle of its start ranges, on an empty floor.

    Returns
    -------
    dict
        What it shows -> uint8 (PIXELS, PIXELS, 3).
    """
    simulation = Simulation(empty_floor("free-space"), robot)
    simulation.reset(np.zeros(3), robot.start_ranges.mean(1))
    low, high = _bounds(simulation)
    centre, size = (low + high) / 2, float(np.linalg.norm(high - low))
    distance = 0.6 * size / np.tan(np.radians(VIEW / 2))
    poses, drawables = simulation.poses(), collect_drawables(simulation)
    renderer = Renderer(drawables, len(poses))
    camera = Camera(PIXELS, PIXELS, VIEW, 3, near=min(0.05, distance / 20))
    images = {}
    for title, bearing in (("from the front left", 40.0), ("from the right", -90.0)):
        turned = np.radians(bearing)
        direction = np.array([np.cos(turned), np.sin(turned), 0.35])
        eye = centre + distance * direction / np.linalg.norm(direction)
        images[title] = renderer.render(camera, look_at(eye, centre), poses).rgb
    own = Camera(PIXELS, PIXELS, robot.description.camera.field_of_view, 3)
    images["its camera's view"] = renderer.render(own, simulation.camera_pose(), poses).rgb
    simulation.close()
    return images


def draw_portrait(robot: Robot, path: Path) -> None:
    """Write the portrait as a picture file."""
    from matplotlib.figure import Figure  # needs no screen

    images = render_portrait(robot)
    figure = Figure(figsize=(3.2 * len(images), 3.6), layout="constrained")
    for axes, (title, image) in zip(figure.subplots(1, len(images)), images.items(), strict=True):
        axes.imshow(image)
        axes.set_title(title, fontsize="medium")
        axes.set_axis_off()
    figure.suptitle(robot.description.name)
    figure.savefig(path, dpi=130)


def _bounds(simulation: Simulation) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of what is visible of the robot, in the world, metres."""
    poses = simulation.poses()
    points = [
        drawable.part.mesh.vertices @ poses[drawable.body][:3, :3].T + poses[drawable.body][:3, 3]
        for drawable in collect_drawables(simulation)
        if _is_robot(drawable)
    ]
    if not points:  # nothing of it is visible
        return np.array([-0.5, -0.5, 0.0]), np.array([0.5, 0.5, 1.0])
    everything = np.concatenate(points)
    return everything.min(0), everything.max(0)


def _is_robot(drawable: Drawable) -> bool:
    return drawable.segmentation_id == SEGMENTATION_IDS["robot"]

"""Cluttered scenes: an apartment, a robot, and objects in random places (paper, section IV-A)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...worlds.apartment import frames as fr
from ...worlds.apartment.physics.simulation import PARKED
from ...worlds.apartment.rendering.camera import Camera, Picture, Renderer
from ...worlds.apartment.rendering.raster import LIGHT
from ...worlds.apartment.robots.robot import Robot
from ...worlds.apartment.scenes.objects import Family
from ...worlds.apartment.scenes.scene import Movable, Scene
from ...worlds.apartment.world import ApartmentWorld, collect_drawables
from .object_appearance import recolour_scene, sample_object
from .robot_placement import place_robot

PLACEMENT_TRIES = 60
"""Places that are tried for an object before it is left out of the layout. Chosen."""
SETTLE_SUBSTEPS = 600
"""Physics steps (2.5 s) in which the objects of a new layout come to rest. Chosen: Bullet puts
them to sleep after 2 s."""
LYING_FRACTION = 0.2
"""Fraction of the objects that lie on their side. Chosen: as if an arm had pushed them over."""
DROP_HEIGHTS = (2.2, 1.15)
"""Heights, metres, from which the surface below is searched for. Chosen: above all furniture, and
below the upper boards of shelves."""
RECOLOURED_FRACTION = 0.6
"""Fraction of the training layouts in which rooms, furniture and objects have other colours.
Chosen: models train in a single apartment and are tested in others."""
PUT_DOWN_GAP = 0.002
"""Metres between an object that is put down and the surface below. Chosen."""
REMOVED = 40.0
"""x and y, metres, of objects that are not in the apartment. Chosen: far outside."""


class View(NamedTuple):
    """What the cameras see at one moment.

    Attributes
    ----------
    pictures : tuple of Picture
        One per camera.
    camera_pose : float64 (4, 4)
        Frame of all cameras in the world.
    """

    pictures: tuple[Picture, ...]
    camera_pose: np.ndarray


class SceneSampler:
    """Samples layouts of objects in one apartment, and situations of a robot among them.

    Parameters
    ----------
    scene : Scene
        Its own movable objects are replaced.
    robot : Robot
    cameras : sequence of Camera
        All are mounted where the robot's camera is.
    family : str
        Family of the objects: ``training`` or ``testing``.
    rng : numpy.random.Generator
        Source of all randomness.
    objects : int
        Number of objects.
    randomize_appearance : bool
        Whether to vary the size and colours of objects and, in most layouts, the colours of the
        whole scene: for training data. For tests everything keeps its appearance.

    Attributes
    ----------
    world : ApartmentWorld
    simulation : Simulation
        That of `world`.
    resting_poses : float64 (objects, 7)
        Poses of the objects in the present layout while nothing disturbs them.
    """

    def __init__(
        self,
        scene: Scene,
        robot: Robot,
        cameras: Sequence[Camera],
        family: Family,
        rng: np.random.Generator,
        objects: int = 40,
        randomize_appearance: bool = True,
    ):
        self.rng = rng
        self.cameras = tuple(cameras)
        self.randomize_appearance = randomize_appearance
        movables = tuple(
            sample_object(
                f"object-{i}", family, (REMOVED + i, REMOVED, 0.5), rng, randomize_appearance
            )
            for i in range(objects)
        )
        self.scene = replace(scene, movables=movables)
        self.world = ApartmentWorld(self.scene, robot, cameras)
        self.simulation = self.world.simulation
        self.resting_poses = self.simulation.objects.poses()
        self._renderer = self.world.renderer
        self._situations: int | None = None  # sampled in the present layout

    def sample_situation(self, per_layout: int) -> None:
        """Place the robot in the present layout; sample a new layout after `per_layout` calls."""
        if self._situations is None or self._situations >= per_layout:
            self.sample_layout()
            self._situations = 0
        self._situations += 1
        place_robot(self.simulation, self.resting_poses, self.rng)

    def sample_layout(self) -> None:
        """Scatter all objects over floor and furniture, and recolour the scene if randomised."""
        simulation = self.simulation
        simulation.reset(np.array(PARKED), simulation.robot.start_ranges.mean(1))
        for i in range(len(self.scene.movables)):
            self.remove_object(i)
        for i in range(len(self.scene.movables)):
            self._scatter_object(i)
        simulation.wait(SETTLE_SUBSTEPS)
        simulation.set_reset_state()
        self.resting_poses = simulation.objects.poses()
        if self.randomize_appearance:
            self._renderer = self._make_renderer()

    def place_object(
        self,
        i: int,
        x: float,
        y: float,
        search_height: float,
        lying: bool = False,
        heading: float | None = None,
    ) -> bool:
        """Put an object down on the first surface below a point.

        Parameters
        ----------
        i : int
            Index of the object.
        x, y, search_height : float
            The point, metres.
        lying : bool
            Whether the object lies on its side.
        heading : float, optional
            Radians; by default random.

        Returns
        -------
        bool
            False if there is no free surface; the object is then removed.
        """
        self.remove_object(i)  # or it would stand on itself
        surface = self.simulation.collisions.surface_below(x, y, search_height)
        if surface is None:
            return False
        movable = self.scene.movables[i]
        if heading is None:
            heading = self.rng.uniform(-math.pi, math.pi)
        height = _radius(movable) if lying else _half_height(movable)
        frame = fr.on_floor(x, y, heading, surface + height + PUT_DOWN_GAP)
        if lying:
            frame = frame @ fr.rotation(np.array([1.0, 0.0, 0.0]), math.pi / 2)
        self.simulation.objects.place(i, np.array([*frame[:3, 3], *fr.to_quaternion(frame)]))
        if self.simulation.collisions.object_penetrates(i):
            self.remove_object(i)
            return False
        return True

    def remove_object(self, i: int) -> None:
        """Take an object out of the apartment."""
        height = _half_height(self.scene.movables[i]) + PUT_DOWN_GAP
        self.simulation.objects.place(i, np.array([REMOVED + i, REMOVED, height, 0, 0, 0, 1.0]))

    def render_view(self, camera_pose: np.ndarray | None = None, light: np.ndarray = LIGHT) -> View:
        """Render all cameras.

        Parameters
        ----------
        camera_pose : float64 (4, 4), optional
            By default that of the robot's camera.
        light : float64 (3,)
            Unit vector towards the light.
        """
        if camera_pose is None:
            camera_pose = self.simulation.camera_pose()
        poses = self.simulation.poses()
        pictures = (
            self._renderer.render(camera, camera_pose, poses, light) for camera in self.cameras
        )
        return View(tuple(pictures), camera_pose)

    def _scatter_object(self, i: int) -> None:
        areas, rng = self.scene.areas, self.rng
        for _ in range(PLACEMENT_TRIES):
            area = areas[int(rng.integers(len(areas)))]
            lying = rng.uniform() < LYING_FRACTION
            x, y = rng.uniform(*area.x), rng.uniform(*area.y)
            if self.place_object(i, x, y, float(rng.choice(DROP_HEIGHTS)), lying):
                return
        self.remove_object(i)

    def _make_renderer(self) -> Renderer:
        """Return a renderer of the scene, recoloured in RECOLOURED_FRACTION of the cases."""
        scene = self.scene
        if self.rng.uniform() < RECOLOURED_FRACTION:
            scene = recolour_scene(scene, self.rng)
        parts = [part for fixture in scene.fixtures for part in fixture.parts]
        parts += [part for movable in scene.movables for part in movable.parts]
        drawables = collect_drawables(self.simulation)  # fixtures, then objects, then the robot
        for i, part in enumerate(parts):
            drawables[i] = replace(drawables[i], part=part)
        n_bodies = 1 + len(scene.movables) + len(self.simulation.body.parents)
        return Renderer(drawables, n_bodies)


def _radius(movable: Movable) -> float:
    """Metres from the upright axis of an object to its furthest point."""
    return max(float(np.hypot(*part.mesh.vertices[:, :2].T).max()) for part in movable.parts)


def _half_height(movable: Movable) -> float:
    """Metres from the origin of an object to the surface that it stands on."""
    return -float(min(part.mesh.vertices[:, 2].min() for part in movable.parts))

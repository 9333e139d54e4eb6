"""A robot in an apartment as a world for experiments: it starts anywhere valid, acts at 10 Hz, and sees through its camera (paper, section III-B)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .physics.simulation import Simulation
from .physics.starts import draw_start
from .physics.states import Situation
from .rendering.camera import Camera, Drawable, Renderer
from .robots.robot import Robot
from .scenes.scene import IDENTITIES, Scene


class PrivilegedInfo(NamedTuple):
    """What truly happened since the last restore; what no sensor of the robot tells.

    Attributes
    ----------
    touched_fixed, touched_movable, touched_self, at_limit : int
        In how many steps the robot touched a fixture (or the floor, but for base and wheels), a movable object, itself; in how many a joint was
        commanded beyond its limit.
    object_shifts : float64 (movables,)
        How far each object was displaced, metres.
    base : float64 (3,)
        x, y (metres) and heading (rad) of the robot now.
    joints : float64 (n,)
        Joint positions now, rad or m.
    clearance : float
        Metres from the arm to the nearest thing at the start; at most 1.
    """

    touched_fixed: int
    touched_movable: int
    touched_self: int
    at_limit: int
    object_shifts: np.ndarray
    base: np.ndarray
    joints: np.ndarray
    clearance: float


@dataclass(frozen=True)
class WorldSnapshot:
    """A situation of the world."""

    situation: Situation
    clearance: float


class ApartmentWorld:
    """A robot in an apartment.

    Parameters
    ----------
    scene : Scene
    robot : Robot
    cameras : sequence of Camera, optional
        What is seen through; all sit where the robot's camera is. An observation has a picture for each. Without it one with the field of view that
        the robot's description gives.
    within : float, optional
        Metres: starts have something nearer than this to the arm. Without it a robot starts anywhere.

    Attributes
    ----------
    dofs : tuple of Dof
        The robot's degrees of freedom.
    simulation : Simulation
    """

    def __init__(
        self,
        scene: Scene,
        robot: Robot,
        cameras: Sequence[Camera] | None = None,
        within: float | None = None,
    ):
        self.scene, self.robot, self.dofs = scene, robot, robot.dofs
        self.cameras, self.within = (
            tuple(cameras or [Camera(field_of_view=robot.description.camera.field_of_view)]),
            within,
        )
        self.simulation = Simulation(scene, robot)
        self.renderer = Renderer(
            drawables(self.simulation), 1 + len(scene.movables) + len(self.simulation.body.parents)
        )
        self._clearance = float("nan")

    def reset(self, rng: np.random.Generator) -> None:
        """Draw a start situation. Raises StartError where there is none."""
        self._clearance = draw_start(self.simulation, rng, self.within)

    def snapshot(self) -> WorldSnapshot:
        """Return the present situation."""
        return WorldSnapshot(self.simulation.snapshot(), self._clearance)

    def restore(self, snapshot: WorldSnapshot) -> None:
        """Put everything back into a situation of this world."""
        self.simulation.restore(snapshot.situation)
        self._clearance = snapshot.clearance

    def step(self, action: np.ndarray) -> None:
        """Play one action of a tenth of a second: float (len(dofs),), each element in [-1, 1]."""
        self.simulation.step(action)

    def observe(self) -> np.ndarray:
        """What the robot sees: uint8 (cameras, height, width, 3)."""
        eye, poses = self.simulation.eye_pose(), self.simulation.poses()
        return np.stack([self.renderer.render(camera, eye, poses).rgb for camera in self.cameras])

    def happened(self) -> PrivilegedInfo:
        """What happened since the last restore."""
        s, touched = self.simulation, self.simulation.touches()
        return PrivilegedInfo(
            touched.fixed, touched.movable, touched.itself, touched.at_limit, s.object_shifts(), s.base(), s.joints(), self._clearance
        )  # fmt: skip


def drawables(simulation: Simulation, overhead: bool = True) -> list[Drawable]:
    """All that can be seen, bodies numbered as in :meth:`.Simulation.poses`; without `overhead` nothing that hides views from above."""
    scene = simulation.scene
    found = [
        Drawable(part, IDENTITIES["fixture"] + i, 0)
        for i, fixture in enumerate(scene.fixtures)
        if overhead or not fixture.overhead
        for part in fixture.parts
    ]
    found += [
        Drawable(part, IDENTITIES["movable"] + i, 1 + i)
        for i, movable in enumerate(scene.movables)
        for part in movable.parts
    ]
    return found + [
        Drawable(part, IDENTITIES["robot"], 1 + len(scene.movables) + link)
        for link, part in simulation.body.parts
    ]

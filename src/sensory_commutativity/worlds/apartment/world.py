"""A robot in an apartment as a world for SC-experiments (paper, section III-B).

It starts in a random valid pose, acts at 10 Hz and sees through the robot's camera.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .physics.simulation import Simulation
from .physics.snapshots import SimulationSnapshot
from .physics.starts import draw_start
from .rendering.camera import Camera, Drawable, Renderer
from .robots.robot import Robot
from .scenes.scene import SEGMENTATION_IDS, Scene


class PrivilegedInfo(NamedTuple):
    """Ground truth since the last restore, which no sensor of the robot measures.

    Attributes
    ----------
    touched_fixed, touched_movable, touched_self : int
        Steps in which the robot touched a fixture (or the floor with a link other than the base),
        a movable object, itself.
    at_limit : int
        Steps in which a joint was commanded beyond its limit.
    object_shifts : float64 (objects,)
        Displacement of each movable object, metres.
    base : float64 (3,)
        Current x, y (metres) and heading (rad) of the robot.
    joints : float64 (n,)
        Current joint positions, rad or m.
    clearance : float
        Metres from the arm to the nearest fixture or object at the start; at most 1.
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
    """A snapshot of the simulation, and the clearance of the arm at the start, metres."""

    simulation: SimulationSnapshot
    clearance: float


class ApartmentWorld:
    """A robot in an apartment; implements :class:`~sensory_commutativity.scp.world.World`.

    Parameters
    ----------
    scene : Scene
    robot : Robot
    cameras : sequence of Camera, optional
        All are mounted where the robot's camera is; an observation has one image per camera.
        Default: one camera with the field of view of the robot's description.
    within : float, optional
        Metres: in every start something is nearer to the arm than this. Default: no such
        condition.

    Attributes
    ----------
    dofs : tuple of Dof
        The robot's degrees of freedom.
    simulation : Simulation
    renderer : Renderer
    """

    def __init__(
        self,
        scene: Scene,
        robot: Robot,
        cameras: Sequence[Camera] | None = None,
        within: float | None = None,
    ):
        self.scene, self.robot, self.dofs = scene, robot, robot.dofs
        field_of_view = robot.description.camera.field_of_view
        self.cameras = tuple(cameras or [Camera(field_of_view=field_of_view)])
        self.within = within
        self.simulation = Simulation(scene, robot)
        n_bodies = 1 + len(scene.movables) + len(self.simulation.body.parents)
        self.renderer = Renderer(collect_drawables(self.simulation), n_bodies)
        self._clearance = float("nan")

    @property
    def name(self) -> str:
        """Robot and scene, for tables and titles."""
        return f"{self.robot.description.name} in {self.scene.name}"

    def reset(self, rng: np.random.Generator) -> None:
        """Draw a start pose.

        Raises
        ------
        StartError
            No draw was valid.
        """
        self._clearance = draw_start(self.simulation, rng, self.within)

    def snapshot(self) -> WorldSnapshot:
        """Return a snapshot; from here the world continues exactly as after restoring it."""
        return WorldSnapshot(self.simulation.snapshot(), self._clearance)

    def restore(self, snapshot: WorldSnapshot) -> None:
        """Return to a snapshot of this world."""
        self.simulation.restore(snapshot.simulation)
        self._clearance = snapshot.clearance

    def step(self, action: np.ndarray) -> None:
        """Play an action for 0.1 s: float (len(dofs),), clipped to [-1, 1]."""
        self.simulation.step(action)

    def observe(self) -> np.ndarray:
        """Render the robot's cameras: uint8 (cameras, height, width, 3)."""
        pose, poses = self.simulation.camera_pose(), self.simulation.poses()
        return np.stack([self.renderer.render(camera, pose, poses).rgb for camera in self.cameras])

    def happened(self) -> PrivilegedInfo:
        """Return the ground truth since the last restore."""
        contacts = self.simulation.contact_counts()
        return PrivilegedInfo(
            touched_fixed=contacts.fixed,
            touched_movable=contacts.movable,
            touched_self=contacts.itself,
            at_limit=contacts.at_limit,
            object_shifts=self.simulation.objects.displacements(),
            base=self.simulation.base(),
            joints=self.simulation.joints(),
            clearance=self._clearance,
        )


def collect_drawables(simulation: Simulation, overhead: bool = True) -> list[Drawable]:
    """Return everything visible: fixtures, then movable objects, then the robot.

    Parameters
    ----------
    simulation : Simulation
    overhead : bool
        Include ceilings and lintels, which hide the rooms from above.

    Returns
    -------
    list of Drawable
        With bodies numbered as in :meth:`.Simulation.poses`.
    """
    scene, links = simulation.scene, 1 + len(simulation.scene.movables)
    fixtures = [
        Drawable(part, SEGMENTATION_IDS["fixture"] + i, 0)
        for i, fixture in enumerate(scene.fixtures)
        if overhead or not fixture.overhead
        for part in fixture.parts
    ]
    movables = [
        Drawable(part, SEGMENTATION_IDS["movable"] + i, 1 + i)
        for i, movable in enumerate(scene.movables)
        for part in movable.parts
    ]
    robot = [
        Drawable(part, SEGMENTATION_IDS["robot"], links + link)
        for link, part in simulation.body.parts
    ]
    return fixtures + movables + robot

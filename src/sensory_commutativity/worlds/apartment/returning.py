"""Going back to where the robot started, after a push has moved its base: by odometry, or by sight.

Both use the wheels alone; a robot without wheels stays where it is.
"""

from __future__ import annotations

import math

import numpy as np

from ...scp.distances import mean_squared_error
from .robots.robot import CONTROL_STEP
from .world import ApartmentWorld

CLOSE = 0.002, 0.002
"""Metres and rad within which the base counts as back. Chosen: below a pixel of the camera."""
MOST_STEPS = 40
"""Actions of a phase of the way back. Chosen: four seconds, a metre and more."""
TURN = 0.01
"""Rad of the smallest turn that looks for the view of the start. Chosen: about a pixel."""
MOST_TURNS = 25
"""Turns of the search by sight. Chosen."""


class Wheels:
    """The wheels of a robot in an apartment, as forward motion and rotation.

    Parameters
    ----------
    world : ApartmentWorld
    """

    def __init__(self, world: ApartmentWorld):
        self.world, self.drive = world, world.robot.description.drive
        if self.drive is not None:
            joints = [dof.joints for dof in world.robot.description.dofs]
            self.right = joints.index([self.drive.right_wheel])
            self.left = joints.index([self.drive.left_wheel])
            speed = world.dofs[self.right].speed * world.robot.wheel_radius
            self.forward_speed = speed  # metres in an action of 1
            self.turn_speed = 2 * speed / world.robot.track  # rad in an action of 1

    def move(self, forward: float, turn: float) -> None:
        """Play one action that moves by so many metres and rad, or as much of it as one can."""
        assert self.drive is not None
        action = np.zeros(len(self.world.dofs))
        straight, rotate = forward / self.forward_speed, turn / self.turn_speed
        action[self.right], action[self.left] = straight + rotate, straight - rotate
        self.world.step(action / max(1.0, float(np.abs(action).max())))

    def stop(self) -> None:
        """Wait until the base stands: its velocity follows a ramp."""
        for _ in range(math.ceil(0.3 / CONTROL_STEP)):
            self.world.step(np.zeros(len(self.world.dofs)))


def drive_back(world: ApartmentWorld, start: np.ndarray) -> None:
    """Drive to the pose `start` of the base, float (3,): x, y (metres) and heading (rad).

    It turns towards the place, drives there, forward or backward, and turns into the heading, and
    knows its own pose exactly, as with perfect odometry. Where something is in the way it gives up.
    """
    wheels = Wheels(world)
    if wheels.drive is None:
        return
    x, y, heading = world.simulation.base()
    offset = start[:2] - [x, y]
    if np.hypot(*offset) > CLOSE[0]:
        direction = math.atan2(offset[1], offset[0])
        if math.cos(direction - heading) < 0:
            direction += math.pi  # backward is nearer
        _turn_to(wheels, direction)
        for _ in range(MOST_STEPS):
            x, y, heading = world.simulation.base()
            left = float((start[:2] - [x, y]) @ [math.cos(heading), math.sin(heading)])
            if abs(left) < CLOSE[0]:
                break
            wheels.move(left, 0.0)
            wheels.stop()
    _turn_to(wheels, float(start[2]))


def _turn_to(wheels: Wheels, heading: float) -> None:
    for _ in range(MOST_STEPS):
        error = heading - wheels.world.simulation.base()[2]
        error = math.atan2(math.sin(error), math.cos(error))
        if abs(error) < CLOSE[1]:
            return
        wheels.move(0.0, error)
        wheels.stop()


def turn_to_view(world: ApartmentWorld, view: np.ndarray) -> None:
    """Turn on the spot until the cameras see what is most like `view`, an observation of `world`.

    The turn is doubled while it makes the image more alike, and halved and reversed when not
    (mean squared error of the images).
    """
    wheels = Wheels(world)
    if wheels.drive is None:
        return
    best, step = mean_squared_error(world.observe(), view), 4 * TURN
    for _ in range(MOST_TURNS):
        if best == 0 or abs(step) < TURN / 2:
            return
        wheels.move(0.0, step)
        wheels.stop()
        error = mean_squared_error(world.observe(), view)
        if error < best:
            best, step = error, 1.5 * step
        else:
            wheels.move(0.0, -step)
            wheels.stop()
            step = -step / 2

"""A robot: its description and its URDF."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....scp.world import Dof
from .description import DofDescription, RobotDescription
from .urdf import Joint, Urdf

CONTROL_STEP = 0.1
"""Duration of an action, seconds (iGibson acts at 10 Hz: env_base.py, action_timestep 1/10)."""


@dataclass(frozen=True)
class Robot:
    """A description and the URDF that it names."""

    description: RobotDescription
    urdf: Urdf

    @cached_property
    def wheels(self) -> tuple[str, ...]:
        """Joints of the right and the left wheel; empty without a drive."""
        drive = self.description.drive
        return (drive.right_wheel, drive.left_wheel) if drive else ()

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """The joints of degrees of freedom except wheels, depth first from the root.

        Every array of joint positions in this package is in this order.
        """
        driven = {name for dof in self.description.dofs for name in dof.joints} - set(self.wheels)
        joints: list[Joint] = []
        stack = [self.urdf.root]
        while stack:
            below = self.urdf.joints_below(stack.pop())
            joints += [joint for joint in below if joint.name in driven]
            stack += [joint.child for joint in reversed(below)]
        return tuple(joints)

    @cached_property
    def hierarchy(self) -> dict[str, list[str]]:
        """Groups from the lowest expected SCP to the highest, with the names of their dofs."""
        return {
            group: [dof.name for dof in self.description.dofs if dof.group == group]
            for group in self.description.hierarchy
        }

    @cached_property
    def start_ranges(self) -> np.ndarray:
        """Lowest and highest start position of each of `joints`: float64 (n, 2), rad or m."""
        start = self.description.start
        ranges = [start.get(joint.name, (0.0, 0.0)) for joint in self.joints]
        return np.array(ranges, np.float64).reshape(-1, 2)

    @cached_property
    def limits(self) -> np.ndarray:
        """Limits of each of `joints`: float64 (n, 2), rad or m; infinite without stops."""
        limits = [(joint.lower, joint.upper) for joint in self.joints]
        return np.array(limits, np.float64).reshape(-1, 2)

    @cached_property
    def dofs(self) -> tuple[Dof, ...]:
        """The degrees of freedom; their ranges are relative to the middle of the start range."""
        return tuple(self._dof(dof) for dof in self.description.dofs)

    @cached_property
    def height(self) -> float:
        """Metres from the floor to the root link."""
        if self.description.height is not None:
            return self.description.height
        drive = self.description.drive
        if drive is None:
            return 0.0
        return drive.wheel_radius - self._pose_in_root(self.urdf.joints[drive.right_wheel])[2, 3]

    def draw_joints(self, rng: np.random.Generator) -> np.ndarray:
        """Draw joint positions uniformly from the start ranges: float64 (n,), rad or m."""
        return rng.uniform(self.start_ranges[:, 0], self.start_ranges[:, 1])

    def clip_joints(self, joints: np.ndarray) -> np.ndarray:
        """Clip joint positions, float64 (n,), to their limits."""
        return np.clip(joints, self.limits[:, 0], self.limits[:, 1])

    def _dof(self, dof: DofDescription) -> Dof:
        low, high = -math.inf, math.inf
        for joint, start in zip(self.joints, self.start_ranges, strict=True):
            if joint.name in dof.joints:
                low = max(low, joint.lower - start.mean())
                high = min(high, joint.upper - start.mean())
        return Dof(dof.name, dof.unit, dof.velocity * CONTROL_STEP, float(low), float(high))

    def _pose_in_root(self, joint: Joint) -> np.ndarray:
        """Return the frame of a joint's child in the root, all joints at zero: float64 (4, 4)."""
        above = next((j for j in self.urdf.joints.values() if j.child == joint.parent), None)
        return joint.frame if above is None else self._pose_in_root(above) @ joint.frame

"""Polyphemus, the one-eyed agent of the paper (section III-A): its morphology, its degrees of freedom, its speeds.

The numbers marked *authors* are those of the authors' simulator at the time of the paper (simple-playgrounds, commits of November 2019);
the rest is *chosen*, with the reason beside it and in ``docs/differences.md``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...scp.world import Dof

N_LINKS = 5
"""Rigid bodies of the agent: base, left upper arm, left forearm, right upper arm, right forearm."""

PARENT = (-1, 0, 1, 0, 3)
"""The body that each link hangs on."""

JOINT_NAMES = ("left-shoulder", "left-elbow", "right-shoulder", "right-elbow")


@dataclass(frozen=True)
class Polyphemus:
    """Morphology of the agent. Lengths in Flatland units (the room is 600 x 800), angles in rad, speeds per step.

    Left is counter-clockwise of straight ahead. A positive action turns counter-clockwise on the left arm and clockwise on the right one,
    so that equal actions move the arms as mirror images.
    """

    base_radius: float = 25.0  # authors
    base_mass: float = 20.0  # authors
    arm_length: float = 50.0  # authors; length of each of an arm's two segments
    arm_width: float = 5.0  # authors
    arm_mass: float = 1.0  # authors; of each segment
    shoulder_rest: float = math.radians(
        60
    )  # chosen: arms open to the front, at rest just outside the field of view
    elbow_rest: float = math.radians(-30)  # chosen: slightly bent inwards
    joint_range: float = math.inf  # chosen: either way from rest; a stop does not commute, and the authors' pi/3 is hit in most sequences
    longitudinal_speed: float = (
        8.0  # chosen: the authors' base is pushed to about 4 and coasts; this one stops at once
    )
    angular_speed: float = 0.25  # authors; base, head and arm joints alike
    eyelid_speed: float = 1 / 20  # authors
    eyelid_range: tuple[float, float] = (0.0, 2.0)  # authors; starts at 1, multiplies what is seen
    pixels: int = 64  # paper, section III-A
    field_of_view: float = math.radians(90)  # paper, section III-A
    view_range: float = 1000.0  # authors used 250 to 1000; the diagonal of the room, so that no wall is out of sight

    @property
    def dofs(self) -> tuple[Dof, ...]:
        """The eight degrees of freedom, in the order of the action vector."""
        turn = self.angular_speed
        joints = tuple(
            Dof(name, "rad", turn, -self.joint_range, self.joint_range) for name in JOINT_NAMES
        )
        low, high = self.eyelid_range
        return (
            Dof("base-longitudinal", "units", self.longitudinal_speed),
            Dof("base-rotation", "rad", turn),
            Dof("head", "rad", turn, displaces=False),
            Dof("eyelid", "1", self.eyelid_speed, low - 1.0, high - 1.0, displaces=False),
            *joints,
        )

    @property
    def rest_angles(self) -> np.ndarray:
        """Joint angles at the start, rad, shape (4,): each segment's direction relative to what it hangs on."""
        left = np.array([self.shoulder_rest, self.elbow_rest])
        return np.concatenate([left, -left])

    @property
    def joint_signs(self) -> np.ndarray:
        """+1 where a positive action turns a joint counter-clockwise, -1 where clockwise; shape (4,)."""
        return np.array([1.0, 1.0, -1.0, -1.0])

    def link_poses(self, x: float, y: float, heading: float) -> np.ndarray:
        """Poses of the five links with the joints at rest: (x, y, angle), float64, shape (5, 3)."""
        poses = np.empty((N_LINKS, 3))
        poses[0] = x, y, heading
        for side in (0, 1):
            normal = heading + (math.pi / 2 if side == 0 else -math.pi / 2)
            joint_x = x + self.base_radius * math.cos(normal)
            joint_y = y + self.base_radius * math.sin(normal)
            angle = heading
            for segment in (0, 1):
                angle += self.rest_angles[2 * side + segment]
                dx, dy = (
                    math.cos(angle) * self.arm_length / 2,
                    math.sin(angle) * self.arm_length / 2,
                )
                poses[1 + 2 * side + segment] = joint_x + dx, joint_y + dy, angle
                joint_x, joint_y = joint_x + 2 * dx, joint_y + 2 * dy
        return poses

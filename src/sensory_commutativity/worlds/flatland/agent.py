"""Polyphemus, the one-eyed agent of the paper (section III-A): morphology, dofs and speeds.

Values marked *authors* are those of the authors' simulator at the time of the paper
(simple-playgrounds, commits of November 2019). The others are *chosen*; the reasons are given here
and in ``docs/differences.md``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...scp.world import Dof

N_LINKS = 5
"""Rigid bodies of the agent: base, left upper arm, left forearm, right upper arm, right forearm."""

PARENT = (-1, 0, 1, 0, 3)
"""Index of the link to which each link is attached."""

JOINT_NAMES = ("left-shoulder", "left-elbow", "right-shoulder", "right-elbow")


@dataclass(frozen=True)
class Polyphemus:
    """Morphology of the agent. Lengths in Flatland units, angles in rad, speeds per step.

    Left is counter-clockwise of straight ahead. A positive action turns a joint of the left arm
    counter-clockwise and one of the right arm clockwise: equal actions move the arms as mirror
    images.
    """

    base_radius: float = 25.0  # authors
    base_mass: float = 20.0  # authors
    arm_length: float = 50.0  # authors; of each of the two segments of an arm
    arm_width: float = 5.0  # authors
    arm_mass: float = 1.0  # authors; of each segment
    # Chosen: the arms open to the front and rest just outside the field of view.
    shoulder_rest: float = math.radians(60)
    elbow_rest: float = math.radians(-30)  # chosen: slightly bent inwards
    # Either way from rest. Chosen: motion into a stop does not commute, and most sequences would
    # reach the authors' pi/3.
    joint_range: float = math.inf
    # Chosen: the authors' base is pushed to about 4 and coasts, whereas this one stops at once.
    longitudinal_speed: float = 8.0
    angular_speed: float = 0.25  # authors; base, head and arm joints alike
    eyelid_speed: float = 1 / 20  # authors
    eyelid_range: tuple[float, float] = (0.0, 2.0)  # authors; a factor of the colours, 1 at start
    pixels: int = 64  # paper, section III-A
    field_of_view: float = math.radians(90)  # paper, section III-A
    # The authors used 250 to 1000. Chosen: the diagonal of the room, to see every wall.
    view_range: float = 1000.0

    @property
    def dofs(self) -> tuple[Dof, ...]:
        """The eight degrees of freedom, in the order of the action vector."""
        turn = self.angular_speed
        low, high = self.eyelid_range
        return (
            Dof("base-longitudinal", "units", self.longitudinal_speed),
            Dof("base-rotation", "rad", turn),
            Dof("head", "rad", turn, displaces=False),
            Dof("eyelid", "1", self.eyelid_speed, low - 1.0, high - 1.0, displaces=False),
            *(Dof(name, "rad", turn, -self.joint_range, self.joint_range) for name in JOINT_NAMES),
        )

    @property
    def rest_angles(self) -> np.ndarray:
        """Joint angles at the start, rad, float64 (4,): direction relative to the parent link."""
        left = np.array([self.shoulder_rest, self.elbow_rest])
        return np.concatenate([left, -left])

    @property
    def joint_signs(self) -> np.ndarray:
        """+1 if a positive action turns a joint counter-clockwise, -1 if clockwise; shape (4,)."""
        return np.array([1.0, 1.0, -1.0, -1.0])

    def link_poses(self, x: float, y: float, heading: float) -> np.ndarray:
        """Poses of the links with all joints at rest.

        Parameters
        ----------
        x, y, heading : float
            Pose of the base; units, rad.

        Returns
        -------
        float64 (5, 3)
            x, y, angle of each link's centre.
        """
        poses = np.empty((N_LINKS, 3))
        poses[0] = x, y, heading
        rest_angles = self.rest_angles
        for side in (0, 1):
            normal = heading + (math.pi / 2 if side == 0 else -math.pi / 2)
            joint_x = x + self.base_radius * math.cos(normal)
            joint_y = y + self.base_radius * math.sin(normal)
            angle = heading
            for segment in (0, 1):
                angle += rest_angles[2 * side + segment]
                dx = math.cos(angle) * self.arm_length / 2
                dy = math.sin(angle) * self.arm_length / 2
                poses[1 + 2 * side + segment] = joint_x + dx, joint_y + dy, angle
                joint_x, joint_y = joint_x + 2 * dx, joint_y + 2 * dy
        return poses

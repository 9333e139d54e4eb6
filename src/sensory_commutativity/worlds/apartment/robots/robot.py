"""A robot: its description and its URDF."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....scp.world import Dof
from .. import frames as fr
from .description import DofDescription, RobotDescription
from .urdf import Joint, Mimic, Urdf

CONTROL_STEP = 0.1
"""Duration of an action, seconds (iGibson acts at 10 Hz: env_base.py, action_timestep 1/10)."""
MAX_AXLE_OFFSET = 0.005
"""Metres between the axle and the root link that are neglected; chosen: a hundredth of a track."""
MAX_AXLE_ANGLE = 0.02
"""Angle between the axle and the root link's y axis that is neglected, rad; chosen: a degree."""


@dataclass(frozen=True)
class Robot:
    """A description and the URDF that it names."""

    description: RobotDescription
    urdf: Urdf

    # ---- joints ------------------------------------------------------------------------------

    @cached_property
    def wheels(self) -> tuple[str, ...]:
        """Joints of the right and the left wheel; empty without a drive."""
        drive = self.description.drive
        return (drive.right_wheel, drive.left_wheel) if drive else ()

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """The joints that degrees of freedom move, except wheels, depth first from the root.

        Every array of joint positions in this package is in this order.
        """
        moved = set(self.dof_of_joint) - set(self.wheels)
        joints: list[Joint] = []
        stack = [self.urdf.root]
        while stack:
            below = self.urdf.joints_below(stack.pop())
            joints += [joint for joint in below if joint.name in moved]
            stack += [joint.child for joint in reversed(below)]
        return tuple(joints)

    @cached_property
    def followers(self) -> dict[str, Mimic]:
        """Joints that follow another: name -> the joint of a degree of freedom, and how."""
        listed = {name: dof.name for dof in self.description.dofs for name in dof.joints}
        ratios = {name for dof in self.description.dofs for name in dof.ratio}
        found = {}
        for joint in self.urdf.joints.values():
            mimic = self._resolve_mimic(joint, set(listed) - {joint.name})
            if mimic is None or mimic.multiplier == 0 or joint.kind == "fixed":
                continue
            master = mimic.joint
            same = listed.get(joint.name, listed.get(master)) == listed.get(master)
            if master in listed and master not in self.wheels and same and joint.name not in ratios:
                found[joint.name] = mimic
        return found

    @cached_property
    def dof_of_joint(self) -> dict[str, int]:
        """Index of the degree of freedom that moves a joint, followers included."""
        dofs = {name: k for k, dof in enumerate(self.description.dofs) for name in dof.joints}
        return dofs | {name: dofs[mimic.joint] for name, mimic in self.followers.items()}

    @cached_property
    def ratio_of_joint(self) -> dict[str, float]:
        """How far each joint moves for each unit that its degree of freedom moves."""
        ratios = {name: dof.ratio.get(name, 1.0) for dof in self.description.dofs
                  for name in dof.joints}  # fmt: skip
        for name, mimic in self.followers.items():
            ratios[name] = mimic.multiplier * ratios[mimic.joint]
        return ratios

    def fixed_position(self, joint: Joint) -> float:
        """Position of a joint that no degree of freedom moves, rad or m."""
        fixed = self.description.fixed
        mimic = None if joint.name in fixed else self._resolve_mimic(joint, set(fixed))
        if mimic is not None:
            master = self.fixed_position(self.urdf.joints[mimic.joint])
            return mimic.multiplier * master + mimic.offset
        return fixed.get(joint.name, min(max(0.0, joint.lower), joint.upper))

    def _resolve_mimic(self, joint: Joint, masters: set[str]) -> Mimic | None:
        """What a joint follows, through chains of mimics up to one of `masters` or to their end."""
        multiplier, offset, current = 1.0, 0.0, joint
        while current.mimic is not None and (current is joint or current.name not in masters):
            offset += multiplier * current.mimic.offset
            multiplier *= current.mimic.multiplier
            current = self.urdf.joints[current.mimic.joint]
        return None if current is joint else Mimic(current.name, multiplier, offset)

    # ---- positions of joints -----------------------------------------------------------------

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
        ranges = {joint.name: start.get(joint.name, (0.0, 0.0)) for joint in self.joints}
        for name, mimic in self.followers.items():
            ends = [mimic.multiplier * end + mimic.offset for end in ranges[mimic.joint]]
            ranges[name] = (min(ends), max(ends))
        return np.array(list(ranges.values()), np.float64).reshape(-1, 2)

    @cached_property
    def limits(self) -> np.ndarray:
        """Limits of each of `joints`: float64 (n, 2), rad or m; infinite without stops.

        A joint and those that follow it stop together, at whichever stop comes first.
        """
        limits = {joint.name: (joint.lower, joint.upper) for joint in self.joints}
        for name, mimic in self.followers.items():
            low, high = limits[mimic.joint]
            ends = sorted((end - mimic.offset) / mimic.multiplier for end in limits[name])
            if min(high, ends[1]) > max(low, ends[0]):  # else the follower's own make no sense
                limits[mimic.joint] = max(low, ends[0]), min(high, ends[1])
        for name, mimic in self.followers.items():
            ends = sorted(mimic.multiplier * end + mimic.offset for end in limits[mimic.joint])
            limits[name] = ends[0], ends[1]
        return np.array(list(limits.values()), np.float64).reshape(-1, 2)

    def draw_joints(self, rng: np.random.Generator) -> np.ndarray:
        """Draw joint positions uniformly from the start ranges: float64 (n,), rad or m."""
        drawn = rng.uniform(self.start_ranges[:, 0], self.start_ranges[:, 1])
        return self._follow(drawn)

    def clip_joints(self, joints: np.ndarray) -> np.ndarray:
        """Clip joint positions, float64 (n,), to their limits; followers follow."""
        return self._follow(np.clip(joints, self.limits[:, 0], self.limits[:, 1]))

    def _follow(self, joints: np.ndarray) -> np.ndarray:
        index = {joint.name: i for i, joint in enumerate(self.joints)}
        for name, mimic in self.followers.items():
            joints[index[name]] = mimic.multiplier * joints[index[mimic.joint]] + mimic.offset
        return joints

    @cached_property
    def dofs(self) -> tuple[Dof, ...]:
        """The degrees of freedom; their ranges are relative to the middle of the start range."""
        return tuple(self._dof(dof) for dof in self.description.dofs)

    def _dof(self, dof: DofDescription) -> Dof:
        low, high = -math.inf, math.inf
        for joint, start, limits in zip(self.joints, self.start_ranges, self.limits, strict=True):
            if joint.name in dof.joints and joint.name not in self.followers:
                ends = sorted((limits - start.mean()) / self.ratio_of_joint[joint.name])
                low, high = max(low, ends[0]), min(high, ends[1])
        return Dof(dof.name, dof.unit, dof.velocity * CONTROL_STEP, float(low), float(high))

    # ---- where it stands ---------------------------------------------------------------------

    @cached_property
    def wheel_positions(self) -> np.ndarray:
        """Centres of the right and the left wheel in the root link: float64 (2, 3), metres."""
        return np.array([self.pose_in_root(self.urdf.joints[name])[:3, 3] for name in self.wheels])

    @cached_property
    def axle(self) -> tuple[float, float, float]:
        """Middle of the axle in the root link, x and y in metres, and the angle of travel, rad."""
        right, left = self.wheel_positions
        x, y = (right + left)[:2] / 2
        drive, across = self.description.drive, left - right
        if drive is not None and drive.axle is not None:
            x = drive.axle
        angle = math.atan2(-across[0], across[1])
        if math.hypot(x, y) <= MAX_AXLE_OFFSET:
            x = y = 0.0
        return float(x), float(y), 0.0 if abs(angle) <= MAX_AXLE_ANGLE else angle

    @cached_property
    def track(self) -> float:
        """Distance between the wheels, metres."""
        drive = self.description.drive
        assert drive is not None
        return self.measured_track if drive.track is None else drive.track

    @cached_property
    def measured_track(self) -> float:
        """Distance between the wheels in the URDF, metres."""
        right, left = self.wheel_positions
        return float(np.linalg.norm((left - right)[:2]))

    @cached_property
    def wheel_radius(self) -> float:
        """Metres."""
        drive = self.description.drive
        assert drive is not None
        if drive.wheel_radius is not None:
            return drive.wheel_radius
        from .shape_sizes import measure_wheel_radius

        return measure_wheel_radius(self.urdf, drive.right_wheel)

    @cached_property
    def height(self) -> float:
        """Metres from the floor to the root link."""
        if self.description.height is not None:
            return self.description.height
        if self.description.drive is None:
            return 0.0
        return self.wheel_radius - float(self.wheel_positions[0, 2])

    @cached_property
    def root_frame(self) -> np.ndarray:
        """Frame of the root link in the robot's own: float64 (4, 4).

        The robot's own frame is on the floor, below the middle of the axle if it has a drive, and
        looks where it drives.
        """
        lifted = fr.translation(np.array([0.0, 0.0, 1.0]), self.height)
        x, y, angle = self.axle if self.wheels else (0.0, 0.0, 0.0)
        if x == y == angle == 0:
            return lifted
        return lifted @ fr.on_floor(0.0, 0.0, -angle) @ fr.on_floor(-x, -y, 0.0)

    def pose_in_root(self, joint: Joint) -> np.ndarray:
        """Return the frame of a joint's child in the root, all joints at zero: float64 (4, 4)."""
        frame, above = joint.frame, self.urdf.joint_above(joint.parent)
        while above is not None:
            frame = above.frame @ frame
            above = self.urdf.joint_above(above.parent)
        return frame

"""Places and orientations as 4 x 4 matrices.

A frame's columns are its x, y and z axis and its origin, seen from the frame that it is given in; lengths in metres, angles in radians.
"""

from __future__ import annotations

import math

import numpy as np

from .scenes.scene import Quaternion, Vector


def from_rpy(position: Vector = (0.0, 0.0, 0.0), rpy: Vector = (0.0, 0.0, 0.0)) -> np.ndarray:
    """The frame at `position`, turned by roll, pitch and yaw about the outer x, y and z axes in this order, as URDF has it: float64 (4, 4)."""
    (sr, sp, sy), (cr, cp, cy) = [math.sin(a) for a in rpy], [math.cos(a) for a in rpy]
    frame = np.eye(4)
    frame[:3, :3] = (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )
    frame[:3, 3] = position
    return frame


def to_rpy(frame: np.ndarray) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a frame."""
    r = frame[:3, :3]
    pitch = math.atan2(-r[2, 0], math.hypot(r[0, 0], r[1, 0]))
    if (
        math.hypot(r[0, 0], r[1, 0]) < 1e-9
    ):  # looking straight up or down: roll and yaw turn about the same axis, so all is put into roll
        return math.atan2(-r[1, 2], r[1, 1]), pitch, 0.0
    return math.atan2(r[2, 1], r[2, 2]), pitch, math.atan2(r[1, 0], r[0, 0])


def from_quaternion(position: Vector, rotation: Quaternion) -> np.ndarray:
    """The frame at `position` with the rotation (x, y, z, w): float64 (4, 4)."""
    x, y, z, w = rotation
    s = 2 / (x * x + y * y + z * z + w * w)
    frame = np.eye(4)
    frame[:3, :3] = (
        (1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)),
        (s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)),
        (s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)),
    )
    frame[:3, 3] = position
    return frame


def to_quaternion(frame: np.ndarray) -> Quaternion:
    """The rotation of a frame: (x, y, z, w)."""
    from scipy.spatial.transform import Rotation

    return tuple(float(value) for value in Rotation.from_matrix(frame[:3, :3]).as_quat())  # type: ignore[return-value]


def turned(axis: np.ndarray, angle: float) -> np.ndarray:
    """The frame that is turned by `angle` about the unit vector `axis`: float64 (4, 4)."""
    half = math.sin(angle / 2)
    return from_quaternion(
        (0.0, 0.0, 0.0), (axis[0] * half, axis[1] * half, axis[2] * half, math.cos(angle / 2))
    )


def shifted(axis: np.ndarray, distance: float) -> np.ndarray:
    """The frame that is moved by `distance` along the unit vector `axis`: float64 (4, 4)."""
    frame = np.eye(4)
    frame[:3, 3] = np.asarray(axis) * distance
    return frame


def on_floor(x: float, y: float, heading: float, height: float = 0.0) -> np.ndarray:
    """The upright frame at (x, y, height), its x axis turned by `heading` from the world's: float64 (4, 4)."""
    return from_rpy((x, y, height), (0.0, 0.0, heading))


def apply(frame: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points given in `frame`, float64 (n, 3), in the frame that `frame` is given in."""
    return np.asarray(points) @ frame[:3, :3].T + frame[:3, 3]

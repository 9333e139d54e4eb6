"""Rigid transforms as 4 x 4 homogeneous matrices, here called frames.

The columns of a frame are its x, y and z axes and its origin, expressed in the parent frame.
Lengths are in metres, angles in radians; all matrices are float64.
"""

from __future__ import annotations

import math

import numpy as np

from .scenes.scene import Quaternion, Vector


def from_rpy(position: Vector = (0.0, 0.0, 0.0), rpy: Vector = (0.0, 0.0, 0.0)) -> np.ndarray:
    """Return the frame at `position` with the given roll, pitch and yaw: float64 (4, 4).

    The rotations are about the fixed x, y and z axes in this order, as in URDF
    (https://wiki.ros.org/urdf/XML/joint).
    """
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
    """Return roll, pitch and yaw of a frame, rad; the inverse of :func:`from_rpy`."""
    r = frame[:3, :3]
    pitch = math.atan2(-r[2, 0], math.hypot(r[0, 0], r[1, 0]))
    if math.hypot(r[0, 0], r[1, 0]) < 1e-9:  # gimbal lock: roll and yaw are about the same axis
        return math.atan2(-r[1, 2], r[1, 1]), pitch, 0.0
    return math.atan2(r[2, 1], r[2, 2]), pitch, math.atan2(r[1, 0], r[0, 0])


def from_quaternion(position: Vector, rotation: Quaternion) -> np.ndarray:
    """Return the frame at `position` with `rotation` as (x, y, z, w): float64 (4, 4)."""
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
    """Return the rotation of a frame as a unit quaternion (x, y, z, w)."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = (float(value) for value in Rotation.from_matrix(frame[:3, :3]).as_quat())
    return x, y, z, w


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the rotation by `angle` about the unit vector `axis`: float64 (4, 4)."""
    half = math.sin(angle / 2)
    return from_quaternion(
        (0.0, 0.0, 0.0), (axis[0] * half, axis[1] * half, axis[2] * half, math.cos(angle / 2))
    )


def translation(axis: np.ndarray, distance: float) -> np.ndarray:
    """Return the translation by `distance` along the unit vector `axis`: float64 (4, 4)."""
    frame = np.eye(4)
    frame[:3, 3] = np.asarray(axis) * distance
    return frame


def on_floor(x: float, y: float, heading: float, height: float = 0.0) -> np.ndarray:
    """Return the upright frame at (x, y, height) with yaw `heading`: float64 (4, 4)."""
    return from_rpy((x, y, height), (0.0, 0.0, heading))


def apply(frame: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Transform points, float64 (n, 3), from `frame` to its parent frame."""
    return np.asarray(points) @ frame[:3, :3].T + frame[:3, 3]

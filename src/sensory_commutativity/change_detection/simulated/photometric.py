"""Photometric and camera-pose augmentation: light, exposure, noise, and small camera motion."""

from __future__ import annotations

import math

import numpy as np

from ...worlds.apartment import frames as fr
from ...worlds.apartment.rendering.raster import LIGHT

JITTER = 0.4
"""Standard deviation, degrees, of the rotation of a camera that came back almost exactly. Chosen:
about one pixel."""
SHIFT_PER_DEGREE = 0.004
"""Metres of camera displacement per degree of jitter. Chosen."""


def sample_light(rng: np.random.Generator) -> np.ndarray:
    """Sample a unit vector towards the light, a few degrees from the default: float64 (3,)."""
    light = LIGHT + rng.normal(0, 0.06, 3)
    return light / np.linalg.norm(light)


def jitter_camera(camera_pose: np.ndarray, scale: float, rng: np.random.Generator) -> np.ndarray:
    """Rotate and displace a camera slightly.

    Parameters
    ----------
    camera_pose : float64 (4, 4)
    scale : float
        Standard deviation of the rotation, degrees. The displacement along each axis has a
        standard deviation of SHIFT_PER_DEGREE per degree of it.
    rng : numpy.random.Generator

    Returns
    -------
    float64 (4, 4)
    """
    axis = rng.normal(size=3)
    angle = math.radians(rng.normal(0, scale))
    jittered = camera_pose @ fr.rotation(axis / np.linalg.norm(axis), angle)
    jittered[:3, 3] += rng.normal(0, SHIFT_PER_DEGREE * scale, 3)
    return jittered


def apply_camera_noise(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Simulate the exposure, tint and noise of a real camera on a picture, uint8 (h, w, 3).

    Chosen ranges: exposure varies by up to 7 % and 4 grey levels, tint by up to 2 % per channel;
    the noise has a standard deviation of up to 2 grey levels.
    """
    gain = (1 + rng.uniform(-0.07, 0.07)) * (1 + rng.uniform(-0.02, 0.02, 3))
    noisy = rgb * gain + rng.normal(0, rng.uniform(0, 2.0), rgb.shape) + rng.uniform(-4, 4)
    return np.clip(noisy + 0.5, 0, 255).astype(np.uint8)

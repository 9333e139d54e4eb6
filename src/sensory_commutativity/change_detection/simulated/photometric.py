"""What makes two pictures of the same thing unequal: light, exposure, noise, and a camera that came back almost."""

from __future__ import annotations

import math

import numpy as np

from ...worlds.apartment import frames as fr
from ...worlds.apartment.rendering.raster import LIGHT

JITTER = 0.4
"""Scale in degrees of how a camera that came back is turned, with 4 mm of displacement per degree. Chosen: about a pixel."""


def sample_light(rng: np.random.Generator) -> np.ndarray:
    """A direction to the light, a few degrees from the usual one: float64 (3,), of length 1."""
    light = LIGHT + rng.normal(0, 0.06, 3)
    return light / np.linalg.norm(light)


def jitter_camera(eye: np.ndarray, scale: float, rng: np.random.Generator) -> np.ndarray:
    """The frame of a camera, float64 (4, 4), turned by some degrees of this scale and displaced by 4 mm per degree of it."""
    axis = rng.normal(size=3)
    eye = eye @ fr.turned(axis / np.linalg.norm(axis), math.radians(rng.normal(0, scale)))
    eye[:3, 3] += rng.normal(0, 0.004 * scale, 3)
    return eye


def apply_camera_noise(rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A picture, uint8 (h, w, 3), with a real camera's exposure (7 % and 4 grey levels at most), tint (2 %), and noise (standard
    deviation at most 2 grey levels)."""
    gain = (1 + rng.uniform(-0.07, 0.07)) * (1 + rng.uniform(-0.02, 0.02, 3))
    noisy = rgb * gain + rng.normal(0, rng.uniform(0, 2.0), rgb.shape) + rng.uniform(-4, 4)
    return np.clip(noisy + 0.5, 0, 255).astype(np.uint8)

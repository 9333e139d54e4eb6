"""Photometric augmentation changes pictures a little."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity.change_detection.simulated.photometric import (
    apply_camera_noise,
    jitter_camera,
    sample_light,
)


def test_light_camera_pose_and_picture_change_a_little():
    rng = np.random.default_rng(0)
    lights = np.array([sample_light(rng) for _ in range(20)])
    assert np.linalg.norm(lights, axis=1) == pytest.approx(1)
    assert 0 < np.ptp(lights, axis=0).max() < 0.5
    pose = jitter_camera(np.eye(4), 0.4, rng)
    assert pose[:3, :3] @ pose[:3, :3].T == pytest.approx(np.eye(3))
    assert 0 < np.abs(pose - np.eye(4)).max() < 0.05
    picture = rng.integers(30, 200, (64, 64, 3)).astype(np.uint8)
    noisy = np.array([apply_camera_noise(picture, rng) for _ in range(20)])
    assert noisy.dtype == np.uint8 and (noisy != picture).any((1, 2, 3)).all()
    assert np.abs(noisy.astype(int) - picture).mean() < 15

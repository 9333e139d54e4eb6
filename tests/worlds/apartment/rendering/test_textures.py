"""Textures differ from each other and repeat without visible seams."""

from __future__ import annotations

import numpy as np

from sensory_commutativity.worlds.apartment.rendering.textures import (
    TEXTURE_SIZE,
    TEXTURES,
    make_texture,
)

PATTERNED = ("planks", "fabric", "stripes", "plaid", "rug", "metal", "wallpaper", "books")
"""Textures whose pattern has an edge at the border, beside art-1 to art-3."""


def test_textures_are_not_flat_and_all_different():
    for name in TEXTURES:
        image = make_texture(name)
        assert image.shape == (TEXTURE_SIZE, TEXTURE_SIZE, 3), name
        assert image.dtype == np.uint8, name
        assert image.std() > 1, name
    assert len({make_texture(name).tobytes() for name in TEXTURES}) == len(TEXTURES)


def test_textures_without_a_border_repeat_without_a_seam():
    seamless = [n for n in TEXTURES if n not in PATTERNED and not n.startswith("art")]
    for name in seamless:
        image = make_texture(name).astype(float)
        for axis in (0, 1):
            steps = np.abs(np.diff(image, axis=axis)).mean(axis=(1 - axis, 2))
            seam = np.abs(image.take(0, axis) - image.take(-1, axis)).mean()
            assert seam <= 1.1 * steps.max(), (name, axis)

"""Textures, drawn rather than apply_camera_noise, so that nothing has to be shipped: wood, brick, carpet, tiles, wallpaper, books, pictures.

Each is a square of 64 x 64 pixels that repeats without a seam; it is multiplied by the colour of what it lies on.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

SIZE = 64
"""Pixels along a side; a power of 2, by which the rasteriser wraps."""


def _waves(seed: int, count: int, across: int, down: int) -> np.ndarray:
    """A sum of random waves with at most so many periods: float64 (64, 64), about -1 to 1, seamless."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:SIZE, 0:SIZE] * (2 * np.pi / SIZE)
    total = sum(
        np.sin(
            rng.integers(-across, across + 1) * x
            + rng.integers(-down, down + 1) * y
            + rng.uniform(0, 2 * np.pi)
        )
        for _ in range(count)
    )
    return total / np.sqrt(count)


def _grain(seed: int, strength: float) -> np.ndarray:
    """Noise that is smooth over about two pixels: float64 (64, 64)."""
    noise = np.random.default_rng(seed).normal(size=(SIZE, SIZE))
    return (
        strength
        * (noise + np.roll(noise, 1, 0) + np.roll(noise, 1, 1) + np.roll(noise, (1, 1), (0, 1)))
        / 2
    )


def _tinted(light: np.ndarray, colour: tuple[float, float, float]) -> np.ndarray:
    return light[..., None] * np.asarray(colour)


def _wood(seed: int, colour: tuple[float, float, float]) -> np.ndarray:
    y, _ = np.mgrid[0:SIZE, 0:SIZE] / SIZE
    rings = np.sin(2 * np.pi * 5 * y + 1.3 * _waves(seed, 4, 1, 2))
    return _tinted(0.82 + 0.1 * rings + _grain(seed + 1, 0.02), colour)


def _planks() -> np.ndarray:
    image = _wood(11, (1.0, 0.85, 0.66))
    shades = np.random.default_rng(12).uniform(0.82, 1.05, 4)
    for k in range(4):
        rows = slice(16 * k, 16 * k + 16)
        image[rows] *= shades[k]
        image[16 * k] *= 0.6
        image[rows, (23 * k) % SIZE] *= 0.65
    return image


def _woven(seed: int) -> np.ndarray:
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    return _tinted(
        0.85 + 0.08 * np.where((x // 2 + y // 2) % 2, 1, -1) + _grain(seed, 0.03), (1, 1, 1)
    )


def _stripes() -> np.ndarray:
    x = np.mgrid[0:SIZE, 0:SIZE][1]
    return _woven(21) * np.where((x // 8) % 2, 1.0, 0.62)[..., None]


def _plaid() -> np.ndarray:
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    light = 1.0 - 0.28 * ((x // 16) % 2) - 0.28 * ((y // 16) % 2)
    light[(x % 32 == 7) | (y % 32 == 7)] = 1.15
    return _woven(31) * light[..., None]


def _carpet() -> np.ndarray:
    return _tinted(0.8 + 0.12 * _waves(41, 10, 9, 9) + _grain(42, 0.06), (1, 1, 1))


def _rug() -> np.ndarray:
    y, x = np.mgrid[0:SIZE, 0:SIZE] - (SIZE - 1) / 2
    ring = np.maximum(np.abs(x), np.abs(y)) // 4
    diamond = (np.abs(x) + np.abs(y)) // 6
    image = np.ones((SIZE, SIZE, 3)) * (1.0, 0.9, 0.8)
    image[ring % 2 == 1] = (0.9, 0.45, 0.4)
    image[(ring < 5) & (diamond % 2 == 1)] = (0.45, 0.5, 0.75)
    return image + _grain(51, 0.03)[..., None]


def _grid(period: int, joint: float, light: float, seed: int) -> np.ndarray:
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    cells = np.random.default_rng(seed).uniform(0.92, 1.04, (SIZE // period, SIZE // period))
    shade = light * cells[y // period, x // period] + _grain(seed + 1, 0.01)
    return _tinted(np.where((x % period == 0) | (y % period == 0), joint, shade), (1, 1, 1))


def _checker() -> np.ndarray:
    y, x = np.mgrid[0:SIZE, 0:SIZE] // (SIZE // 2)
    return _tinted(np.where((x + y) % 2, 0.95, 0.5) + _grain(61, 0.02), (1, 1, 1))


def _brick() -> np.ndarray:
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    row = y // 8
    along = (x + 8 * (row % 2)) % SIZE
    shade = np.random.default_rng(71).uniform(0.75, 1.1, (8, 4))[row, along // 16]
    image = _tinted(shade + _grain(72, 0.04), (0.95, 0.55, 0.42))
    image[(y % 8 == 0) | (along % 16 == 0)] = (0.85, 0.83, 0.8)
    return image


def _marble() -> np.ndarray:
    veins = np.abs(_waves(81, 5, 2, 2))
    return _tinted(0.75 + 0.22 * np.minimum(1, veins * 2) + _grain(82, 0.01), (1, 1, 1))


def _metal() -> np.ndarray:
    brushed = np.random.default_rng(91).normal(size=(SIZE, 1)) * 0.04
    return _tinted(0.88 + brushed + _grain(92, 0.01), (1, 1, 1))


def _plaster() -> np.ndarray:
    return _tinted(0.94 + _grain(101, 0.025), (1, 1, 1))


def _wallpaper() -> np.ndarray:
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    image = np.ones((SIZE, SIZE, 3)) * 0.96
    for cy, cx in ((16, 16), (48, 48)):
        distance, angle = np.hypot(y - cy, x - cx), np.arctan2(y - cy, x - cx)
        image[distance < 7 + 3 * np.cos(5 * angle)] = (0.72, 0.78, 0.62)
        image[distance < 3] = (0.95, 0.8, 0.5)
    image[x % 32 == 0] *= 0.9
    return image


def _leather() -> np.ndarray:
    return _tinted(0.82 + 0.08 * _waves(111, 12, 7, 7) + _grain(112, 0.02), (1, 1, 1))


def _books() -> np.ndarray:
    rng = np.random.default_rng(121)
    image = np.zeros((SIZE, SIZE, 3)) + 0.12
    for top in (0, 32):  # two shelves
        x = 0
        while x < SIZE:
            width, height = int(rng.integers(4, 8)), int(rng.integers(21, 29))
            image[top + 30 - height : top + 30, x : x + width - 1] = rng.uniform(0.2, 0.95, 3)
            image[top + 30 - height + 5 : top + 30 - height + 7, x : x + width - 1] *= 0.6
            x += width
        image[top + 30 : top + 32] = (0.55, 0.4, 0.28)
    return image


def _art(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    image = np.ones((SIZE, SIZE, 3)) * rng.uniform(0.5, 1.0, 3)
    for _ in range(9):
        cy, cx, ry, rx = *rng.uniform(8, 56, 2), *rng.uniform(5, 22, 2)
        inside = (
            ((y - cy) / ry) ** 2 + ((x - cx) / rx) ** 2 < 1
            if rng.uniform() < 0.5
            else (np.abs(y - cy) < ry) & (np.abs(x - cx) < rx)
        )
        image[inside] = rng.uniform(0.05, 1.0, 3)
    image[(y < 4) | (y >= 60) | (x < 4) | (x >= 60)] = (0.18, 0.14, 0.1)  # the frame
    return image


_DRAWN: dict[str, Callable[[], np.ndarray]] = {
    "wood": lambda: _wood(1, (1.0, 0.8, 0.58)),
    "darkwood": lambda: _wood(5, (0.55, 0.36, 0.24)),
    "planks": _planks,
    "fabric": lambda: _woven(17),
    "stripes": _stripes,
    "plaid": _plaid,
    "carpet": _carpet,
    "rug": _rug,
    "tile": lambda: _grid(16, 0.6, 0.97, 55),
    "checker": _checker,
    "brick": _brick,
    "marble": _marble,
    "metal": _metal,
    "plaster": _plaster,
    "wallpaper": _wallpaper,
    "leather": _leather,
    "books": _books,
    "art-1": lambda: _art(201),
    "art-2": lambda: _art(202),
    "art-3": lambda: _art(203),
}
TEXTURES: tuple[str, ...] = tuple(_DRAWN)
"""Names of all textures."""


@cache
def texture(name: str) -> np.ndarray:
    """The texture of this name, red, green, blue: uint8 (64, 64, 3), not to be written to."""
    image = (np.clip(_DRAWN[name](), 0, 1) * 255).round().astype(np.uint8)
    image.flags.writeable = False
    return image

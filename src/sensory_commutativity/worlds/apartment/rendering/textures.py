"""Procedural textures: wood, brick, carpet, tiles, wallpaper, books, pictures.

They are generated, because then no image files have to be shipped. Each is a square of
TEXTURE_SIZE pixels, made to be repeated, and is multiplied by the colour of the part that it
covers. All patterns and seeds are chosen by eye.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

TEXTURE_SIZE = 64
"""Pixels per side; chosen: enough for images of 128 pixels. Must be a power of 2, because the
rasteriser wraps with a bit mask."""


def _pixel_grid() -> np.ndarray:
    """Row and column of every pixel: int (2, 64, 64)."""
    return np.mgrid[0:TEXTURE_SIZE, 0:TEXTURE_SIZE]


def _waves(seed: int, count: int, across: int, down: int) -> np.ndarray:
    """A seamless sum of `count` random waves: float64 (64, 64), about -1 to 1.

    The waves have at most `across` periods along the rows and `down` along the columns.
    """
    rng = np.random.default_rng(seed)
    y, x = _pixel_grid() * (2 * np.pi / TEXTURE_SIZE)
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
    """Seamless noise that is smooth over about two pixels: float64 (64, 64)."""
    noise = np.random.default_rng(seed).normal(size=(TEXTURE_SIZE, TEXTURE_SIZE))
    below, right = np.roll(noise, 1, 0), np.roll(noise, 1, 1)
    return strength * (noise + below + right + np.roll(noise, (1, 1), (0, 1))) / 2


def _tint(light: np.ndarray, colour: tuple[float, float, float] = (1, 1, 1)) -> np.ndarray:
    """Multiply a brightness, (64, 64), by a colour: float64 (64, 64, 3)."""
    return light[..., None] * np.asarray(colour)


def _wood(seed: int, colour: tuple[float, float, float]) -> np.ndarray:
    y, _ = _pixel_grid() / TEXTURE_SIZE
    rings = np.sin(2 * np.pi * 5 * y + 1.3 * _waves(seed, 4, 1, 2))
    return _tint(0.82 + 0.1 * rings + _grain(seed + 1, 0.02), colour)


def _planks() -> np.ndarray:
    image = _wood(11, (1.0, 0.85, 0.66))
    shades = np.random.default_rng(12).uniform(0.82, 1.05, 4)
    for k in range(4):
        rows = slice(16 * k, 16 * k + 16)
        image[rows] *= shades[k]
        image[16 * k] *= 0.6
        image[rows, (23 * k) % TEXTURE_SIZE] *= 0.65
    return image


def _woven(seed: int) -> np.ndarray:
    y, x = _pixel_grid()
    threads = np.where((x // 2 + y // 2) % 2, 1, -1)
    return _tint(0.85 + 0.08 * threads + _grain(seed, 0.03))


def _stripes() -> np.ndarray:
    x = _pixel_grid()[1]
    return _woven(21) * np.where((x // 8) % 2, 1.0, 0.62)[..., None]


def _plaid() -> np.ndarray:
    y, x = _pixel_grid()
    light = 1.0 - 0.28 * ((x // 16) % 2) - 0.28 * ((y // 16) % 2)
    light[(x % 32 == 7) | (y % 32 == 7)] = 1.15
    return _woven(31) * light[..., None]


def _carpet() -> np.ndarray:
    return _tint(0.8 + 0.12 * _waves(41, 10, 9, 9) + _grain(42, 0.06))


def _rug() -> np.ndarray:
    y, x = _pixel_grid() - (TEXTURE_SIZE - 1) / 2
    ring = np.maximum(np.abs(x), np.abs(y)) // 4
    diamond = (np.abs(x) + np.abs(y)) // 6
    image = np.ones((TEXTURE_SIZE, TEXTURE_SIZE, 3)) * (1.0, 0.9, 0.8)
    image[ring % 2 == 1] = (0.9, 0.45, 0.4)
    image[(ring < 5) & (diamond % 2 == 1)] = (0.45, 0.5, 0.75)
    return image + _grain(51, 0.03)[..., None]


def _tiles(period: int, joint: float, light: float, seed: int) -> np.ndarray:
    """Square tiles `period` pixels wide; `light` and `joint` are their brightness and the gaps'."""
    y, x = _pixel_grid()
    n = TEXTURE_SIZE // period
    cells = np.random.default_rng(seed).uniform(0.92, 1.04, (n, n))
    shade = light * cells[y // period, x // period] + _grain(seed + 1, 0.01)
    return _tint(np.where((x % period == 0) | (y % period == 0), joint, shade))


def _checker() -> np.ndarray:
    y, x = _pixel_grid() // (TEXTURE_SIZE // 2)
    return _tint(np.where((x + y) % 2, 0.95, 0.5) + _grain(61, 0.02))


def _brick() -> np.ndarray:
    y, x = _pixel_grid()
    row = y // 8
    along = (x + 8 * (row % 2)) % TEXTURE_SIZE
    shade = np.random.default_rng(71).uniform(0.75, 1.1, (8, 4))[row, along // 16]
    image = _tint(shade + _grain(72, 0.04), (0.95, 0.55, 0.42))
    image[(y % 8 == 0) | (along % 16 == 0)] = (0.85, 0.83, 0.8)
    return image


def _marble() -> np.ndarray:
    veins = np.abs(_waves(81, 5, 2, 2))
    return _tint(0.75 + 0.22 * np.minimum(1, veins * 2) + _grain(82, 0.01))


def _metal() -> np.ndarray:
    brushed = np.random.default_rng(91).normal(size=(TEXTURE_SIZE, 1)) * 0.04
    return _tint(0.88 + brushed + _grain(92, 0.01))


def _plaster() -> np.ndarray:
    return _tint(0.94 + _grain(101, 0.025))


def _wallpaper() -> np.ndarray:
    y, x = _pixel_grid()
    image = np.ones((TEXTURE_SIZE, TEXTURE_SIZE, 3)) * 0.96
    for cy, cx in ((16, 16), (48, 48)):
        distance, angle = np.hypot(y - cy, x - cx), np.arctan2(y - cy, x - cx)
        image[distance < 7 + 3 * np.cos(5 * angle)] = (0.72, 0.78, 0.62)
        image[distance < 3] = (0.95, 0.8, 0.5)
    image[x % 32 == 0] *= 0.9
    return image


def _leather() -> np.ndarray:
    return _tint(0.82 + 0.08 * _waves(111, 12, 7, 7) + _grain(112, 0.02))


def _books() -> np.ndarray:
    rng = np.random.default_rng(121)
    image = np.zeros((TEXTURE_SIZE, TEXTURE_SIZE, 3)) + 0.12
    for top in (0, 32):  # two shelves
        x = 0
        while x < TEXTURE_SIZE:
            width, height = int(rng.integers(4, 8)), int(rng.integers(21, 29))
            image[top + 30 - height : top + 30, x : x + width - 1] = rng.uniform(0.2, 0.95, 3)
            image[top + 30 - height + 5 : top + 30 - height + 7, x : x + width - 1] *= 0.6
            x += width
        image[top + 30 : top + 32] = (0.55, 0.4, 0.28)
    return image


def _art(seed: int) -> np.ndarray:
    """A framed abstract picture of ellipses and rectangles."""
    rng = np.random.default_rng(seed)
    y, x = _pixel_grid()
    image = np.ones((TEXTURE_SIZE, TEXTURE_SIZE, 3)) * rng.uniform(0.5, 1.0, 3)
    for _ in range(9):
        cy, cx, ry, rx = *rng.uniform(8, 56, 2), *rng.uniform(5, 22, 2)
        if rng.uniform() < 0.5:
            inside = ((y - cy) / ry) ** 2 + ((x - cx) / rx) ** 2 < 1
        else:
            inside = (np.abs(y - cy) < ry) & (np.abs(x - cx) < rx)
        image[inside] = rng.uniform(0.05, 1.0, 3)
    image[(y < 4) | (y >= 60) | (x < 4) | (x >= 60)] = (0.18, 0.14, 0.1)  # the frame
    return image


# ---- all textures --------------------------------------------------------------------------------

_GENERATORS: dict[str, Callable[[], np.ndarray]] = {
    "wood": lambda: _wood(1, (1.0, 0.8, 0.58)),
    "darkwood": lambda: _wood(5, (0.55, 0.36, 0.24)),
    "planks": _planks,
    "fabric": lambda: _woven(17),
    "stripes": _stripes,
    "plaid": _plaid,
    "carpet": _carpet,
    "rug": _rug,
    "tile": lambda: _tiles(16, 0.6, 0.97, 55),
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
TEXTURES: tuple[str, ...] = tuple(_GENERATORS)
"""Names of all textures. A texture id is an index into this tuple."""


@cache
def make_texture(name: str) -> np.ndarray:
    """Return a texture by name: read-only uint8 (64, 64, 3), red, green, blue."""
    image = (np.clip(_GENERATORS[name](), 0, 1) * 255).round().astype(np.uint8)
    image.flags.writeable = False
    return image

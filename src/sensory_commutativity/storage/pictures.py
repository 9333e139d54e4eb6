"""Pictures from elsewhere, opened by the formats that they may have and no others.

Pillow otherwise tries all of its readers, and one of them passes PostScript on to Ghostscript,
which executes it.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from PIL import Image, ImageOps, ImageSequence

from ..errors import UserError
from .files import check_regular_file, printable

FORMATS = {".png": ("PNG",), ".gif": ("GIF",), ".jpg": ("JPEG",), ".jpeg": ("JPEG",)}
"""Suffix -> formats of the figures of a run."""
PHOTOS = ("PNG", "JPEG")
"""Formats of pictures that people give."""
DEEP = {".tif": ("TIFF",), ".tiff": ("TIFF",)}
"""Suffix -> formats of pictures that may hold floats."""
MAX_BYTES = 200_000_000
"""Size of a file; chosen: ten times that of a large photograph."""
MAX_PIXELS = 32_000_000
"""Of one picture; chosen: cameras of telephones make up to 12 million, and two pictures of this
size are compared within 1 GB."""
MAX_ELONGATION = 5
"""Longer side of a photograph in shorter sides; chosen: a panorama has 3, and the memory of a
comparison grows with the square."""
MAX_FRAME_PIXELS = 200_000_000
"""Of all frames of an animation; chosen: four times our longest, and decoded within seconds."""


class PictureError(UserError):
    """A file cannot be read as a picture."""


@contextmanager
def open_picture(
    path: Path, formats: Sequence[str], remedy: str, error: type[UserError] = PictureError
) -> Iterator[Image.Image]:
    """Open a picture of one of `formats`, of a bounded size.

    Whatever the block raises because of the file's content becomes `error`, in one line.

    Raises
    ------
    error
        If the file is missing, not a regular file, of another format, too large, or damaged.
    """
    if not path.exists():
        raise error(f"{path}: there is no such file; {remedy}")
    check_regular_file(path, error, remedy, MAX_BYTES)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # bounded below
            with Image.open(path, formats=list(formats)) as picture:
                width, height = picture.size
                if width * height > MAX_PIXELS:
                    raise error(
                        f"{path}: has {width:,} x {height:,} pixels, and at most {MAX_PIXELS:,} "
                        f"are read; {remedy}"
                    )
                yield picture
    except UserError:
        raise
    except Exception as problem:  # the bytes decide what Pillow's readers raise
        reason = printable((str(problem).splitlines() or ["?"])[0])
        raise error(f"{path}: cannot be read as a picture ({reason:.80}); {remedy}") from None


def read_photo(path: Path, error: type[UserError] = PictureError) -> np.ndarray:
    """Read a PNG or JPEG file, or a TIFF file that is named so, upright by its EXIF tag.

    Returns uint8 (h, w, 3), RGB, or float64 (h, w) of a grey picture of more than 8 bits, which
    Pillow would cut off at 255.

    Raises `error` if the file is missing, too large, too long, damaged, or of another format.
    """
    formats = DEEP.get(path.suffix.lower(), PHOTOS)
    with open_picture(path, formats, "give a PNG, JPEG or TIFF file", error) as picture:
        shorter, longer = sorted(picture.size)
        if longer > MAX_ELONGATION * shorter:
            raise error(
                f"{path}: has {picture.width:,} x {picture.height:,} pixels; no side may be longer "
                f"than {MAX_ELONGATION} times the other: crop it"
            )
        upright = ImageOps.exif_transpose(picture)
        if upright.mode == "F" or upright.mode.startswith("I"):
            return np.asarray(upright).astype(np.float64)
        return np.asarray(upright.convert("RGB"))


def check_picture(path: Path, remedy: str) -> None:
    """Read a figure or an animation from beginning to end. Raises PictureError."""
    formats = FORMATS[path.suffix]
    with open_picture(path, formats, remedy) as picture:
        picture.verify()
    with open_picture(path, formats, remedy) as picture:
        pixels = 0
        for frame in ImageSequence.Iterator(picture):
            pixels += frame.width * frame.height
            if pixels > MAX_FRAME_PIXELS:
                raise PictureError(
                    f"{path}: its frames have more than {MAX_FRAME_PIXELS:,} pixels; {remedy}"
                )
            frame.load()

"""What moved between two picture files: the outcome in words, and a picture of the masks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, ImageOps, UnidentifiedImageError
from scipy.ndimage import maximum_filter

from ..storage.atomic import atomic_write
from .decision import MASK_THRESHOLD
from .outcome import Outcome
from .predictor import PredictorError, check_same_size, load_predictor
from .tta import MIN_SIDE, SIDE_MULTIPLE

TRAINING_SIDE = 128
"""Pixels: height and width of the training pictures, and shorter side of what is predicted."""
OUTLINE = (213, 94, 0)  # vermilion, which colour-blind readers can tell apart
_DESCRIPTIONS: dict[Outcome, str] = {
    "identical": "identical: the same view, and nothing in it moved",
    "different": "different: another view",
    "moved": "moved: the same view, in which something moved",
}


def predict_files(first: Path, second: Path, predictor: Path, out: Path) -> str:
    """Predict what moved between two picture files.

    Parameters
    ----------
    first, second : Path
        Pictures of equal size. They are scaled to about the size of the training pictures.
    predictor : Path
        A file of :meth:`.predictor.MaskPredictor.save`.
    out : Path
        PNG file to write: both pictures side by side, with outlined masks.

    Returns
    -------
    str
        The outcome in words, with the number of pixels of each mask.

    Raises
    ------
    PredictorError
        If a file is not a picture, or if the pictures differ in size or are too small.
    """
    loaded = load_predictor(predictor)
    pictures = [read_picture(path) for path in (first, second)]
    check_same_size(*pictures)
    prediction = loaded.predict(*(resize_to_training(picture) for picture in pictures))
    sides = pictures[0].shape[:2]
    masks = np.zeros((2, *sides), bool)
    pixels = ""
    if prediction.outcome == "moved":
        for mask, probabilities in zip(masks, prediction.probabilities, strict=True):
            mask[:] = _resize(probabilities, sides, Image.Resampling.BILINEAR) > MASK_THRESHOLD
        n_first, n_second = masks.sum((1, 2))
        pixels = f" ({n_first} pixels in {first.name}, {n_second} in {second.name})"
    outlined = [draw_outline(*pair) for pair in zip(pictures, masks, strict=True)]
    with atomic_write(out) as temporary:
        Image.fromarray(np.concatenate(outlined, axis=1)).save(temporary, format="PNG")
    return f"{_DESCRIPTIONS[prediction.outcome]}{pixels}; see {out}"


def read_picture(path: Path) -> np.ndarray:
    """Read a picture file as RGB, upright by its EXIF tag: uint8 (h, w, 3).

    Raises PredictorError if the file is missing or cannot be read as a picture.
    """
    unreadable = (  # Pillow raises SyntaxError for a damaged PNG file
        UnidentifiedImageError,
        Image.DecompressionBombError,
        OSError,
        ValueError,
        SyntaxError,
    )
    try:
        with Image.open(path) as picture:
            return np.asarray(ImageOps.exif_transpose(picture).convert("RGB"))
    except FileNotFoundError:
        raise PredictorError(f"{path}: there is no such file; give two pictures") from None
    except unreadable as error:
        raise PredictorError(
            f"{path}: cannot be read as a picture ({str(error)[:80]}); give a PNG or JPEG file"
        ) from None


def resize_to_training(picture: np.ndarray) -> np.ndarray:
    """Scale a picture, uint8 (h, w, 3), so that its shorter side has TRAINING_SIDE pixels.

    The longer side is rounded to SIDE_MULTIPLE, which stretches the picture by at most an eighth.
    Raises PredictorError if a side has less than MIN_SIDE pixels.
    """
    height, width = picture.shape[:2]
    shorter = min(height, width)
    if shorter < MIN_SIDE:
        raise PredictorError(
            f"the pictures have {height} x {width} pixels; both sides must have at least {MIN_SIDE}"
        )
    new_height, new_width = (
        SIDE_MULTIPLE * round(side * TRAINING_SIDE / shorter / SIDE_MULTIPLE)
        for side in (height, width)
    )
    return _resize(picture, (new_height, new_width), Image.Resampling.BOX)


def draw_outline(picture: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Draw a line around a mask, bool (h, w), on a copy of a picture, uint8 (h, w, 3).

    The line is the thicker, the larger the picture is.
    """
    drawn = picture.copy()
    thickness = max(1, round(min(mask.shape) / TRAINING_SIDE))
    drawn[maximum_filter(mask, 2 * thickness + 1) & ~mask] = OUTLINE
    return drawn


def _resize(image: np.ndarray, sides: tuple[int, ...], resampling: Image.Resampling) -> np.ndarray:
    """Resize a picture, or a map of probabilities, to another height and width."""
    if image.shape[:2] == sides:
        return image
    height, width = sides
    return np.asarray(Image.fromarray(image).resize((width, height), resampling))

"""What moved between two pictures of one's own: from picture files to an outcome, and to a picture for people."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, ImageOps, UnidentifiedImageError
from scipy.ndimage import maximum_filter

from ..storage.atomic import atomic_write
from .decision import MASK
from .outcome import Outcome
from .predictor import PredictorError, load_predictor, of_one_size
from .tta import LEAST_SIDE, SIDE_STEP

SHIPPED = (
    Path(__file__).resolve().parents[3]
    / "results"
    / "paper"
    / "models"
    / "masks"
    / "raft.predictor"
)
"""The RAFT of the run at the paper's sizes, which is committed."""
SIDE = 128
"""Pixels: the shorter side of what the predictor is shown, as in its training."""
OUTLINE = (213, 94, 0)  # vermilion, which colour-blind readers can tell apart
_SAID: dict[Outcome, str] = {
    "identical": "identical: the same view, and nothing in it moved",
    "different": "different: another view",
    "moved": "moved: the same view but for what moved",
}


def predict_files(first: Path, second: Path, predictor: Path | None, out: Path) -> str:
    """The outcome of two picture files in words, with the pixels of each mask; `out` shows both, the masks outlined.

    The predictor sees them about as large as the pictures it was trained with, whatever their size. Raises PredictorError for files that are no
    pictures, of different sizes, or too small.
    """
    if predictor is None and not SHIPPED.is_file():
        raise PredictorError(
            f"no predictor comes with this installation ({SHIPPED} is not there); give one with --predictor"
        )
    loaded = load_predictor(predictor or SHIPPED)
    pictures = [read_picture(path) for path in (first, second)]
    of_one_size(*pictures)
    found = loaded.predict(*(as_trained(picture) for picture in pictures))
    masks = np.zeros((2, *pictures[0].shape[:2]), bool)
    if found.outcome == "moved":
        masks[:] = [
            _resized(one, masks.shape[1:], Image.Resampling.BILINEAR) > MASK
            for one in found.probabilities
        ]
    with atomic_write(out) as temporary:
        Image.fromarray(
            np.concatenate([outlined(*pair) for pair in zip(pictures, masks, strict=True)], axis=1)
        ).save(temporary, format="PNG")
    sizes = (
        f" ({masks[0].sum()} pixels in {first.name}, {masks[1].sum()} in {second.name})"
        if found.outcome == "moved"
        else ""
    )
    return f"{_SAID[found.outcome]}{sizes}; see {out}"


def read_picture(path: Path) -> np.ndarray:
    """A picture file in red, green and blue: uint8 (h, w, 3). Raises PredictorError."""
    try:
        with Image.open(path) as picture:
            return np.asarray(ImageOps.exif_transpose(picture).convert("RGB"))
    except FileNotFoundError:
        raise PredictorError(f"{path}: there is no such file; give two pictures") from None
    except (
        UnidentifiedImageError,
        Image.DecompressionBombError,
        OSError,
        ValueError,
        SyntaxError,
    ) as error:  # damaged PNG: SyntaxError
        raise PredictorError(
            f"{path}: cannot be read as a picture ({str(error)[:80]}); give a PNG or JPEG file"
        ) from None


def as_trained(picture: np.ndarray) -> np.ndarray:
    """A picture, uint8 (h, w, 3), scaled so that its shorter side has SIDE pixels: uint8 (height, width, 3).

    The longer side is rounded to what predictors take, whereby pictures are stretched by an eighth at most. Raises PredictorError for less than
    LEAST_SIDE pixels.
    """
    sides = picture.shape[:2]
    if min(sides) < LEAST_SIDE:
        raise PredictorError(
            f"the pictures have {sides[0]} x {sides[1]} pixels; give such of which both sides have at least {LEAST_SIDE}"
        )
    height, width = (SIDE_STEP * round(side * SIDE / min(sides) / SIDE_STEP) for side in sides)
    return _resized(picture, (height, width), Image.Resampling.BOX)


def outlined(picture: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """The picture, uint8 (h, w, 3), with a line around the mask, bool (h, w), which is thicker in larger pictures."""
    shown = picture.copy()
    thickness = max(1, round(min(mask.shape) / SIDE))
    shown[maximum_filter(mask, 2 * thickness + 1) & ~mask] = OUTLINE
    return shown


def _resized(picture: np.ndarray, sides: tuple[int, int], how: Image.Resampling) -> np.ndarray:
    """A picture, or a mask's probabilities, of other height and width."""
    if picture.shape[:2] == tuple(sides):
        return picture
    return np.asarray(Image.fromarray(picture).resize(sides[::-1], how))

"""What moved between two pictures: the outcome, and the masks of what moved."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image
from scipy.ndimage import maximum_filter

from ..data import data_file
from ..errors import ArgumentError
from ..storage.atomic import atomic_write
from ..storage.pictures import MAX_ELONGATION, read_photo
from .decision import MASK_THRESHOLD
from .outcome import Outcome
from .picture_depth import to_8_bit
from .predictor import MaskPredictor, PredictorError, check_same_size, load_predictor
from .tta import MIN_SIDE, SIDE_MULTIPLE

TRAINING_SIDE = 128
"""Pixels: height and width of the training pictures, and shorter side of what is predicted."""
OUTLINE = (213, 94, 0)  # vermilion, which colour-blind readers can tell apart
_DESCRIPTIONS: dict[Outcome, str] = {
    "identical": "identical: the same view, and nothing in it moved",
    "different": "different: another view",
    "moved": "moved: the same view, in which something moved",
}


class Change(NamedTuple):
    """What changed between two pictures.

    Attributes
    ----------
    outcome : {"identical", "different", "moved"}
        The same view in which nothing moved, another view, or the same view in which something
        moved.
    masks : bool (2, h, w)
        What moved, where it is in the first picture and in the second; empty unless the outcome is
        ``moved``.
    """

    outcome: Outcome
    masks: np.ndarray


def predict_change(
    before: np.ndarray | str | Path,
    after: np.ndarray | str | Path,
    predictor: str | Path | None = None,
) -> Change:
    """Predict what changed between two pictures of one camera.

    Parameters
    ----------
    before, after : uint8 (h, w, 3), or path
        RGB pictures of equal size, both sides at least 64 pixels. They are scaled to about the size
        of the training pictures.
    predictor : path, optional
        A file of :meth:`.MaskPredictor.save`; by default the predictor that belongs to the package.

    Raises
    ------
    ArgumentError
        If an array is no RGB picture.
    PredictorError
        If a file is not a picture, or if the pictures differ in size or are too small.
    """
    loaded = _load_predictor(Path(predictor) if predictor is not None else shipped_predictor())
    if isinstance(before, str | Path) and isinstance(after, str | Path):
        pictures = read_pictures(Path(before), Path(after))
    else:
        pictures = [_as_picture(*pair) for pair in (("before", before), ("after", after))]
    check_same_size(*pictures)
    prediction = loaded.predict(*(resize_to_training(picture) for picture in pictures))
    sides = pictures[0].shape[:2]
    masks = np.zeros((2, *sides), bool)
    if prediction.outcome == "moved":
        for mask, probabilities in zip(masks, prediction.probabilities, strict=True):
            mask[:] = _resize(probabilities, sides, Image.Resampling.BILINEAR) > MASK_THRESHOLD
    return Change(prediction.outcome, masks)


def predict_files(
    first: Path, second: Path, predictor: Path | None, out: Path, overwrite: bool = True
) -> str:
    """Predict what changed between two picture files.

    Parameters
    ----------
    first, second, predictor
        As for :func:`predict_change`.
    out : Path
        PNG file to write: both pictures side by side, with outlined masks. Never one of the inputs.
    overwrite : bool
        Whether `out` may exist.

    Returns
    -------
    str
        The outcome in words, with the number of pixels of each mask.

    Raises
    ------
    PredictorError
    """
    _check_output(out, (first, second, predictor), overwrite)
    pictures = before, after = read_pictures(first, second)
    change = predict_change(before, after, predictor)
    pixels = ""
    if change.outcome == "moved":
        n_first, n_second = change.masks.sum((1, 2))
        pixels = f" ({n_first} pixels in {first.name}, {n_second} in {second.name})"
    outlined = [draw_outline(*pair) for pair in zip(pictures, change.masks, strict=True)]
    with atomic_write(out) as temporary:
        Image.fromarray(np.concatenate(outlined, axis=1)).save(temporary, format="PNG")
    return f"{_DESCRIPTIONS[change.outcome]}{pixels}; see {out}"


def _check_output(out: Path, inputs: Sequence[Path | None], overwrite: bool) -> None:
    """Raise PredictorError if writing `out` would destroy an input, or another file unasked."""
    if not out.exists():
        return
    for path in inputs:
        if path is not None and path.exists() and out.samefile(path):
            raise PredictorError(f"{out}: is an input and would be overwritten; choose another out")
    if not overwrite:
        raise PredictorError(f"{out}: exists; choose another out, or overwrite it with --force")


def shipped_predictor() -> Path:
    """The predictor that belongs to the package: RAFT, trained at the paper's sizes."""
    return data_file("predictors", "raft.predictor")


@lru_cache(1)
def _load_predictor(path: Path) -> MaskPredictor:
    return load_predictor(path)


def _as_picture(name: str, picture: np.ndarray | str | Path) -> np.ndarray:
    if isinstance(picture, str | Path):
        return read_picture(Path(picture))
    if not isinstance(picture, np.ndarray) or picture.dtype != np.uint8 or (
        picture.ndim != 3 or picture.shape[2] != 3
    ):  # fmt: skip
        kind = f"{picture.dtype} {picture.shape}" if isinstance(picture, np.ndarray) else "other"
        raise ArgumentError(
            f"{name}: expected an RGB picture, uint8 (height, width, 3), or a path; got "
            f"{kind if kind != 'other' else type(picture).__name__}"
        )
    return picture


def read_picture(path: Path) -> np.ndarray:
    """Read a PNG, JPEG or TIFF file as RGB, upright by its EXIF tag: uint8 (h, w, 3).

    Raises
    ------
    PredictorError
        If the file is missing, too large, or of another format.
    """
    return to_8_bit([read_photo(path, PredictorError)], [str(path)])[0]


def read_pictures(first: Path, second: Path) -> list[np.ndarray]:
    """As :func:`read_picture`, for a pair: pictures of more than 8 bits are scaled alike."""
    photos = [read_photo(path, PredictorError) for path in (first, second)]
    return to_8_bit(photos, [str(first), str(second)])


def resize_to_training(picture: np.ndarray) -> np.ndarray:
    """Scale a picture, uint8 (h, w, 3), so that its shorter side has TRAINING_SIDE pixels.

    The longer side is rounded to SIDE_MULTIPLE, which stretches the picture by at most an eighth.
    Raises PredictorError if a side has less than MIN_SIDE pixels, or more than MAX_ELONGATION times
    those of the other.
    """
    height, width = picture.shape[:2]
    shorter, longer = sorted((height, width))
    if longer > MAX_ELONGATION * shorter:
        raise PredictorError(
            f"the pictures have {height} x {width} pixels; no side may be longer than "
            f"{MAX_ELONGATION} times the other: crop them"
        )
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

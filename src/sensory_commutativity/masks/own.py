"""What moved between two pictures of one's own: from picture files to an outcome, and to a picture for people."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError
from scipy.ndimage import binary_dilation

from ..tables import written_whole
from .decision import MASK
from .outcome import Outcome
from .predictor import PredictorError, load_predictor

SHIPPED = Path(__file__).resolve().parents[3] / "results" / "paper" / "models" / "masks" / "raft.predictor"
"""The RAFT of the run at the paper's sizes, which is committed."""
OUTLINE = (213, 94, 0)  # vermilion, which colour-blind readers can tell apart
_SAID: dict[Outcome, str] = {
    "identical": "identical: the same view, and nothing in it moved",
    "different": "different: another view",
    "moved": "moved: the same view but for what moved",
}


def predict_files(first: Path, second: Path, predictor: Path | None, out: Path) -> str:
    """The outcome of two picture files in words, with the pixels of each mask; `out` shows both, the masks outlined.

    Raises PredictorError for files that are no pictures, or of other sizes than a predictor takes.
    """
    if predictor is None and not SHIPPED.is_file():
        raise PredictorError(f"no predictor comes with this installation ({SHIPPED} is not there); give one with --predictor")
    loaded = load_predictor(predictor or SHIPPED)
    pictures = [read_picture(path) for path in (first, second)]
    found = loaded.predict(*pictures)
    masks = found.probabilities > MASK if found.outcome == "moved" else np.zeros(found.probabilities.shape, bool)
    with written_whole(out) as temporary:
        Image.fromarray(np.concatenate([outlined(*pair) for pair in zip(pictures, masks, strict=True)], axis=1)).save(temporary, format="PNG")
    sizes = f" ({masks[0].sum()} pixels in {first.name}, {masks[1].sum()} in {second.name})" if found.outcome == "moved" else ""
    return f"{_SAID[found.outcome]}{sizes}; see {out}"


def read_picture(path: Path) -> np.ndarray:
    """A picture file in red, green and blue: uint8 (h, w, 3). Raises PredictorError."""
    try:
        with Image.open(path) as picture:
            return np.asarray(picture.convert("RGB"))
    except FileNotFoundError:
        raise PredictorError(f"{path}: there is no such file; give two pictures") from None
    except (UnidentifiedImageError, OSError, ValueError) as error:
        raise PredictorError(f"{path}: cannot be read as a picture ({str(error)[:80]}); give a PNG or JPEG file") from None


def outlined(picture: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """The picture, uint8 (h, w, 3), with a line around the mask, bool (h, w)."""
    shown = picture.copy()
    shown[binary_dilation(mask) & ~mask] = OUTLINE
    return shown

"""Files of picture pairs with their masks and outcomes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..storage.arrays import REMEDY, ArrayFileError, pack_masks, read_arrays, unpack_masks
from .outcome import OUTCOMES

if TYPE_CHECKING:
    from .simulated.pairs import Pair  # imports PyBullet, which training does not need

CONTENT = "mask_pairs"
"""Content of the HDF5 files, as :func:`..storage.arrays.write_arrays` records it."""


class Pairs(NamedTuple):
    """A data set of n pairs.

    Attributes
    ----------
    pictures : uint8 (n, 2, h, w, 3)
        RGB.
    masks : bool (n, 2, h, w)
        Pixels that show something that moved.
    outcome : int8 (n,)
        Indices into OUTCOMES.
    kind : tuple of str
        How each pair was generated.
    scene : int32 (n,)
        Number of the cluttered scene that each pair shows.
    """

    pictures: np.ndarray
    masks: np.ndarray
    outcome: np.ndarray
    kind: tuple[str, ...]
    scene: np.ndarray


def pairs_to_arrays(
    pairs: Sequence[Pair], scenes: Sequence[int]
) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Convert pairs of one picture size to the arrays and texts of a file.

    Parameters
    ----------
    pairs : sequence of Pair
    scenes : sequence of int
        Number of the cluttered scene of each pair.

    Returns
    -------
    arrays, texts : dict
        What :func:`..storage.arrays.write_arrays` takes, for files that :func:`read_pairs` reads.
    """
    kinds = sorted({pair.kind for pair in pairs})
    arrays = dict(
        pictures=np.stack([pair.pictures for pair in pairs]),
        masks=pack_masks(np.stack([pair.masks for pair in pairs])),
        outcome=np.array([OUTCOMES.index(pair.outcome) for pair in pairs], np.int8),
        kind=np.array([kinds.index(pair.kind) for pair in pairs], np.int8),
        scene=np.array(scenes, np.int32),
    )
    return arrays, {"outcomes": json.dumps(OUTCOMES), "kinds": json.dumps(kinds)}


def read_pairs(*paths: Path) -> Pairs:
    """Read files of pairs as one data set.

    Raises ArrayFileError if a file is missing or damaged, or if the files differ in picture size.
    """
    parts = [_read_file(path) for path in paths]
    sizes = {part.pictures.shape[1:] for part in parts}
    if len(sizes) > 1:
        raise ArrayFileError(
            f"{paths[0]} and others: pictures of several sizes, {sorted(sizes)}; {REMEDY}"
        )
    return Pairs(
        pictures=np.concatenate([part.pictures for part in parts]),
        masks=np.concatenate([part.masks for part in parts]),
        outcome=np.concatenate([part.outcome for part in parts]),
        kind=tuple(kind for part in parts for kind in part.kind),
        scene=np.concatenate([part.scene for part in parts]),
    )


def _read_file(path: Path) -> Pairs:
    arrays, texts = read_arrays(path, CONTENT)
    kinds, pictures, masks = texts.json_list("kinds"), arrays["pictures"], arrays["masks"]
    outcome, kind, scene = arrays["outcome"], arrays["kind"], arrays["scene"]
    n = len(pictures)
    fits = (
        pictures.dtype == masks.dtype == np.uint8
        and pictures.ndim == 5
        and pictures.shape[1::3] == (2, 3)
        and masks.shape == (*pictures.shape[:3], -(-pictures.shape[3] // 8))
        and outcome.shape == kind.shape == scene.shape == (n,)
        and np.isin(outcome, range(len(OUTCOMES))).all()
        and np.isin(kind, range(len(kinds))).all()
    )
    if not fits:
        raise ArrayFileError(f"{path}: its arrays do not fit together; {REMEDY}")
    return Pairs(
        pictures=pictures,
        masks=unpack_masks(masks, pictures.shape[3]),
        outcome=outcome,
        kind=tuple(kinds[k] for k in kind),
        scene=scene,
    )

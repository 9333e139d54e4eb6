"""Files of image pairs with their masks and outcomes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..storage.arrays import REMEDY, StoreError, pack, read_arrays, unpack, write_arrays
from .outcome import OUTCOMES

if TYPE_CHECKING:
    from .simulated.pairs import Pair  # imports PyBullet, which training does not need


class Pairs(NamedTuple):
    """Many pairs.

    Attributes
    ----------
    pictures : uint8 (n, 2, h, w, 3)
    masks : bool (n, 2, h, w)
    outcome : int8 (n,)
        Indices into OUTCOMES.
    kind : tuple of str
        How each came about.
    """

    pictures: np.ndarray
    masks: np.ndarray
    outcome: np.ndarray
    kind: tuple[str, ...]


def write_pairs(path: Path, pairs: Sequence[Pair], about: Mapping[str, str]) -> None:
    """Write pairs, all of one size, and what they come from."""
    kinds = sorted({pair.kind for pair in pairs})
    arrays = dict(
        pictures=np.stack([pair.pictures for pair in pairs]),
        masks=pack(np.stack([pair.masks for pair in pairs])),
        outcome=np.array([OUTCOMES.index(pair.outcome) for pair in pairs], np.int8),
        kind=np.array([kinds.index(pair.kind) for pair in pairs], np.int8),
    )
    write_arrays(
        path,
        "pairs",
        arrays,
        {"outcomes": json.dumps(OUTCOMES), "kinds": json.dumps(kinds), **about},
    )


def read_pairs(*paths: Path) -> Pairs:
    """Read what :func:`write_pairs` wrote, all files as one. Raises StoreError."""
    parts = []
    for path in paths:
        arrays, about = read_arrays(path, "pairs")
        kinds = json.loads(about["kinds"])
        masks = unpack(arrays["masks"], arrays["pictures"].shape[3])
        parts.append(
            Pairs(
                arrays["pictures"],
                masks,
                arrays["outcome"],
                tuple(kinds[k] for k in arrays["kind"]),
            )
        )
    shapes = {part.pictures.shape[1:] for part in parts}
    if len(shapes) > 1:
        raise StoreError(
            f"{paths[0]} and others: pictures of several sizes, {sorted(shapes)}; {REMEDY}"
        )
    return Pairs(
        *(np.concatenate([part[k] for part in parts]) for k in range(3)),
        tuple(kind for part in parts for kind in part.kind),
    )

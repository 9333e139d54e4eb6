"""What SC-experiments find that their alternatives do not, on the same starts (paper, section IV-A, "Alternatives are not adapted")."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from ..config import Config
from ..masks.decision import MASK, outcomes
from ..masks.experiments import COMPARISONS, KINDS
from ..masks.outcome import OUTCOMES
from ..masks.predictor import load_predictor
from ..masks.store import read_arrays, unpack
from ..progress import progress
from ..statistics.paired import mcnemar
from ..statistics.proportions import wilson_interval
from ..tables import write_table
from .mask_comparisons import BETTER
from .mask_tuples import CONTENT

FOUND = 0.5
"""Intersection over union of both masks together from which an object counts as found; chosen: the usual one in object detection."""
DIFFERENT, MOVED = OUTCOMES.index("different"), OUTCOMES.index("moved")


def discoveries(outcome: np.ndarray, truth: np.ndarray, overlap: np.ndarray, touched: np.ndarray) -> pd.DataFrame:
    """A row per comparison.

    Parameters
    ----------
    outcome, truth : int (n, 3)
        Predicted and true outcomes of the COMPARISONS in n experiments, places in OUTCOMES.
    overlap : float (n, 3)
        Intersection over union of both masks together.
    touched : bool (n, 3)
        Whether something immovable was touched while it was played.
    """
    n = len(truth)
    found = (outcome == MOVED) & (truth == MOVED) & (overlap >= FOUND)
    rows = []
    for k, comparison in enumerate(COMPARISONS):
        low, high = wilson_interval(int(found[:, k].sum()), n)
        test = mcnemar(found[:, k], found[:, 0])
        row = dict(
            comparison=comparison,
            n=n,
            n_moved=int((truth[:, k] == MOVED).sum()),
            discovered=int(found[:, k].sum()),
            per_hundred=100 * found[:, k].mean(),
            ci_low=100 * float(low),
            ci_high=100 * float(high),
            false_alarms=int(((outcome[:, k] == MOVED) & (truth[:, k] != MOVED)).sum()),
            difference=100 * test.difference,
            p=test.p,
            n_touched=int(touched[:, k].sum()),
        )
        for name, chosen in (("hits", touched[:, k]), ("false_hits", ~touched[:, k])):
            said = outcome[chosen, k] == DIFFERENT
            ends = wilson_interval(int(said.sum()), len(said)) if len(said) else (np.nan, np.nan)
            row |= {name: said.mean() if len(said) else np.nan, f"{name}_low": float(ends[0]), f"{name}_high": float(ends[1])}
        rows.append(row)
    return pd.DataFrame(rows)


def write_discoveries(config: Config, predictor: Path, tuples: Sequence[Path], out: Path) -> None:
    """Of all experiments in the training apartment, as they come, through the camera that was trained with; each kind of sequence by itself."""
    loaded = load_predictor(predictor, BETTER)
    found: list[tuple[np.ndarray, ...]] = []
    for part in progress(tuples, "discoveries", "part"):
        arrays, _ = read_arrays(part, CONTENT)
        pictures, truth = arrays["pictures"][:, 0], arrays["outcome"][:, 0]
        masks = unpack(arrays["masks"][:, 0], pictures.shape[-2])
        probabilities = np.stack([loaded.probabilities(pictures[:, k]) for k in range(pictures.shape[1])], axis=1)
        predicted = probabilities > MASK
        overlap = (predicted & masks).sum((2, 3, 4)) / np.maximum(1, (predicted | masks).sum((2, 3, 4)))
        outcome = np.stack([outcomes(probabilities[:, k], loaded.rule) for k in range(pictures.shape[1])], axis=1)
        touched = np.stack([arrays["touched_fixed"], arrays["touched_fixed_first"], arrays["touched_fixed_first"]], axis=1)
        found.append((outcome, truth, overlap, touched, arrays["kind"]))
    outcome, truth, overlap, touched, kind = (np.concatenate([one[k] for one in found]) for k in range(5))
    tables = [
        discoveries(outcome[kind == k], truth[kind == k], overlap[kind == k], touched[kind == k]).assign(kind=name)
        for k, name in enumerate(KINDS)
        if (kind == k).any()
    ]
    write_table("mask_discoveries", pd.concat(tables, ignore_index=True), out, config)

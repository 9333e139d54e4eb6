"""What SC-experiments find that their alternatives do not, on the same starts (paper, section IV-A, "Alternatives are not adapted")."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from ..config import Config
from ..masks.experiments import COMPARISONS, KINDS
from ..statistics.paired import mcnemar
from ..statistics.proportions import wilson_interval
from ..tables import read_table, write_table

FOUND = 0.5
"""Intersection over union of both masks together from which an object counts as found; chosen: the usual one in object detection."""


def discoveries(alternatives: pd.DataFrame) -> pd.DataFrame:
    """Rows of the table mask_discoveries, one per comparison, of one kind of sequence; `alternatives`: that kind's rows of mask_alternatives."""
    rows, ours = [], None
    for comparison in COMPARISONS:
        table = alternatives[alternatives["comparison"] == comparison].sort_values("experiment")
        said, truth, touched = table["outcome_predicted"].to_numpy(), table["outcome_true"].to_numpy(), table["touched"].to_numpy()
        found = (said == "moved") & (truth == "moved") & (table["overlap"].to_numpy() >= FOUND)
        ours = found if ours is None else ours
        low, high = wilson_interval(int(found.sum()), len(found))
        test = mcnemar(found, ours)
        row = dict(
            comparison=comparison,
            n=len(found),
            n_moved=int((truth == "moved").sum()),
            discovered=int(found.sum()),
            per_hundred=100 * found.mean(),
            ci_low=100 * float(low),
            ci_high=100 * float(high),
            false_alarms=int(((said == "moved") & (truth != "moved")).sum()),
            difference=100 * test.difference,
            p=test.p,
            n_touched=int(touched.sum()),
        )
        for name, chosen in (("hits", touched), ("false_hits", ~touched)):
            different = said[chosen] == "different"
            ends = wilson_interval(int(different.sum()), len(different)) if len(different) else (np.nan, np.nan)
            row |= {
                name: different.mean() if len(different) else np.nan,
                f"{name}_low": float(ends[0]),
                f"{name}_high": float(ends[1]),
            }
        rows.append(row)
    return pd.DataFrame(rows)


def write_discoveries(mask_alternatives: Path, out: Path, config: Config) -> None:
    """Each kind of sequence by itself."""
    alternatives = read_table("mask_alternatives", mask_alternatives)
    of_kind = {kind: alternatives[alternatives["kind"] == kind] for kind in KINDS}
    tables = [discoveries(rows).assign(kind=kind) for kind, rows in of_kind.items() if len(rows)]
    write_table("mask_discoveries", pd.concat(tables, ignore_index=True), out, config)

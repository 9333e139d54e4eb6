"""What SC-experiments find that their alternatives do not, on the same starts (paper, section IV-A, "Alternatives are not adapted").

Experiments of a household share objects and places, so it is the unit of intervals and tests.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from ....change_detection.simulated.object_experiments import COMPARISONS, KINDS
from ....seeding import generator
from ....statistics.aggregates import percentile_interval
from ....statistics.paired import mcnemar
from ....storage.tables import read_table, write_table
from ...config import Config
from .mask_comparisons import by_household
from .mask_summary import resampled_households, resampled_mean

FOUND = 0.5
"""Intersection over union of both masks together from which an object counts as found; chosen: the usual one in object detection."""


def discoveries(alternatives: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Rows of the table mask_discoveries, one per comparison, of one kind of sequence; `alternatives`: that kind's rows of mask_alternatives."""
    tables = {
        name: rows.set_index("experiment").sort_index()
        for name, rows in alternatives.groupby("comparison")
    }
    found = {name: _found(table) for name, table in tables.items()}
    different = {
        name: (table["outcome_predicted"] == "different").to_numpy()
        for name, table in tables.items()
    }
    ours = COMPARISONS[0]
    touched, untouched = (
        tables[ours]["touched_first"].to_numpy(),
        ~tables[ours]["touched"].to_numpy(),
    )
    household = tables[ours]["household"]
    households, counts = resampled_households(household, rng)

    def rate(values: np.ndarray) -> tuple[float, float, float]:
        """Mean of `values` (n,), NaN left out, with its interval: bootstrap over households."""
        if not np.isfinite(values).any():
            return np.nan, np.nan, np.nan
        with np.errstate(invalid="ignore", divide="ignore"):
            means = resampled_mean(values, households, counts)
        return float(np.nanmean(values)), *percentile_interval(means[np.isfinite(means)], 0.95)

    rows = []
    for comparison in COMPARISONS:
        table = tables[comparison]
        said, truth = table["outcome_predicted"], table["outcome_true"]
        per_hundred, low, high = rate(100.0 * found[comparison])
        hits, hits_low, hits_high = rate(np.where(touched, different[comparison], np.nan))
        false_hits, false_low, false_high = rate(np.where(untouched, different[comparison], np.nan))
        _, difference, *_, p = by_household(
            100.0 * found[comparison] - 100.0 * found[ours], household
        )
        hits_difference, hits_p = np.nan, np.nan
        if touched.any():
            _, hits_difference, *_, hits_p = by_household(
                (different[comparison] - 1.0 * different[ours])[touched], household[touched]
            )
        rows.append(
            dict(
                comparison=comparison,
                n=len(table),
                n_moved=int((truth == "moved").sum()),
                discovered=int(found[comparison].sum()),
                per_hundred=per_hundred,
                ci_low=low,
                ci_high=high,
                false_alarms=int(((said == "moved") & (truth != "moved")).sum()),
                difference=difference,
                p=p,
                p_experiments=mcnemar(found[comparison], found[ours]).p,
                n_touched=int(touched.sum()),
                hits=hits,
                hits_low=hits_low,
                hits_high=hits_high,
                hits_difference=hits_difference,
                hits_p=hits_p,
                n_untouched=int(untouched.sum()),
                false_hits=false_hits,
                false_hits_low=false_low,
                false_hits_high=false_high,
            )
        )
    return pd.DataFrame(rows)


def _found(table: pd.DataFrame) -> np.ndarray:
    """In which experiments a moved object is found, and where: bool (n,)."""
    return (
        (table["outcome_predicted"] == "moved")
        & (table["outcome_true"] == "moved")
        & (table["overlap"] >= FOUND)
    ).to_numpy()


def write_discoveries(mask_alternatives: Path, out: Path, config: Config) -> None:
    """Each kind of sequence by itself."""
    alternatives = read_table("mask_alternatives", mask_alternatives)
    tables = []
    for kind in KINDS:
        rows = alternatives[alternatives["kind"] == kind]
        if len(rows):
            tables.append(
                discoveries(rows, generator(config.seed, "masks", "discoveries", kind)).assign(
                    kind=kind
                )
            )
    write_table("mask_discoveries", pd.concat(tables, ignore_index=True), out, config)

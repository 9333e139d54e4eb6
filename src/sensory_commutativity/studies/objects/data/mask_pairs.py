"""Pairs of pictures to learn from, a file per job (paper, section IV-A, "Dataset", and appendix D)."""

from __future__ import annotations

from pathlib import Path

from ....change_detection.outcome import OUTCOMES
from ....change_detection.pair_files import write_pairs
from ....change_detection.simulated.pairs import PairFactory
from ....progress import progress
from ....storage.provenance import provenance
from ...config import Config
from ..builders import Split, household_of_pairs, pairs_of_job


def write_mask_pairs(config: Config, split: Split, job: int, out: Path) -> None:
    """A job's pairs, in turn of each outcome."""
    factory, n = (
        PairFactory(household_of_pairs(config, split, job)),
        pairs_of_job(config, split, job),
    )
    pairs = [
        factory.pair(outcome)
        for _ in progress(range(n), out.stem, "triple")
        for outcome in OUTCOMES
    ]
    write_pairs(out, pairs, provenance(config))

"""Pairs of pictures to learn from, a file per job (paper, section IV-A, "Dataset", and appendix D)."""

from __future__ import annotations

from pathlib import Path

from ..config import Config
from ..masks.from_config import Split, household_of_pairs
from ..masks.outcome import OUTCOMES
from ..masks.pairs import PairFactory
from ..masks.store import write_pairs
from ..progress import progress
from ..provenance import provenance


def write_mask_pairs(config: Config, split: Split, job: int, out: Path) -> None:
    """A job's pairs, in turn of each outcome."""
    data = config.masks.data
    wanted = data.pairs if split == "training" else data.validation_pairs
    n = min(data.pairs_per_job, wanted - job * data.pairs_per_job)
    household = household_of_pairs(config, split, job)
    factory = PairFactory(household)
    pairs = [factory.pair(outcome) for _ in progress(range(n), out.stem, "triple") for outcome in OUTCOMES]
    write_pairs(out, pairs, provenance(config))

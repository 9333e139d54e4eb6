"""Made-up SC-experiments with given SCPs."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from sensory_commutativity.studies.apartment.tables.apartment_experiments import (
    apartment_experiments,
)
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import merge, validate

N = 40
"""Experiments of every run."""
FETCH = {
    "right-wheel": 0.2, "left-wheel": 0.2, "torso-lift": 1.0, "shoulder-pan": 0.5,
    "shoulder-lift": 0.5, "upperarm-roll": 0.7, "elbow-flex": 0.75, "forearm-roll": 0.9,
    "wrist-flex": 0.9, "wrist-roll": 0.95,
}  # fmt: skip
"""SCPs of Fetch, as in the paper."""


def overlay(config: Config, **sections) -> Config:
    return validate(merge(config.model_dump(mode="json"), sections))


def with_experiments(config: Config, n: int, **apartment) -> Config:
    """The configuration with `n` experiments in every run of the apartment."""
    sections = ("reference", "robots_compared", "scenes_compared", "within_reach", "free_space",
                "sensitivity")  # fmt: skip
    counts = {section: {"experiments": n} for section in sections}
    return overlay(config, apartment=merge(counts, apartment))


def make_experiments(config: Config, scp: Mapping[str, Mapping[str, float]]) -> pd.DataFrame:
    """A table apartment_experiments.

    Experiments that commute have distance 5, the others 900. In free space all commute.

    Parameters
    ----------
    scp : mapping
        Robot -> degree of freedom -> fraction of experiments that commute.
    """
    rows = []
    for run in config.apartment.runs():
        for d, (dof, value) in enumerate(scp[run.robot].items()):
            for i in range(N):
                commutes = run.scene == "free-space" or (i * 7 + d) % N < round(value * N)
                touched, distance = (0, 5.0) if commutes else (3, 900.0)
                for view in config.apartment.views(run):
                    rows.append((*run[:4], dof, i, 1, view, touched, 0, 0, 0, 0.0, 0.0, 0.0, 0.0,
                                 0.1, distance))  # fmt: skip
    return pd.DataFrame(rows, columns=apartment_experiments.column_names)

"""The tables in results/paper, which are part of the repository, are what this code computes."""

from __future__ import annotations

import pandas as pd
import pytest

from sensory_commutativity.storage.tables import read_table
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.flatland.builders import experiment_runs
from sensory_commutativity.studies.flatland.naive_change import squared_change
from sensory_commutativity.studies.flatland.tables.flatland_experiments import flatland_experiments
from sensory_commutativity.studies.flatland.transitions import collect_transitions
from sensory_commutativity.studies.loading import load
from sensory_commutativity.studies.registry import find_table
from tests.helpers import DEFAULT, ROOT, update_flatland

TABLES = ROOT / "results" / "paper" / "tables"


@pytest.fixture(scope="module")
def paper_config() -> Config:
    return load(DEFAULT, ROOT / "config" / "paper.yaml")


def read_shipped(name: str) -> pd.DataFrame:
    columns = find_table(name).columns  # written before tables had hashes
    return read_table(TABLES / f"{name}.parquet", name, columns, require_hash=False)


def test_the_first_experiments_of_every_run_in_flatland_are_repeated(paper_config):
    shipped = read_shipped("flatland_experiments")
    first = shipped[shipped["experiment"] < 3]
    for name, run in experiment_runs(paper_config).items():
        rows = (first[["world", "agent", "length"]] == list(run[:3])).all(axis=1)
        expected = first[rows].reset_index(drop=True)
        played = flatland_experiments(paper_config, name).compute(0, 3)
        pd.testing.assert_frame_equal(played, expected, obj=name)


def test_the_naive_change_of_few_transitions_is_near_that_of_many(paper_config):
    """The paper's 100,000 transitions take minutes; these are the first thousand of them."""
    shipped = read_shipped("flatland_baselines").set_index("dof")
    few = update_flatland(paper_config, baselines={"transitions": 1000, "training": 500})
    for dof in ("head", "left-elbow"):
        change = squared_change(collect_transitions(few, dof))
        error = change.std(ddof=1) / len(change) ** 0.5
        assert abs(change.mean() - shipped.loc[dof, "naive_mse"]) < 4 * error


LATER = {
    "mask_summary": ["mask_iou", "mask_iou_low", "mask_iou_high", "iou_with_empty"],
    "flatland_comparisons": ["ci_low", "ci_high"],
    "paper_comparison": ["holds", "our_value", "ci_low", "ci_high", "rule", "limits", "verdict"],
}
"""Columns that the shipped run has by the rules of an earlier version."""


def test_derived_tables_follow_from_the_tables_that_they_are_computed_from(paper_config):
    """All that take at most a few seconds."""
    for name in (
        "flatland_scp", "flatland_sensitivity", "flatland_comparisons", "flatland_trends",
        "apartment_scp", "apartment_interaction", "mask_dof", "mask_summary", "mask_comparisons",
        "mask_discoveries", "navigation_scores", "navigation_summary", "paper_comparison",
    ):  # fmt: skip
        table = find_table(name)
        names = table.input_names(paper_config)
        inputs = [read_or_compute(source, paper_config) for source in names]
        computed = table(*inputs, paper_config)[table.column_names].reset_index(drop=True)
        computed, shipped = (  # what an earlier version had is the same
            frame.drop(columns=LATER.get(name, [])) for frame in (computed, read_shipped(name))
        )
        pd.testing.assert_frame_equal(computed, shipped, rtol=1e-9, obj=name)


def read_or_compute(name: str, config: Config) -> pd.DataFrame:
    """A shipped table, or one that was declared since the run."""
    if (TABLES / f"{name}.parquet").is_file():
        return read_shipped(name)
    table = find_table(name)
    return table(*map(read_shipped, table.input_names(config)), config)

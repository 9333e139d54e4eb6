"""How well imagined orders rank the actions of an environment, and find what does not commute."""

from __future__ import annotations

import pandas as pd

from ....storage.columns import FLOAT, INT, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import imagined_runs
from .reset_free_imagined import reset_free_imagined
from .reset_free_imagined_experiments import ENVIRONMENT


def _expected(config: Config) -> Expected:
    runs = imagined_runs(config)
    return Expected(("environment",) if runs else (), {(name,): 1 for name in runs})


@table(
    title="Agreement of imagined orders with the truth",
    columns=(
        ENVIRONMENT,
        Column("actions", INT, "1", "degrees of freedom"),
        Column("n", INT, "1", "experiments of each"),
        Column("error", FLOAT, "1", "median error of the model at the end of an order"),
        Column("unchanged", FLOAT, "1", "median error of predicting no change"),
        Column(
            "spearman", FLOAT, "1", "of the true SCPs and the calibrated ones",
            nullable=True,
        ),
        Column(
            "spearman_imagined", FLOAT, "1",
            "of the true SCPs and those with both orders imagined", nullable=True,
        ),
        Column(
            "spearman_distance", FLOAT, "1",
            "of the mean true distances and the mean imagined distances", nullable=True,
        ),
        Column("events", INT, "1", "experiments that did not commute, of all actions"),
        Column("auc", FLOAT, "1", "area under the ROC curve of the imagined distance",
               nullable=True),
        Column("auc_touched", FLOAT, "1", "the same, of actions that touch something",
               nullable=True),
    ),
    inputs=["reset_free_imagined_experiments"],
    settings=lambda config: [[run.threshold, run.quantile] for run in
                             imagined_runs(config).values()],
    expected=_expected,
)  # fmt: skip
def reset_free_imagined_agreement(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """A row per environment."""
    from ....statistics.clusters import area_under_roc_curve

    per_action, rows = reset_free_imagined(experiments, config), []
    for name, group in experiments.groupby("environment", sort=False):
        actions = per_action[per_action["environment"] == name]
        events = (group["true"] > imagined_runs(config)[str(name)].threshold).to_numpy()
        touches = group["dof"].isin(actions.loc[actions["touched"] > 0, "dof"]).to_numpy()
        scores = group["imagined"].to_numpy()
        rows.append(
            (name, len(actions), int(actions["n"].iloc[0]), group["error"].median(),
             group["unchanged"].median(), _spearman(actions["true_scp"], actions["scp"]),
             _spearman(actions["true_scp"], actions["scp_imagined"]),
             _spearman(actions["mean_true"], actions["mean_imagined"]), int(events.sum()),
             area_under_roc_curve(scores, events),
             area_under_roc_curve(scores[touches], events[touches]))
        )  # fmt: skip
    return pd.DataFrame(rows, columns=reset_free_imagined_agreement.column_names)


def _spearman(x: pd.Series, y: pd.Series) -> float:
    from scipy.stats import spearmanr

    if x.nunique() < 2 or y.nunique() < 2:
        return float("nan")
    return float(spearmanr(x, y).statistic)

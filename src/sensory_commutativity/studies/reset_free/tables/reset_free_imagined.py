"""The SCP with an imagined order, beside the true one, for every action of an environment."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ....storage.columns import FLOAT, INT, INTERVAL, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import imagined_runs
from ..columns import DOF
from .reset_free_imagined_experiments import ENVIRONMENT


def _expected(config: Config) -> Expected:
    runs = imagined_runs(config)
    return Expected(("environment",) if runs else (), {(name,): None for name in runs})


@table(
    title="SCP with an imagined order",
    columns=(
        ENVIRONMENT,
        DOF,
        Column("n", INT, "1", "experiments"),
        Column("touched", FLOAT, "1", "share in which bodies touched", nullable=True),
        Column("true_scp", FLOAT, "1", "SCP of the orders that were played"),
        Column("scp_imagined", FLOAT, "1", "SCP with both orders imagined, at the same threshold"),
        Column(
            "scp", FLOAT, "1", "SCP with the second order imagined, at the calibrated threshold"
        ),
        *INTERVAL,
        Column("threshold", FLOAT, "1", "a quantile of the model's error on the first order"),
        Column("mean_true", FLOAT, "1", "mean distance of the orders that were played"),
        Column("mean_imagined", FLOAT, "1", "mean distance of the imagined orders"),
        Column("events", INT, "1", "experiments that did not commute"),
        Column(
            "auc", FLOAT, "1", "area under the ROC curve of the imagined distance for such events",
            nullable=True,
        ),
        Column("auc_score", FLOAT, "1", "the same, of the distance of played and imagined",
               nullable=True),
    ),
    inputs=["reset_free_imagined_experiments"],
    settings=lambda config: [[run.threshold, run.quantile] for run in
                             imagined_runs(config).values()],
    expected=_expected,
)  # fmt: skip
def reset_free_imagined(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Of every action of every environment."""
    from ....statistics.clusters import area_under_roc_curve
    from ....statistics.proportions import wilson_interval

    rows = []
    for (name, dof), group in experiments.groupby(["environment", "dof"], sort=False):
        settings = imagined_runs(config)[str(name)]
        threshold = float(np.quantile(group["error"], settings.quantile))
        both_imagined = float((group["imagined"] <= settings.threshold).mean())
        commuted = (group["score"] <= threshold).to_numpy()
        events = (group["true"] > settings.threshold).to_numpy()
        low, high = wilson_interval(int(commuted.sum()), len(commuted))
        rows.append(
            (name, dof, len(group), float(group["touched"].mean()), float(1 - events.mean()),
             both_imagined,
             float(commuted.mean()), float(low), float(high), threshold, group["true"].mean(),
             group["imagined"].mean(), int(events.sum()),
             area_under_roc_curve(group["imagined"].to_numpy(), events),
             area_under_roc_curve(group["score"].to_numpy(), events))
        )  # fmt: skip
    return pd.DataFrame(rows, columns=reset_free_imagined.column_names)

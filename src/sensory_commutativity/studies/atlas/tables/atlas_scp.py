"""The SCP of every action of every environment, with what the controls say about it."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ....measurement.report import add_report
from ....scp.estimate import estimate_scp
from ....storage.columns import FLOAT, INT, INTERVAL, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import atlas, environments
from ..columns import ACTION, ENVIRONMENT, ID


def _expected(config: Config) -> Expected:
    return Expected(("environment",), {(name,): None for name in environments(config)})


def _share(name: str, text: str) -> Column:
    return Column(name, FLOAT, "1", text, nullable=True)


@table(
    title="SCP of standard environments",
    columns=(
        ENVIRONMENT,
        ID,
        ACTION,
        Column("control", TEXT, "", "how actions became commands"),
        Column("way", TEXT, "", "how the state was restored"),
        Column("threshold", FLOAT, "1", "largest distance that counts as equal", key=True, low=0),
        Column("n", INT, "1", "start situations"),
        Column("commuted", INT, "1", "starts from which both orders ended equal"),
        Column("scp", FLOAT, "1", "commuted / n", low=0, high=1),
        *INTERVAL,
        _share("scp_untouched", "SCP of the experiments that touched nothing"),
        _share("untouched_low", "lower end of its 95 % interval"),
        _share("untouched_high", "upper end of its 95 % interval"),
        Column("n_untouched", INT, "1", "experiments that touched nothing"),
        _share("touched", "share of experiments that touched something"),
        _share("moved", "share of experiments in which an object ended elsewhere"),
        _share("area", "area under P(distance <= t) over log t, from 1e-4 to 1"),
        _share("order_over_actions", "median distance of two orders over that of two sequences"),
        _share("noise_over_order", "median distance of one order under other noise, over that"),
        _share("amplitude", "mean largest action of the sequences, scaled to stay off the stops"),
        _share("rest_steps", "mean steps of rest"),
        _share("not_still", "share of orders that did not come to rest"),
        _share("terminated", "share of experiments in which the episode terminated"),
        _share("reaches_stop", "share of sequences of which an order could reach a stop"),
        _share("repeated", "share of starts whose first order, repeated, ended equal"),
        Column("verdict", TEXT, "", "what the row shows, or why it shows nothing"),
    ),
    inputs=["atlas_experiments"],
    settings=lambda config: atlas(config).thresholds,
    expected=_expected,
)
def atlas_scp(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """The SCP at every threshold."""
    tables = []
    for name, rows in experiments.groupby("environment", sort=False):
        rows = rows.sort_values("experiment", kind="stable")
        actions = list(dict.fromkeys(rows["action"]))
        shape = len(rows) // len(actions), len(actions)
        columns = rows.columns[rows.columns.get_loc("way") + 1 :]
        arrays = {column: rows[column].to_numpy(float).reshape(shape) for column in columns}
        scp = estimate_scp(rows, ["action"], atlas(config).thresholds)
        distances = arrays.pop("distance")
        report = add_report(scp.rename(columns={"action": "dof"}), distances, arrays, actions)
        report = report.rename(columns={"dof": "action"})
        report.insert(0, "environment", name)
        report["id"] = environments(config)[str(name)].env_id
        report["control"], report["way"] = rows["control"].iloc[0], rows["way"].iloc[0]
        moved = rows.groupby("action", sort=False)["moved"].mean()
        report["moved"] = moved.reindex(report["action"]).to_numpy()
        tables.append(report)
    table = pd.concat(tables, ignore_index=True)
    return table.assign(n_untouched=table["n_untouched"].astype(np.int64))

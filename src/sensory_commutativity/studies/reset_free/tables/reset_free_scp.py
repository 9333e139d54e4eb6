"""The SCP of every degree of freedom by the return protocol, beside the true one."""

from __future__ import annotations

import pandas as pd

from ....storage.columns import FLOAT, INT, INTERVAL, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import apartment_runs, reset_free, trial_runs
from ..columns import DOF, WORLD
from ..estimates import PROTOCOLS, estimate_protocols

PROTOCOL = Column(
    "protocol", TEXT, "",
    "reset: each order from a restored start, the truth; return: with a return between the orders; "
    "control: the same order twice, with a return; start-seen-again: the start before and after; "
    "return-quiet: where nothing was seen to move beforehand",
    key=True,
)  # fmt: skip


@table(
    title="SCP without a reset",
    columns=(
        WORLD,
        DOF,
        PROTOCOL,
        Column(
            "threshold", FLOAT, "1",
            "largest distance that counts as equal, squared 8-bit colour or VGG16 feature",
            key=True,
        ),
        Column("n", INT, "1", "trials"),
        Column("scp", FLOAT, "1", "share of trials whose views are equal"),
        *INTERVAL,
        Column("relative", FLOAT, "1", "SCP over that of the control", nullable=True),
        Column("relative_low", FLOAT, "1", "lower end of its 95 % interval", nullable=True),
        Column("relative_high", FLOAT, "1", "upper end of its 95 % interval", nullable=True),
    ),
    inputs=["reset_free_trials", "reset_free_apartment"],
    settings=lambda config: [reset_free(config).thresholds, config.apartment.thresholds],
    expected=lambda config: Expected(
        ("world",), {(name,): None for name in [*trial_runs(config), *apartment_runs(config)]}
    ),
)  # fmt: skip
def reset_free_scp(trials: pd.DataFrame, apartment: pd.DataFrame, config: Config) -> pd.DataFrame:
    """All protocols at all thresholds."""
    parts = [estimate_protocols(trials, reset_free(config).thresholds)]
    if len(apartment):
        parts.append(estimate_protocols(apartment, config.apartment.thresholds))
    table = pd.concat(parts, ignore_index=True)
    assert set(PROTOCOLS) <= set(table["protocol"])
    return table

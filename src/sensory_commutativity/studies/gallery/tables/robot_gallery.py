"""The SCP of every degree of freedom of every robot of the gallery, and what may spoil it."""

from __future__ import annotations

import pandas as pd

from ....scp.estimate import estimate_scp
from ....storage.columns import FLOAT, INT, INTERVAL, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import gallery, runs
from ..columns import DOF, GROUP, ROBOT, SCENE

KEYS = ["robot", "scene", "dof"]


def _expected(config: Config) -> Expected:
    return Expected(("robot", "scene"), dict.fromkeys(runs(config).values()))


@table(
    title="SCP of the gallery of robots",
    columns=(
        ROBOT,
        SCENE,
        DOF,
        GROUP,
        Column("threshold", FLOAT, "1", "largest distance that counts as equal", key=True),
        Column("n", INT, "1", "start situations"),
        Column("commuted", INT, "1", "starts from which both orders ended equal"),
        Column("scp", FLOAT, "1", "commuted / n"),
        *INTERVAL,
        Column("at_stop", FLOAT, "1", "share of experiments in which a joint's limit stopped it"),
        Column("self_contact", FLOAT, "1", "share of experiments that touched the robot itself"),
        Column("touched", FLOAT, "1", "share of experiments that touched the scene"),
    ),
    inputs=["gallery_experiments"],
    settings=lambda config: gallery(config).thresholds,
    expected=_expected,
)
def robot_gallery(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """The SCP at every threshold."""
    scp = estimate_scp(experiments, KEYS, gallery(config).thresholds)
    events = {"at_stop": "at_limit", "self_contact": "touched_self", "touched": "touched"}
    shares = experiments.assign(
        **{name: (experiments[column] > 0).astype(float) for name, column in events.items()}
    )
    shares = shares.groupby(KEYS, sort=False)[list(events)].mean().reset_index()
    groups = experiments[[*KEYS, "group"]].drop_duplicates()
    return scp.merge(groups, on=KEYS).merge(shares, on=KEYS)

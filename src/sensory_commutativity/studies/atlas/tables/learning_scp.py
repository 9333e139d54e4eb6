"""SCP of the planar arm, from which the action spaces of the comparison are made."""

from __future__ import annotations

import pandas as pd

from ....seeding import seed_for
from ....storage.columns import FLOAT, INT, INTERVAL, Column
from ...config import Config
from ...declarations import table
from ..builders import atlas
from ..columns import DOF


@table(
    title="SCP of the planar arm",
    columns=(
        DOF,
        Column("threshold", FLOAT, "1", "largest distance that counts as equal", key=True),
        Column("n", INT, "1", "start situations"),
        Column("commuted", INT, "1", "starts from which both orders ended equal"),
        Column("scp", FLOAT, "1", "commuted / n"),
        *INTERVAL,
        Column("scp_untouched", FLOAT, "1", "SCP of the experiments that touched nothing"),
        Column("touched", FLOAT, "1", "share of experiments that touched something"),
    ),
    settings=lambda config: atlas(config).learning,
)
def learning_scp(config: Config) -> pd.DataFrame:
    """Measure it, from starts after random actions."""
    import gymnasium

    from ....adapters.gymnasium import from_gymnasium
    from ....measurement.measure import measure
    from ....worlds.planar_arm import ENVIRONMENT_ID

    settings = atlas(config).learning
    env = gymnasium.make(ENVIRONMENT_ID)
    # Its targets stay where they are between actions, so that actions are velocities already.
    world = from_gymnasium(env, control="direct", prefix=20, hold=1)
    measured = measure(
        world, settings.starts, settings.length, thresholds=settings.threshold,
        seed=seed_for(config.seed, "learning scp"), progress=False,
    )  # fmt: skip
    return measured.table[learning_scp.column_names]

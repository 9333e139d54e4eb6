"""How much did each degree of freedom truly touch the world? What the simulator knows and the robot's eye does not, beside the SCP."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ....scp.estimate import commutes
from ....statistics.proportions import wilson_interval
from ....storage.tables import read_table, write_table
from ...config import Config
from .apartment_scp import CONDITION

MOVED = 0.01
"""Metres from which an object counts as moved; chosen: a few pixels at arm's length."""


def interactions(experiments: pd.DataFrame, threshold: float, field_of_view: float) -> pd.DataFrame:
    """A row per condition and degree of freedom; `experiments` is an apartment_experiments table."""
    frame = experiments[experiments["field_of_view"] == field_of_view]
    rows = []
    keys = [key for key in CONDITION if key != "field_of_view"]
    for group, found in frame.groupby([*keys, "dof"], sort=False):
        commuted = commutes(found["distance"].to_numpy(), threshold)
        touched = ((found["touched_fixed"] > 0) | (found["touched_movable"] > 0)).to_numpy()
        hindered = ((found["touched_self"] > 0) | (found["at_limit"] > 0)).to_numpy() & ~touched
        free = ~touched & ~hindered
        low, high = wilson_interval(int(touched.sum()), len(found))
        rows.append(
            dict(
                zip([*keys, "dof"], group, strict=True),
                n=len(found),
                scp=commuted.mean(),
                touched=touched.mean(),
                ci_low=float(low),
                ci_high=float(high),
                touched_fixed=(found["touched_fixed"] > 0).mean(),
                touched_movable=(found["touched_movable"] > 0).mean(),
                moved_object=(found["object_shift"] > MOVED).mean(),
                hindered=hindered.mean(),
                n_touched=int(touched.sum()),
                commuted_touched=int(commuted[touched].sum()),
                n_hindered=int(hindered.sum()),
                commuted_hindered=int(commuted[hindered].sum()),
                n_free=int(free.sum()),
                commuted_free=int(commuted[free].sum()),
            )
        )
    return pd.DataFrame(rows)


def write_interaction(experiments: Path, out: Path, config: Config) -> None:
    """At the reference threshold and the main field of view."""
    settings = config.apartment
    frame = read_table("apartment_experiments", experiments)
    write_table(
        "apartment_interaction",
        interactions(frame, settings.reference.threshold, settings.fields_of_view[0]),
        out,
        config,
    )

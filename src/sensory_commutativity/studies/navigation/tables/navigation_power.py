"""Which differences would so many runs find?"""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ....statistics.groups import welch
from ....statistics.power import detectable_effect, power_of_t_test, runs_needed
from ....storage.tables import write_table
from ...config import Config
from .navigation_comparisons import pairs
from .navigation_scores import read_scores

EFFECTS = (0.5, 0.8, 1.0, 1.2)
POWER = 0.8
QUESTIONS = POWER_AT, DETECTABLE, NEEDED = (
    "power",
    "smallest effect found with power .8",
    "runs needed for the observed effect (planning, not evidence)",
)


def write_power(scores: Path, out: Path, config: Config) -> None:
    """Power of Welch's test at this number of runs, the smallest effect it would find, and the runs that the observed effects would need."""
    table = read_scores(scores, config)
    n, level = len(config.navigation.seeds), config.navigation.alpha
    rows = []
    for alpha in (level, level / 3):
        rows += [(POWER_AT, "", "", alpha, n, d, power_of_t_test(d, n, alpha)) for d in EFFECTS]
        rows.append((DETECTABLE, "", "", alpha, n, detectable_effect(n, alpha, POWER), POWER))
    for family, a, b in pairs(config):
        if family == "paper":
            values = [
                table.loc[
                    table["action_space"] == name, config.navigation.primary_measure
                ].to_numpy()
                for name in (a, b)
            ]
            g = welch(*values).effect_size
            rows.append((NEEDED, a, b, level / 3, runs_needed(abs(g), level / 3, POWER), g, POWER))
    frame = pd.DataFrame(rows, columns=["question", "a", "b", "alpha", "n", "effect_size", "power"])
    write_table("navigation_power", frame, out, config)

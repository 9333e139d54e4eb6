"""Which differences this number of runs can detect."""

from __future__ import annotations

import pandas as pd

from ....storage.columns import FLOAT, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from .navigation_comparisons import pairs

EFFECTS = (0.5, 0.8, 1.0, 1.2)
"""Effect sizes whose power is computed. Chosen: medium (0.5) to very large (1.2) ones."""
POWER = 0.8
"""Power that is asked for. Chosen: the usual one."""
POWER_AT = "power"
DETECTABLE = "smallest effect found with power .8"
NEEDED = "runs needed for the observed effect (planning, not evidence)"


def _settings(config: Config) -> object:
    navigation = config.navigation
    return [navigation.action_spaces, navigation.seeds, navigation.alpha,
            navigation.primary_measure]  # fmt: skip


def _paper_pairs(config: Config) -> list[tuple[str, str]]:
    return [(a, b) for family, a, b in pairs(config) if family == "paper"]


def _expected(config: Config) -> Expected:
    rows = {POWER_AT: 2 * len(EFFECTS), DETECTABLE: 2, NEEDED: len(_paper_pairs(config))}
    return Expected(("question",), {(question,): n for question, n in rows.items()})


@table(
    title="Power of the comparisons",
    columns=(
        Column("question", TEXT, "", "what is computed", key=True),
        Column("a", TEXT, "", "action space, for an observed effect", key=True),
        Column("b", TEXT, "", "action space that a is compared with", key=True),
        Column(
            "alpha", FLOAT, "1", "significance level: family-wise, and divided by three pairs",
            key=True, low=0, high=1,
        ),
        Column("n", FLOAT, "1", "runs of each action space"),
        Column("effect_size", FLOAT, "1", "standardised difference of means", key=True),
        Column("power", FLOAT, "1", "probability to detect it", low=0, high=1),
    ),
    inputs=["navigation_scores"],
    settings=_settings,
    expected=_expected,
)  # fmt: skip
def navigation_power(scores: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Power of Welch's test at this number of runs, the smallest effect that it detects, and the
    runs that the observed effects would need."""
    from ....statistics.groups import welch
    from ....statistics.power import detectable_effect, power_of_t_test, runs_needed

    n, level = len(config.navigation.seeds), config.navigation.alpha
    rows: list[tuple[str, str, str, float, float, float, float]] = []
    for alpha in (level, level / 3):
        rows += [(POWER_AT, "", "", alpha, n, d, power_of_t_test(d, n, alpha)) for d in EFFECTS]
        rows.append((DETECTABLE, "", "", alpha, n, detectable_effect(n, alpha, POWER), POWER))
    measure = config.navigation.primary_measure
    values = {name: runs[measure].to_numpy() for name, runs in scores.groupby("action_space")}
    for a, b in _paper_pairs(config):
        g = welch(values[a], values[b]).effect_size
        rows.append((NEEDED, a, b, level / 3, runs_needed(abs(g), level / 3, POWER), g, POWER))
    return pd.DataFrame(rows, columns=navigation_power.column_names)

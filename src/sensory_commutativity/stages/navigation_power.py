"""How far can the tests be trusted? Power before the runs, and A/A tests after them."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ..config import Config
from ..seeding import generator
from ..statistics.calibration import binomial_band, split_rejections
from ..statistics.groups import welch
from ..statistics.power import detectable_effect, power_of_t_test, runs_needed
from ..tables import read_table, write_table
from .navigation_comparisons import ALPHA, pairs
from .navigation_scores import MEASURES

EFFECTS = (0.5, 0.8, 1.0, 1.2)
POWER = 0.8
QUESTIONS = POWER_AT, DETECTABLE, NEEDED = (
    "power",
    "smallest effect found with power .8",
    "runs needed for the observed effect (planning, not evidence)",
)
TOGETHER = "all"


def write_power(scores: Path, out: Path, config: Config) -> None:
    """Power of Welch's test at this number of runs, the smallest effect it would find, and the runs that the observed effects would need."""
    table = read_table("navigation_scores", scores)
    n = len(config.navigation.seeds)
    rows = []
    for alpha in (ALPHA, ALPHA / 3):
        rows += [(POWER_AT, "", "", alpha, n, d, power_of_t_test(d, n, alpha)) for d in EFFECTS]
        rows.append((DETECTABLE, "", "", alpha, n, detectable_effect(n, alpha, POWER), POWER))
    for family, a, b in pairs(config):
        if family == "paper":
            values = [table.loc[table["action_space"] == name, MEASURES[0]].to_numpy() for name in (a, b)]
            g = welch(*values).effect_size
            rows.append((NEEDED, a, b, ALPHA / 3, runs_needed(abs(g), ALPHA / 3, POWER), g, POWER))
    frame = pd.DataFrame(rows, columns=["question", "a", "b", "alpha", "n", "effect_size", "power"])
    write_table("navigation_power", frame, out, config)


def write_calibration(scores: Path, out: Path, config: Config) -> None:
    """A/A tests: random halves of one action space's runs are compared; they come from the same agent, so alpha of them should differ.

    The splits are shared equally among the action spaces; the row "all" counts them together.
    """
    table = read_table("navigation_scores", scores)
    spaces = config.navigation.action_spaces
    splits = -(-config.navigation.calibration_splits // len(spaces))
    rows = []
    for measure in MEASURES[:2]:
        rejected = {}
        for action_space in spaces:
            values = table.loc[table["action_space"] == action_space, measure].to_numpy()
            rng = generator(config.seed, "navigation", "calibration", action_space, measure)
            rejected[action_space] = (split_rejections(values, splits, ALPHA, rng), splits)
        rejected[TOGETHER] = (sum(k for k, _ in rejected.values()), splits * len(spaces))
        for action_space, (k, n) in rejected.items():
            low, high = binomial_band(ALPHA, n)
            rows.append((action_space, measure, n, k, k / n, ALPHA, low, high))
    columns = ["action_space", "measure", "splits", "rejected", "rate", "alpha", "band_low", "band_high"]
    write_table("navigation_calibration", pd.DataFrame(rows, columns=columns), out, config)

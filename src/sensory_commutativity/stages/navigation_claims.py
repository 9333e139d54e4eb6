"""The paper's claims about learning (section IV-B), each decided by a rule that was fixed before the runs.

- "viable": at least half of the runs of each of the paper's action spaces reach the threshold return;
- "more than twice as fast": the mean of the steps to the threshold is less than half, with an interval of the ratio below 0.5 and a Holm-adjusted
  p-value of Welch's test against half of the steps below ALPHA;
- "faster", "slower": the difference of the mean steps has the right sign and a Holm-adjusted p-value of Welch's test below ALPHA.

Censored runs count with their full length, so a slow action space looks faster than it is: the ratios are cautious.
"""

from __future__ import annotations

import pandas as pd

from ..config import Config
from ..config.navigation import PAPER_SPACES
from .claims import Claim, p_of_claim
from .navigation_comparisons import ALPHA, HALF, STEPS, WELCH

SECTION = "IV-B"
VIABLE = 0.5


def navigation_claims(summary: pd.DataFrame, comparisons: pd.DataFrame, config: Config) -> list[Claim]:
    """The claims of section IV-B, from the tables navigation_summary and navigation_comparisons."""
    means = summary.set_index(["action_space", "measure"])
    tests = comparisons[comparisons["measure"] == STEPS].set_index(["test", "a", "b"]).sort_index()
    counted = {
        measure: ", ".join(f"{name} {round(means.loc[(name, measure), 'mean'] * means.loc[(name, measure), 'n'])}" for name in PAPER_SPACES)
        for measure in ("reached", "solved")
    }
    n = len(config.navigation.seeds)
    worst = means.loc[[(name, "reached") for name in PAPER_SPACES]].sort_values("mean").iloc[0]
    half = tests.loc[(HALF, "truncated", "full")]
    twice = half["ci_high"] < 0.5 and half["p_adjusted"] < ALPHA and half["statistic"] < 0
    return [
        Claim(
            "every action space can solve the task", SECTION, "all viable",
            f"of {n} runs the threshold is reached by {counted['reached']}; solved by {counted['solved']}",
            float(worst["mean_low"]), float(worst["mean_high"]), bool(worst["mean"] >= VIABLE),
        ),
        Claim(
            "SCP-truncated learns more than twice as fast as the full action space", SECTION, "steps below half",
            f"ratio of mean steps {half['effect_size']:.2f}, against a half {p_of_claim(half['p_adjusted'])}",
            float(half["ci_low"]), float(half["ci_high"]), bool(twice),
        ),
        _sooner("SCP-adapted learns faster than the full action space", "adapted", "full", tests),
        _sooner("SCP-adapted learns slower than SCP-truncated", "truncated", "adapted", tests),
    ]  # fmt: skip


def _sooner(name: str, a: str, b: str, tests: pd.DataFrame) -> Claim:
    test = tests.loc[(WELCH, a, b)]
    said = f"mean steps of {a} less those of {b}: {test['difference']:+,.0f}, {p_of_claim(test['p_adjusted'])}"
    holds = test["difference"] < 0 and test["p_adjusted"] < ALPHA
    return Claim(name, SECTION, "fewer steps", said, float(test["ci_low"]), float(test["ci_high"]), bool(holds))

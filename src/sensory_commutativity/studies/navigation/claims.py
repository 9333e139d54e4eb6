"""The paper's claims about learning (section IV-B), each decided by a rule; docs/differences.md
says when each was fixed.

- "Viable": at least half of the runs of each of the paper's action spaces reach the threshold
  return.
- "More than twice as fast": the mean of the steps to the threshold is less than half, with an
  interval of the ratio below 0.5 and a Holm-adjusted p-value of Welch's test against half of the
  steps below alpha.
- "Faster", "slower": the difference of the mean steps has the right sign and a Holm-adjusted
  p-value of Welch's test below alpha.

Runs that do not reach the threshold are censored: they count with their full length, so the means
are restricted to the budget. The difference to an action space with more censored runs is then
smaller than it would be without a budget. The log-rank test, which takes censoring into account,
must agree.

The comparison by which "more than twice as fast" is decided is also made at other threshold returns
(navigation.sensitivity_thresholds): if the interval of the ratio is not below 0.5 at each of them,
the claim holds in part. The seeds that were drawn after the first look are reported alone.
"""

from __future__ import annotations

import pandas as pd

from ..claims import Claim, Verdict, format_p
from ..config import Config
from .config import PAPER_SPACES
from .tables.navigation_comparisons import HALF, LOG_RANK, STEPS, WELCH
from .tables.navigation_sensitivity import ALL, CONFIRMATION

SECTION = "IV-B"
VIABLE = 0.5
BASE_RANDOM = "base-random"


def navigation_claims(
    summary: pd.DataFrame, comparisons: pd.DataFrame, sensitivity: pd.DataFrame, config: Config
) -> list[Claim]:
    """The claims of section IV-B, from the tables navigation_summary, navigation_comparisons and
    navigation_sensitivity."""
    return [
        _viable(summary, config),
        _twice(comparisons, summary, sensitivity, config),
        _sooner(
            "SCP-adapted learns faster than the full action space", "adapted", "full",
            comparisons, summary, config,
        ),
        _sooner(
            "SCP-adapted learns slower than SCP-truncated", "truncated", "adapted",
            comparisons, summary, config,
        ),
    ]  # fmt: skip


def _viable(summary: pd.DataFrame, config: Config) -> Claim:
    counts = {
        measure: ", ".join(f"{name} {_count(summary, name, measure)}" for name in PAPER_SPACES)
        for measure in ("reached", "solved")
    }
    least = min(_count(summary, name, "reached") for name in PAPER_SPACES)
    n = len(config.navigation.seeds)
    measured = (
        f"of {n} runs the threshold is reached by {counts['reached']}; solved by {counts['solved']}"
    )
    return Claim(
        "every action space can solve the task",
        SECTION,
        "all viable",
        measured,
        None,
        None,
        least >= VIABLE * n,
        rule=f"at least {VIABLE:.0%} of the runs of each reach the threshold return",
        limits="no room but this one was tried",
    )


def _twice(
    comparisons: pd.DataFrame, summary: pd.DataFrame, sensitivity: pd.DataFrame, config: Config
) -> Claim:
    half = _test(comparisons, HALF, "truncated", "full")
    holds = (
        half["ci_high"] < 0.5
        and half["p_adjusted"] < config.navigation.alpha
        and half["statistic"] < 0
    )
    measured = (
        f"ratio of restricted mean steps {half['effect_size']:.2f} "
        f"[{half['ci_low']:.2f}, {half['ci_high']:.2f}], against a half "
        f"{format_p(half['p_adjusted'])}; {_log_rank_p(comparisons, 'truncated', 'full')}; "
        f"{_censored(summary, 'truncated', 'full')}{_confirmed(sensitivity, config)}"
    )
    rows = sensitivity[
        (sensitivity["runs"] == ALL) & (sensitivity["a"] == "truncated")
        & (sensitivity["b"] == "full")
    ]  # fmt: skip
    everywhere = bool((rows["ci_high"] < 0.5).all())
    ratios = ", ".join(f"{row['ratio']:.2f} at {row['threshold']:g}" for _, row in rows.iterrows())
    holds = bool(holds and _agrees(comparisons, "truncated", "full", config))
    return Claim(
        "SCP-truncated learns more than twice as fast as the full action space",
        SECTION,
        "steps below half",
        measured,
        None,
        None,
        holds,
        rule=f"interval of the ratio below .5 and adjusted p against half of the steps below "
        f"{config.navigation.alpha:g}; the log-rank test agrees",
        limits=f"ratio by threshold return: {ratios}; {_beside_base_random(comparisons)}",
        verdict=_verdict(holds, everywhere, half["ci_low"] > 0.5),
    )


def _sooner(
    name: str, a: str, b: str, comparisons: pd.DataFrame, summary: pd.DataFrame, config: Config
) -> Claim:
    test = _test(comparisons, WELCH, a, b)
    interval = f"{test['difference']:+,.0f} [{test['ci_low']:+,.0f}, {test['ci_high']:+,.0f}]"
    measured = (
        f"restricted mean steps of {a} less those of {b}: {interval}, "
        f"{format_p(test['p_adjusted'])}"
    )
    holds = (
        test["difference"] < 0
        and test["p_adjusted"] < config.navigation.alpha
        and _agrees(comparisons, a, b, config)
    )
    return Claim(
        name,
        SECTION,
        "fewer steps",
        f"{measured}; {_log_rank_p(comparisons, a, b)}; {_censored(summary, a, b)}",
        None,
        None,
        bool(holds),
        rule=f"the difference is below 0, adjusted p below {config.navigation.alpha:g}; the "
        "log-rank test agrees",
        limits="means are restricted to the budget of a run",
        verdict=_verdict(bool(holds), True, test["ci_low"] > 0),
    )


def _verdict(holds: bool, everywhere: bool, contradicted: bool) -> Verdict:
    if holds:
        return "holds" if everywhere else "holds in part"
    return "does not hold" if contradicted else "not shown"


def _beside_base_random(comparisons: pd.DataFrame) -> str:
    """What the control says that keeps the base and others at random."""
    asked = "whether the SCP chooses more than the base"
    rows = comparisons[
        (comparisons["measure"] == STEPS) & (comparisons["test"] == WELCH)
        & (comparisons["a"] == "truncated") & (comparisons["b"] == BASE_RANDOM)
    ]  # fmt: skip
    if rows.empty:
        return f"{asked} is not part of this run (control {BASE_RANDOM})"
    row = rows.iloc[0]
    interval = f"[{row['ci_low']:+,.0f}, {row['ci_high']:+,.0f}]"
    return (
        f"{asked}: restricted mean steps less those of {BASE_RANDOM} {row['difference']:+,.0f} "
        f"{interval}, {format_p(row['p_adjusted'])}"
    )


def _confirmed(sensitivity: pd.DataFrame, config: Config) -> str:
    """The comparison by the seeds that were drawn after the first look alone."""
    rows = sensitivity[
        (sensitivity["runs"] == CONFIRMATION)
        & (sensitivity["threshold"] == config.navigation.threshold_return)
        & (sensitivity["a"] == "truncated")
        & (sensitivity["b"] == "full")
    ]
    if rows.empty:
        return ""
    row = rows.iloc[0]
    interval = f"[{row['ci_low']:.2f}, {row['ci_high']:.2f}]"
    return (
        f"; the {int(row['n'])} seeds drawn after the first look alone: {row['ratio']:.2f} "
        f"{interval}, against a half {format_p(row['p_half'])}"
    )


def _test(comparisons: pd.DataFrame, test: str, a: str, b: str) -> pd.Series:
    chosen = (
        (comparisons["measure"] == STEPS)
        & (comparisons["test"] == test)
        & (comparisons["a"] == a)
        & (comparisons["b"] == b)
    )
    return comparisons[chosen].iloc[0]


def _agrees(comparisons: pd.DataFrame, a: str, b: str, config: Config) -> bool:
    """Whether the log-rank test finds that a reaches the threshold sooner."""
    test = _test(comparisons, LOG_RANK, a, b)
    return bool(test["statistic"] > 0 and test["p_adjusted"] < config.navigation.alpha)


def _log_rank_p(comparisons: pd.DataFrame, a: str, b: str) -> str:
    return f"log-rank {format_p(_test(comparisons, LOG_RANK, a, b)['p_adjusted'])}"


def _count(summary: pd.DataFrame, action_space: str, measure: str) -> int:
    chosen = (summary["action_space"] == action_space) & (summary["measure"] == measure)
    row = summary[chosen].iloc[0]
    return round(row["mean"] * row["n"])


def _censored(summary: pd.DataFrame, *action_spaces: str) -> str:
    """How many runs are censored."""
    n = int(summary["n"].iloc[0])
    return "censored " + ", ".join(
        f"{name} {n - _count(summary, name, 'reached')}" for name in action_spaces
    )

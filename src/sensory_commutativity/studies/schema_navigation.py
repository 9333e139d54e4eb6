"""Tables of learning to navigate (paper, section IV-B)."""

from __future__ import annotations

from ..storage.columns import BOOL, FLOAT, INT, INTERVAL, SCP, TEST, TEXT, Column, Tables

RUN = (
    Column("action_space", TEXT, "", "full, truncated, adapted, random-half or inverse"),
    Column("seed", INT, "1", "which training run"),
)
PAIR = (
    Column(
        "family",
        TEXT,
        "",
        "paper: the three action spaces that the paper compares; controls: the other pairs",
    ),
    Column("a", TEXT, "", "action space"),
    Column("b", TEXT, "", "action space"),
)

NAVIGATION: Tables = {
    "navigation_scp": SCP,
    "navigation_action_spaces": (
        *RUN,
        Column("dof", TEXT, "", "degree of freedom"),
        Column("scp", FLOAT, "1", "its measured sensory commutativity probability"),
        Column("scale", FLOAT, "1", "factor of its action interval; 0 fixes it"),
    ),
    "navigation_curves": (
        *RUN,
        Column("step", INT, "steps", "environment steps of training before this evaluation"),
        Column("episode_return", FLOAT, "reward", "mean return of the evaluation's episodes"),
        Column("success_rate", FLOAT, "1", "fraction of episodes that ended in the goal"),
        Column("dead_rate", FLOAT, "1", "fraction of episodes that ended in a dead zone"),
        Column("episode_length", FLOAT, "steps", "mean length of the episodes"),
        Column("episodes", INT, "1", "episodes of the evaluation"),
    ),
    "navigation_scores": (
        *RUN,
        Column("final_return", FLOAT, "reward", "mean return at the last evaluation"),
        Column(
            "auc",
            FLOAT,
            "reward",
            "mean return over all evaluations: the area under the learning curve",
        ),
        Column(
            "success_rate",
            FLOAT,
            "1",
            "fraction of episodes that ended in the goal at the last evaluation",
        ),
        Column(
            "steps_to_threshold",
            FLOAT,
            "steps",
            "first evaluation with the threshold return; the whole run where none had it",
        ),
        Column(
            "reached",
            BOOL,
            "",
            "whether the threshold return was reached; if not, steps_to_threshold is censored",
        ),
        Column(
            "solved",
            BOOL,
            "",
            "whether the last evaluation has the success rate that counts as solved",
        ),
    ),
    "navigation_summary": (
        Column("action_space", TEXT, "", "which action space"),
        Column(
            "measure",
            TEXT,
            "",
            "a score, or the fraction of runs that reached the threshold or solved the task",
        ),
        Column("n", INT, "1", "runs"),
        Column("mean", FLOAT, "of the measure", "mean"),
        Column(
            "mean_low",
            FLOAT,
            "of the measure",
            "95 % interval of the mean: Student's t; Wilson's for fractions of runs",
        ),
        Column("mean_high", FLOAT, "of the measure", "its upper end"),
        Column("median", FLOAT, "of the measure", "median"),
        Column("median_low", FLOAT, "of the measure", "95 % interval, bootstrap"),
        Column("median_high", FLOAT, "of the measure", "its upper end"),
        Column("iqm", FLOAT, "of the measure", "interquartile mean"),
        Column("iqm_low", FLOAT, "of the measure", "95 % interval, bootstrap"),
        Column("iqm_high", FLOAT, "of the measure", "its upper end"),
    ),
    "navigation_comparisons": (
        *PAIR,
        Column("measure", TEXT, "", "which score"),
        Column("test", TEXT, "", "name of the test; Welch decides"),
        Column("statistic", FLOAT, "1", "of the test"),
        Column("df", FLOAT, "1", "degrees of freedom"),
        *TEST,
        Column("difference", FLOAT, "of the measure", "mean of a minus mean of b"),
        Column(
            "ci_low",
            FLOAT,
            "of the measure",
            "lower end of the 95 % interval of the difference, or else of the effect size",
        ),
        Column("ci_high", FLOAT, "of the measure", "its upper end"),
        Column("effect", TEXT, "", "what effect_size is"),
        Column(
            "effect_size",
            FLOAT,
            "1",
            "Hedges' g, the probability that a run of a is better, or the ratio of the mean steps",
        ),
        Column(
            "agrees",
            TEXT,
            "",
            "yes or no: whether the test decides as Welch's does; empty for Welch's own and for other questions",
        ),
    ),
    "navigation_checkpoints": (
        Column("step", INT, "steps", "environment steps of training"),
        *PAIR,
        Column("difference", FLOAT, "reward", "mean return of a minus that of b"),
        Column("ci_low", FLOAT, "reward", "lower end of its 95 % interval, not corrected"),
        Column("ci_high", FLOAT, "reward", "its upper end"),
        Column("p", FLOAT, "1", "two-sided p-value, Welch"),
        Column(
            "p_adjusted",
            FLOAT,
            "1",
            "p-value after Holm's correction over all checkpoints and pairs of the family",
        ),
    ),
    "navigation_survival": (
        Column("action_space", TEXT, "", "which action space"),
        Column("step", FLOAT, "steps", "environment steps of training"),
        Column("at_risk", INT, "1", "runs that had not reached the threshold before"),
        Column("events", INT, "1", "runs that reached it here"),
        Column(
            "survival",
            FLOAT,
            "1",
            "Kaplan-Meier estimate of the fraction of runs that have not reached it",
        ),
        *INTERVAL,
    ),
    "navigation_profiles": (
        Column("action_space", TEXT, "", "which action space"),
        Column("threshold", FLOAT, "reward", "final return"),
        Column("n", INT, "1", "runs"),
        Column("above", INT, "1", "runs with at least this final return"),
        Column("fraction", FLOAT, "1", "their fraction"),
        *INTERVAL,
    ),
    "navigation_calibration": (
        Column(
            "method",
            TEXT,
            "",
            "how two groups are made from one: random halves, or resampled with replacement to full size",
        ),
        Column(
            "action_space",
            TEXT,
            "",
            "whose runs were compared; all: together, but for those whose runs are all equal",
        ),
        Column("measure", TEXT, "", "which score"),
        Column("splits", INT, "1", "pairs of groups that were compared (A/A)"),
        Column("rejected", INT, "1", "how many differed significantly"),
        Column("rate", FLOAT, "1", "their fraction"),
        Column("alpha", FLOAT, "1", "what it should be"),
        Column(
            "band_low",
            FLOAT,
            "1",
            "central 95 % of the rate if each comparison rejected independently with probability alpha",
        ),
        Column("band_high", FLOAT, "1", "its upper end"),
    ),
    "navigation_power": (
        Column("question", TEXT, "", "what is asked"),
        Column("a", TEXT, "", "action space, where an observed effect is meant"),
        Column("b", TEXT, "", "the other"),
        Column("alpha", FLOAT, "1", "significance level: family-wise, and divided by three pairs"),
        Column("n", FLOAT, "1", "runs of each action space"),
        Column("effect_size", FLOAT, "1", "standardised difference of means"),
        Column("power", FLOAT, "1", "probability to find it"),
    ),
}

"""Whether PPO learns otherwise in an action space made from SCPs than in the full one."""

from __future__ import annotations

import pandas as pd

from ....storage.columns import FLOAT, INT, P_VALUES, TEXT, Column
from ...config import Config
from ...declarations import table
from ..builders import atlas
from ..columns import ACTION_SPACE

MEASURES = {
    "area": "mean return over the evaluations of a run, without the first",
    "final_return": "mean return at the last evaluation",
    "final_displacement": "mean distance that the puck was pushed at the last evaluation, m",
}


def score_runs(curves: pd.DataFrame) -> pd.DataFrame:
    """The measures of every run: action_space, seed and the keys of MEASURES."""
    rows = []
    for (space, seed), curve in curves.groupby(["action_space", "seed"], sort=False):
        curve = curve.sort_values("step")
        last = curve.iloc[-1]
        area = curve["episode_return"].iloc[1:].mean()
        rows.append((space, seed, area, last["episode_return"], last["displacement"]))
    return pd.DataFrame(rows, columns=["action_space", "seed", *MEASURES])


@table(
    title="Comparison of action spaces with the planar arm",
    columns=(
        ACTION_SPACE,
        Column("measure", TEXT, "", "; ".join(f"{k}: {v}" for k, v in MEASURES.items()), key=True),
        Column("n", INT, "1", "training runs"),
        Column("mean", FLOAT, "of the measure", "mean over the runs"),
        Column("against", TEXT, "", "the action space that it is compared with"),
        Column("difference", FLOAT, "of the measure", "mean less that of the other"),
        Column("ci_low", FLOAT, "of the measure", "lower end of its 95 % interval, Welch"),
        Column("ci_high", FLOAT, "of the measure", "upper end"),
        *P_VALUES,
    ),
    inputs=["learning_curves"],
    settings=lambda config: atlas(config).learning,
)
def learning_comparisons(curves: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Welch's test of each action space against the first; Holm's correction within a measure."""
    from ....statistics.groups import welch
    from ....statistics.paired import holm

    scores = score_runs(curves)
    first, *others = atlas(config).learning.action_spaces
    frames = []
    for measure in MEASURES:
        base = scores.loc[scores["action_space"] == first, measure].to_numpy()
        rows = []
        for space in others:
            values = scores.loc[scores["action_space"] == space, measure].to_numpy()
            test = welch(values, base)
            rows.append(
                dict(action_space=space, measure=measure, n=len(values), mean=values.mean(),
                     against=first, difference=test.difference, ci_low=test.ci_low,
                     ci_high=test.ci_high, p=test.p)
            )  # fmt: skip
        frame = pd.DataFrame(rows)
        frame["p_adjusted"] = holm(frame["p"].to_numpy())
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)[learning_comparisons.column_names]

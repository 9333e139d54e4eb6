"""What the controls say about the SCP of an environment's actions: a row each, with a verdict.

An action whose orders end apart although nothing was touched says nothing about the world: actions
may be forces, joints reach stops, nothing comes to rest, or steps are noisy.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pandas as pd

from ..scp.estimate import commutes
from ..statistics.proportions import wilson_interval

UNTOUCHED = 0.95
"""Least SCP of experiments that touched nothing with which an SCP can be read as an effect on the
world. Chosen."""
AREA = 1e-4, 1.0
"""Distances between which the area under P(d <= t) is taken, over log t. Chosen: from what servos
leave to the whole spread of a sensor."""
FORCES = 0.5
"""Order over actions (see :func:`add_report`) from which on actions count as forces. Chosen: the
order matters then nearly as much as the actions themselves."""
NOISY = 0.5
"""Noise over distance, at their medians, from which on the step counts as noisy. Chosen."""
NO_ROOM = 0.05
"""Mean amplitude of the sequences below which an action was hardly tried. Chosen."""
FEW_CONTROLS = 5
"""Experiments that touched nothing with which a row has a control at least. Chosen."""
FEW = 0.1
"""Share of experiments that may be without rest, or terminate, before a row says so. Chosen."""


def area_under_curve(distances: np.ndarray) -> float:
    """Area under P(d <= t) over log t, from 1e-4 to 1, as a share: 1 if all are below 1e-4."""
    low, high = np.log10(AREA[0]), np.log10(AREA[1])
    at = np.log10(np.maximum(distances, AREA[0] / 10))
    return float(np.mean(np.clip((high - at) / (high - low), 0, 1)))


def add_report(
    table: pd.DataFrame,
    distances: np.ndarray,
    controls: Mapping[str, np.ndarray],
    names: Sequence[str],
) -> pd.DataFrame:
    """Add the columns of the controls to a table of SCPs; returns it unchanged without controls.

    Parameters
    ----------
    table : DataFrame
        One row per degree of freedom and threshold.
    distances : float (n, n_dofs)
    controls : mapping of str to float (n, n_dofs)
    names : sequence of str

    Returns
    -------
    DataFrame
        With, in addition: scp_untouched, untouched_low, untouched_high and n_untouched (SCP of the
        experiments that touched nothing; NaN where contacts are not known), touched (share), area
        (:func:`area_under_curve`), order_over_actions (median distance of two orders over that of
        two unrelated sequences), noise_over_order (median distance of the same order with other
        noise, over that of the two orders), amplitude (mean largest action of the sequences, which
        are scaled to stay off the stops), rest_steps (mean), not_still and terminated (shares),
        reaches_stop (share of sequences of which an order could reach a stop), repeated (share of
        starts whose first order, repeated, ended equal), verdict.
    """
    if not controls:
        return table
    rows = []
    for record in table.itertuples():
        k = list(names).index(str(record.dof))
        of_dof = {name: values[:, k] for name, values in controls.items()}
        rows.append(_row(distances[:, k], of_dof, float(record.threshold)))
    return pd.concat([table, pd.DataFrame(rows, index=table.index)], axis=1)


def _row(distance: np.ndarray, controls: Mapping[str, np.ndarray], threshold: float) -> dict:
    touched = controls["touched"]
    untouched = commutes(distance[touched == 0], threshold)
    touching = commutes(distance[touched == 1], threshold)
    n = len(untouched)
    low, high = wilson_interval(untouched.sum(), n) if n else (np.nan, np.nan)
    row = dict(
        n_touched=len(touching),
        touched_high=_upper(touching),
        scp_untouched=untouched.mean() if n else np.nan,
        untouched_low=float(low),
        untouched_high=float(high),
        n_untouched=n,
        touched=_mean(touched),
        area=area_under_curve(distance),
        order_over_actions=_ratio(distance, controls["unrelated"]),
        noise_over_order=_ratio(controls["noise"], distance),
        amplitude=_mean(controls["amplitude"]),
        rest_steps=_mean(controls["rest_steps"]),
        not_still=_mean(controls["not_still"]),
        terminated=_mean(controls["terminated"]),
        reaches_stop=_mean(controls["reaches_stop"]),
        repeated=_mean(controls["repeated"]),
    )
    text = verdict(row, distance, controls["unrelated"])
    del row["n_touched"], row["touched_high"]  # for the verdict alone
    return {**row, "verdict": text}


def verdict(row: Mapping[str, float], distance: np.ndarray, unrelated: np.ndarray) -> str:
    """Say in a few words what a row shows, or why it shows nothing."""
    tried = unrelated[~np.isnan(unrelated)]
    if row["amplitude"] < NO_ROOM:
        return "undefined: starts at a stop, with no room to move"
    if not distance.any() and len(tried) and not tried.any():
        return "dead: the action changes nothing that is sensed"
    if row["repeated"] < 1:
        return f"undefined: repeated orders ended equal in {row['repeated']:.0%} of starts only"
    if row["terminated"] > FEW:
        return f"undefined: {row['terminated']:.0%} of the sequences terminate"
    if row["noise_over_order"] > NOISY:
        return "undefined: steps are noisy"
    if np.isnan(row["scp_untouched"]):
        if np.isnan(row["touched"]):
            if row["order_over_actions"] > FORCES:
                return "no effect on the world shown: actions are like forces"
            return "contacts are not known: an upper bound of the effect on the world"
        return "everything touched something: no control in free space"
    if row["n_untouched"] < FEW_CONTROLS:
        return f"only {row['n_untouched']:.0f} experiments touched nothing: no control"
    if row["scp_untouched"] >= UNTOUCHED:
        if row["touched"] == 0:
            return "commutes in free space, and touched nothing"
        if row["touched_high"] < row["untouched_low"]:
            return f"shows an effect on the world (touched in {row['touched']:.0%})"
        return f"no effect on the world seen (touched in {row['touched']:.0%})"
    return f"no effect on the world shown: {_reason(row)}"


def _upper(commuted: np.ndarray) -> float:
    """Upper end of the interval of the SCP; 1 without experiments."""
    n = len(commuted)
    return float(wilson_interval(commuted.sum(), n)[1]) if n else 1.0


def _reason(row: Mapping[str, float]) -> str:
    """Why experiments that touched nothing do not commute."""
    if row["order_over_actions"] > FORCES:
        return "actions are like forces"
    if row["reaches_stop"] > FEW:
        return "joints reach their stops"
    if row["not_still"] > FEW:
        return "does not come to rest"
    return "free space does not commute (friction, lag, or limits)"


def describe_report(table: pd.DataFrame, thresholds: Sequence[float]) -> Iterator[str]:
    """Lines of text: one per degree of freedom at the first threshold, lowest SCP first."""
    threshold = thresholds[0]
    rows = table[table["threshold"] == threshold].sort_values(["scp", "area"])
    width = max(len(str(name)) for name in rows["dof"])
    yield (
        f"{'':{width}}  {'SCP':>5}  {'95 % interval':14}  {'free':>5}  {'touched':>7}  {'rest':>5}"
        f"  at distance <= {threshold:g}"
    )
    for row in rows.to_dict("records"):
        interval = f"[{row['ci_low']:.3f}, {row['ci_high']:.3f}]"
        yield (
            f"{row['dof']:{width}}  {row['scp']:5.3f}  {interval:14}  "
            f"{_cell(row['scp_untouched']):>5}  {_cell(row['touched']):>7}  "
            f"{row['rest_steps']:5.0f}  {row['verdict']}"
        )
    first = rows.iloc[0]
    yield (
        "free: SCP of the experiments that touched nothing; rest: steps until still "
        f"(not still in {rows['not_still'].mean():.0%}); repeated exactly: {first['repeated']:.0%}"
    )


def _cell(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.2f}"


def _mean(values: np.ndarray) -> float:
    return float(np.nanmean(values)) if not np.isnan(values).all() else float("nan")


def _ratio(over: np.ndarray, under: np.ndarray) -> float:
    """Median over median, of the experiments that have both; NaN if there is none."""
    both = ~(np.isnan(over) | np.isnan(under))
    if not both.any():
        return float("nan")
    below = float(np.median(under[both]))
    return float(np.median(over[both])) / below if below else float("nan")

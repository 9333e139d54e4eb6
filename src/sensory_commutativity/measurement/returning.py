"""Measuring without a restore: rows of the return protocol, and what its control says."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from ..errors import ArgumentError, WorldError
from ..scp.distances import Distance
from ..scp.estimate import commutes
from ..scp.return_protocol import known_inverses, trials_per_dof, wander
from ..scp.world import SteppableWorld, World
from ..seeding import generator
from ..statistics.paired import mcnemar
from ..statistics.proportions import wilson_interval
from ..statistics.ratios import paired_ratio

RETURN = "return"
"""Name of the protocol."""
COLUMNS = {
    "distance": "distance of the ends of the two orders",
    "control": "distance of the ends of the same order played twice",
    "returned": "distance of the views of the start before and after a return",
    "waited": "distance of the views of the start before and after two returns",
}
"""What a trial yields for every degree of freedom."""


class Life(NamedTuple):
    """How trials follow each other.

    Attributes
    ----------
    reset_every : int, optional
        Trials of every degree of freedom between two resets. By default the world is reset once,
        at the beginning, if it has a reset at all.
    wander : int
        Random actions before the trials of every start but the first after a reset.
    """

    reset_every: int | None
    wander: int


def prepare_start(world: SteppableWorld, seed: int, begins: bool, steps: int) -> None:
    """Reset the world at the beginning of a life, or wander on."""
    if begins and isinstance(world, World):
        world.reset(generator(seed, "situation"))
    elif not begins and steps:
        wander(world, seed, steps)


def play_start(
    world: SteppableWorld,
    seed: int,
    length: int,
    distance: Distance,
    rest_steps: int,
    dofs: Collection[str] | None = None,
) -> np.ndarray:
    """A row of trials; NaN for degrees of freedom that are not tried."""
    row = np.full((len(world.dofs), len(COLUMNS)), np.nan)
    names = [dof.name for dof in world.dofs]
    for name, found in trials_per_dof(world, seed, length, distance, rest_steps, dofs):
        row[names.index(name)] = found
    return row


def describe_inverses(world: SteppableWorld) -> str:
    """For which degrees of freedom the way back is known, for people.

    Raises
    ------
    ArgumentError
        If it is not known for any.
    """
    known = known_inverses(world)
    unknown = [dof.name for dof, knows in zip(world.dofs, known, strict=True) if not knows]
    if len(unknown) == len(known):
        raise ArgumentError(
            "protocol: the inverse of no action is known, since all are forces or positions to go "
            "to; command velocities, or changes of positions, or measure with protocol='reset'"
        )
    if not unknown:
        return "way back: the inverse of every action is known"
    return (
        f"way back: the inverse of {', '.join(unknown)} is not known, so that a return may lead "
        "elsewhere"
    )


def require_steppable(world: object) -> None:
    """Raise WorldError if `world` lacks what the return protocol asks for."""
    missing = [name for name in ("step", "observe") if not callable(getattr(world, name, None))]
    missing += [] if hasattr(world, "dofs") else ["dofs"]
    if missing:
        raise WorldError(
            f"world: {type(world).__name__} has no {', '.join(missing)}; the return protocol asks "
            "for dofs, step and observe"
        )


# ---- the table ------------------------------------------------------------------------------


def add_relative(
    table: pd.DataFrame,
    distances: np.ndarray,
    controls: Mapping[str, np.ndarray],
    names: Sequence[str],
) -> pd.DataFrame:
    """Add what the control says to a table of SCPs.

    Parameters
    ----------
    table : DataFrame
        A row per degree of freedom and threshold.
    distances : float (n, n_dofs)
    controls : mapping of str to float (n, n_dofs)
    names : sequence of str

    Returns
    -------
    DataFrame
        With, in addition: control (SCP of the same order played twice), control_low, control_high,
        relative (SCP over that of the control), relative_low, relative_high (95 %, Bonett and
        Price), p (McNemar's test that both are equal), start_seen_again (share of returns after
        which the start looked as before).
    """
    rows = []
    for record in table.itertuples():
        k = list(names).index(str(record.dof))
        played = ~np.isnan(distances[:, k])
        threshold = float(record.threshold)
        commuted = commutes(distances[played, k], threshold)
        control = commutes(controls["control"][played, k], threshold)
        seen = commutes(controls["returned"][played, k], threshold)
        low, high = wilson_interval(int(control.sum()), len(control))
        relative = paired_ratio(commuted, control)
        rows.append(
            dict(
                control=control.mean(), control_low=float(low), control_high=float(high),
                relative=relative.ratio, relative_low=relative.ci_low,
                relative_high=relative.ci_high, p=mcnemar(commuted, control).p,
                start_seen_again=seen.mean(),
            )
        )  # fmt: skip
    return pd.concat([table, pd.DataFrame(rows, index=table.index)], axis=1)


def describe_relative(table: pd.DataFrame, thresholds: Sequence[float]) -> Iterator[str]:
    """Lines of text: one per degree of freedom at the first threshold, lowest first."""
    rows = table[table["threshold"] == thresholds[0]].sort_values(["relative", "scp"])
    width = max(len(str(name)) for name in rows["dof"])
    yield (
        f"{'':{width}}  {'n':>5}  {'SCP':>5}  {'control':>7}  {'relative':>8}  "
        f"{'95 % interval':14}  {'p':>7}  start seen again"
    )
    for row in rows.to_dict("records"):
        interval = f"[{row['relative_low']:.3f}, {row['relative_high']:.3f}]"
        yield (
            f"{row['dof']:{width}}  {row['n']:5d}  {row['scp']:5.3f}  {row['control']:7.3f}  "
            f"{row['relative']:8.3f}  {interval:14}  {row['p']:7.2g}  "
            f"{row['start_seen_again']:.3f}"
        )
    yield (
        "control: the same order twice, with a return; relative: SCP over control; p: that both "
        "are equal"
    )

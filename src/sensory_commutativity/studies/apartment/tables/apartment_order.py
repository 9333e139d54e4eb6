"""Does the order of the degrees of freedom stay the same? Kendall's tau against the reference condition (section III-C: "a large range of tau")."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ....scp.estimate import commutes
from ....seeding import generator
from ....statistics.orders import order_agreement
from ....storage.tables import read_table, write_table
from ...config import Config


class Condition(NamedTuple):
    """Under which SCPs were measured."""

    apartment: str
    start: str
    length: int
    field_of_view: float
    threshold: float


def compare_orders_of_dofs(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """A row per change of one setting; `experiments` is an apartment_experiments table, of which the reference robot is taken."""
    settings = config.apartment
    frame = experiments[experiments["robot"] == settings.reference.robot]
    reference = Condition(
        settings.reference.scene,
        "anywhere",
        settings.sequence_length,
        settings.fields_of_view[0],
        settings.reference.threshold,
    )
    rows = []
    for changed, value, condition in _changes(reference, config):
        a, b = _commuted(frame, reference), _commuted(frame, condition)
        paired = (condition.apartment, condition.start) == (reference.apartment, reference.start)
        if paired:
            shared = a.index.intersection(b.index)
            a, b = a.loc[shared], b.loc[shared]
        found = order_agreement(
            a.to_numpy(),
            b[a.columns].to_numpy(),
            generator(config.seed, "apartment", "order", changed, value),
            paired,
        )
        rows.append((settings.reference.robot, changed, value, len(b), *found))
    return pd.DataFrame(
        rows, columns=["robot", "changed", "value", "n", "tau", "ci_low", "ci_high"]
    )


def _changes(reference: Condition, config: Config) -> Iterator[tuple[str, str, Condition]]:
    """(what is changed, to what, the condition): one setting at a time."""
    settings = config.apartment
    for threshold in settings.thresholds:
        if threshold != reference.threshold:
            yield "threshold", f"{threshold:g}", reference._replace(threshold=threshold)
    for field_of_view in settings.fields_of_view[1:]:
        yield (
            "field of view",
            f"{field_of_view:g} degrees",
            reference._replace(field_of_view=field_of_view),
        )
    mine = [
        run
        for run in settings.runs()
        if run.robot == settings.reference.robot and settings.scenes[run.scene].file is not None
    ]
    for run in mine:
        if run.start == "anywhere" and run.scene != reference.apartment:
            yield "apartment", run.scene, reference._replace(apartment=run.scene)
    for run in mine:
        if run.start == "within-reach" and run.scene == reference.apartment:
            yield "start", run.start, reference._replace(start=run.start)
    for length in settings.sensitivity.lengths:
        yield "length", f"{length} actions", reference._replace(length=length)


def _commuted(frame: pd.DataFrame, condition: Condition) -> pd.DataFrame:
    """Which experiments commuted, float: a row per experiment, a column per degree of freedom."""
    chosen: Any = np.logical_and.reduce(
        [frame[key] == value for key, value in condition._asdict().items() if key != "threshold"]
    )
    rows = frame[chosen]
    commuted = rows.assign(
        commuted=commutes(rows["distance"].to_numpy(), condition.threshold).astype(float)
    )
    return commuted.pivot(index="experiment", columns="dof", values="commuted")


def write_order(experiments: Path, out: Path, config: Config) -> None:
    """The stability of the order."""
    write_table(
        "apartment_order",
        compare_orders_of_dofs(read_table("apartment_experiments", experiments), config),
        out,
        config,
    )

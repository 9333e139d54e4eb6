"""Whether the order of the degrees of freedom by SCP is stable (paper, section III-C: "a large
range of tau"): Kendall's tau with the order in the reference condition."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from ....scp.estimate import commutes
from ....seeding import generator
from ....storage.columns import FLOAT, INT, INTERVAL, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from ..columns import ROBOT


class Condition(NamedTuple):
    """Where and how SCPs of the reference robot are measured."""

    apartment: str
    start: str
    length: int
    field_of_view: float
    threshold: float


def reference_condition(config: Config) -> Condition:
    """The condition that all others are compared with."""
    settings = config.apartment
    return Condition(
        settings.reference.scene,
        "anywhere",
        settings.sequence_length,
        settings.fields_of_view[0],
        settings.reference.threshold,
    )


def changed_conditions(config: Config) -> Iterator[tuple[str, str, Condition]]:
    """Yield all conditions that differ from the reference in one setting.

    Yields
    ------
    changed, value : str
        Name of the setting and its value.
    condition : Condition
    """
    settings, reference = config.apartment, reference_condition(config)
    for threshold in settings.thresholds:
        if threshold != reference.threshold:
            yield "threshold", f"{threshold:g}", reference._replace(threshold=threshold)
    for view in settings.fields_of_view[1:]:
        yield "field of view", f"{view:g} degrees", reference._replace(field_of_view=view)
    runs = [
        run
        for run in settings.runs()
        if run.robot == settings.reference.robot and settings.scenes[run.scene].file is not None
    ]
    for run in runs:
        if run.start == "anywhere" and run.scene != reference.apartment:
            yield "apartment", run.scene, reference._replace(apartment=run.scene)
    for run in runs:
        if run.start == "within-reach" and run.scene == reference.apartment:
            yield "start", run.start, reference._replace(start=run.start)
    for length in settings.sensitivity.lengths:
        yield "length", f"{length} actions", reference._replace(length=length)


def _commuted(experiments: pd.DataFrame, condition: Condition) -> pd.DataFrame:
    """Which experiments commuted, 0.0 or 1.0: a row per experiment, a column per dof."""
    selected = np.full(len(experiments), True)
    for name, value in condition._asdict().items():
        if name != "threshold":
            selected &= (experiments[name] == value).to_numpy()
    rows = experiments[selected]
    commuted = commutes(rows["distance"].to_numpy(), condition.threshold).astype(float)
    rows = rows.assign(commuted=commuted)
    return rows.pivot(index="experiment", columns="dof", values="commuted")


def _settings(config: Config) -> object:
    apartment = config.apartment
    return [apartment.reference, list(changed_conditions(config))]


def _expected(config: Config) -> Expected:
    names = [(changed, value) for changed, value, _ in changed_conditions(config)]
    return Expected(("changed", "value"), dict.fromkeys(names, 1))


@table(
    title="Stability of the order of the degrees of freedom",
    columns=(
        ROBOT,
        Column("changed", TEXT, "", "setting that differs from the reference", key=True),
        Column("value", TEXT, "", "its value", key=True),
        Column("n", INT, "1", "start situations"),
        Column(
            "tau", FLOAT, "1",
            "Kendall's tau-b between the SCPs of the dofs with this value and in the reference",
            nullable=True,
        ),
        *INTERVAL,
    ),
    inputs=["apartment_experiments"],
    settings=_settings,
    expected=_expected,
)  # fmt: skip
def apartment_order(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """A row for every change of one setting, for the reference robot.

    Conditions that share apartment and start share their start situations, which are then
    resampled together.
    """
    from ....statistics.orders import order_agreement

    robot, reference = config.apartment.reference.robot, reference_condition(config)
    experiments = experiments[experiments["robot"] == robot]
    rows = []
    for changed, value, condition in changed_conditions(config):
        a, b = _commuted(experiments, reference), _commuted(experiments, condition)
        paired = (condition.apartment, condition.start) == (reference.apartment, reference.start)
        if paired:
            shared = a.index.intersection(b.index)
            a, b = a.loc[shared], b.loc[shared]
        rng = generator(config.seed, "apartment", "order", changed, value)
        agreement = order_agreement(a.to_numpy(), b[a.columns].to_numpy(), rng, paired)
        rows.append((robot, changed, value, len(b), *agreement))
    return pd.DataFrame(rows, columns=apartment_order.column_names)

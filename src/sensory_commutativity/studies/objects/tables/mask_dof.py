"""The degree of freedom that plays the SC-experiments on objects: the one whose SCP is nearest one
half (paper, section IV-A)."""

from __future__ import annotations

import pandas as pd

from ....storage.columns import FLOAT, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import described_robot, load_masks_robot


@table(
    title="Degree of freedom of the SC-experiments on objects",
    columns=(
        Column("robot", TEXT, "", "a key of apartment.robots", key=True),
        Column("dof", TEXT, "", "degree of freedom of the arm whose SCP is nearest one half"),
        Column(
            "scp", FLOAT, "1", "its sensory commutativity probability in the reference",
            low=0, high=1,
        ),
    ),
    inputs=["apartment_scp"],
    settings=lambda config: [config.masks.robot, described_robot(config),
                             config.apartment.reference, config.apartment.fields_of_view[0]],
    expected=lambda config: Expected(("robot",), {(config.masks.robot,): 1}),
)  # fmt: skip
def mask_dof(scp: pd.DataFrame, config: Config) -> pd.DataFrame:
    """One row.

    Wheels and lifts are not considered: they move the camera, so that almost every outcome would
    be "different".
    """
    apartment = config.apartment
    reference = apartment.reference
    rows = scp[
        (scp["robot"] == reference.robot)
        & (scp["apartment"] == reference.scene)
        & (scp["start"] == "anywhere")
        & (scp["length"] == apartment.sequence_length)
        & (scp["threshold"] == reference.threshold)
        & (scp["field_of_view"] == apartment.fields_of_view[0])
    ].set_index("dof")["scp"]
    robot = load_masks_robot(config)
    arm = [
        dof.name
        for dof in robot.description.dofs
        if dof.unit == "rad" and not set(dof.joints) & set(robot.wheels)
    ]
    nearest = (rows[arm] - 0.5).abs().idxmin()
    return pd.DataFrame(
        [(config.masks.robot, str(nearest), float(rows[nearest]))], columns=["robot", "dof", "scp"]
    )

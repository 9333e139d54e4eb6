"""The paper's claims beside what was measured. The rules by which claims are decided are in the
modules ``claims`` of each study."""

from __future__ import annotations

import pandas as pd

from ....storage.columns import BOOL, FLOAT, TEXT, Column
from ...apartment.builders import described_files
from ...apartment.claims import apartment_claims
from ...config import Config
from ...declarations import table
from ...flatland.claims import flatland_claims
from ...navigation.claims import navigation_claims
from ...objects.claims import mask_claims

INPUTS = (
    "flatland_scp", "flatland_comparisons", "flatland_trends", "flatland_commutation",
    "flatland_baselines", "flatland_alternatives", "apartment_scp", "apartment_hierarchy",
    "apartment_order", "mask_summary", "mask_comparisons", "mask_discoveries",
    "local_scp_summary", "navigation_summary", "navigation_comparisons",
    "navigation_sensitivity",
)  # fmt: skip


@table(
    title="The paper's claims and what this run measured",
    columns=(
        Column("claim", TEXT, "", "what the paper says", key=True),
        Column("section", TEXT, "", "where", key=True),
        Column("paper_value", TEXT, "", "the paper's value, if it gives one"),
        Column("our_value", TEXT, "", "what this run measured"),
        Column(
            "ci_low", FLOAT, "1", "lower end of the 95 % interval, if the value is one number",
            nullable=True,
        ),
        Column(
            "ci_high", FLOAT, "1", "upper end of the 95 % interval, if the value is one number",
            nullable=True,
        ),
        Column("holds", BOOL, "", "whether the rule is met in this run"),
        Column(
            "rule", TEXT, "",
            "the rule; verdicts were defined when the committed run was known",
            added=True,
        ),
        Column("limits", TEXT, "", "what the rule does not show; may be empty", added=True),
        Column(
            "verdict", TEXT, "", "holds, holds in part, not shown, or does not hold", added=True
        ),
    ),
    inputs=INPUTS,
    settings=lambda config: [config.flatland, config.apartment, config.masks, config.navigation,
                             described_files(config)],
)  # fmt: skip
def paper_comparison(*arguments) -> pd.DataFrame:
    """All claims, in the order of the paper; `arguments` are the tables INPUTS and the
    configuration."""
    *frames, config = arguments
    tables = dict(zip(INPUTS, frames, strict=True))
    claims = compare_with_paper(tables, config)
    rows = pd.DataFrame([claim.row() for claim in claims], columns=paper_comparison.column_names)
    return rows.astype({"ci_low": float, "ci_high": float})


def compare_with_paper(tables: dict[str, pd.DataFrame], config: Config):
    """All claims, from tables by name."""
    return [
        *flatland_claims(tables, config),
        *apartment_claims(tables, config),
        *mask_claims(tables, config),
        *navigation_claims(
            tables["navigation_summary"],
            tables["navigation_comparisons"],
            tables["navigation_sensitivity"],
            config,
        ),
    ]

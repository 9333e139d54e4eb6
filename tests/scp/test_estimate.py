"""scp/estimate.py: from distances to the Sensory Commutativity Probability."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from sensory_commutativity.scp.estimate import commutes, estimate_scp

EXPERIMENTS = pd.DataFrame(
    {
        "world": ["room"] * 4 + ["garden"] * 2 + ["room"] * 2,
        "dof": ["head"] * 4 + ["head"] * 2 + ["arm"] * 2,
        "distance": [0.0, 1.0, 10.0, 0.5, 0.0, 0.0, 3.0, 200.0],
    }
)


def test_by_hand():
    table = estimate_scp(EXPERIMENTS, ["world", "dof"], [0.0, 1.0, 100.0])
    columns = ["world", "dof", "threshold", "n", "commuted", "scp"]
    assert table.columns.tolist() == [*columns, "ci_low", "ci_high"]
    assert list(table[columns].itertuples(index=False, name=None)) == [
        ("room", "head", 0.0, 4, 1, 0.25),
        ("room", "head", 1.0, 4, 3, 0.75),
        ("room", "head", 100.0, 4, 4, 1.0),
        ("garden", "head", 0.0, 2, 2, 1.0),
        ("garden", "head", 1.0, 2, 2, 1.0),
        ("garden", "head", 100.0, 2, 2, 1.0),
        ("room", "arm", 0.0, 2, 0, 0.0),
        ("room", "arm", 1.0, 2, 0, 0.0),
        ("room", "arm", 100.0, 2, 1, 0.5),
    ]
    for row in table.itertuples():
        interval = binomtest(row.commuted, row.n).proportion_ci(0.95, "wilson")
        assert (row.ci_low, row.ci_high) == pytest.approx((interval.low, interval.high), abs=1e-9)
    by_dof = estimate_scp(EXPERIMENTS, ["dof"], [0.0])
    assert by_dof[["dof", "n", "commuted"]].to_numpy().tolist() == [["head", 6, 3], ["arm", 2, 0]]


def test_higher_confidence_gives_wider_intervals():
    narrow = estimate_scp(EXPERIMENTS, ["world", "dof"], [0.0], 0.5)
    wide = estimate_scp(EXPERIMENTS, ["world", "dof"], [0.0], 0.99)
    assert (wide["ci_high"] - wide["ci_low"] > narrow["ci_high"] - narrow["ci_low"]).all()


def test_the_threshold_itself_commutes():
    distances = np.array([0.0, 1.0, 1.0 + 1e-12, 1e-300])
    assert commutes(distances).tolist() == [True, False, False, False]
    assert commutes(distances, 1.0).tolist() == [True, True, False, True]


@given(
    st.lists(st.floats(0, 300), min_size=1, max_size=40),
    st.lists(st.floats(0, 300), min_size=2, max_size=5),
)
def test_scp_grows_with_the_threshold_and_ignores_the_order_of_rows(distances, thresholds):
    frame = pd.DataFrame({"dof": "head", "distance": distances})
    table = estimate_scp(frame, ["dof"], sorted(thresholds))
    assert (table["scp"].diff().dropna() >= 0).all()
    assert (table["n"] == len(distances)).all()
    assert (table["ci_low"] <= table["scp"]).all() and (table["scp"] <= table["ci_high"]).all()
    shuffled = estimate_scp(frame.sample(frac=1, random_state=1), ["dof"], sorted(thresholds))
    pd.testing.assert_frame_equal(table, shuffled)

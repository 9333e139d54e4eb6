"""Comparison of the tables of two runs."""

from __future__ import annotations

import pandas as pd
import pytest

from sensory_commutativity.errors import UserError
from sensory_commutativity.runs.compare import compare_runs, compare_tables
from sensory_commutativity.studies.registry import find_table
from tests.runs.examples import TABLE, scp_table, write_scp

KEY = [column.name for column in find_table("flatland_scp").columns if column.key]
A = scp_table([0.5, 0.6, 0.9])


def status(a: pd.DataFrame, b: pd.DataFrame, key: list[str] = KEY) -> str:
    return compare_tables("t", a, b, key).status


def test_equal_tables():
    assert status(A, A) == "identical"
    assert status(A, scp_table([0.5, 0.6, 0.9 + 1e-12])) == "rounding"
    shuffled = A.sample(frac=1, random_state=1).reset_index(drop=True)
    assert status(A, shuffled) == "rounding"  # the same rows in another order


def test_intervals_decide_whether_values_differ_by_chance():
    within = compare_tables("t", A, scp_table([0.5, 0.65, 0.9]), KEY)
    assert within[1:6] == ("within", 3, 1, 3, 0)
    assert within.is_by_chance
    beyond = compare_tables("t", A, scp_table([0.5, 0.65, 0.7]), KEY)
    assert beyond[1:6] == ("beyond", 3, 2, 3, 1)
    assert beyond.largest_difference == "scp 0.9 and 0.7 at furnished, polyphemus, 50, dof-2, 0"
    assert not beyond.is_by_chance
    text = pd.DataFrame({"claim": ["a", "b"], "holds": [True, False]})
    differs = compare_tables("t", text, text.assign(holds=True), ["claim"])
    assert differs[1:4] == ("differs", 2, 1) and differs.is_by_chance
    assert differs.largest_difference == "holds False and True at b"


def test_missing_rows_are_counted():
    fewer = compare_tables("t", A, scp_table([0.5, 0.65]), KEY)
    assert fewer.status == "rows" and not fewer.is_by_chance
    assert fewer.largest_difference.startswith("1 rows only in A, 0 only in B; scp 0.6 and 0.65")


def test_rows_are_matched_by_the_key_and_not_by_the_columns_that_happen_to_differ():
    a = pd.DataFrame({"dof": ["x", "y"], "length": [5, 10], "scp": [0.1, 0.2]})
    b = pd.DataFrame({"dof": ["x", "y"], "length": [5, 20], "scp": [0.1, 0.2]})
    assert compare_tables("t", a, b, ["dof", "length"])[1:3] == ("rows", 1)
    assert compare_tables("t", a, b, ["dof"])[1:4] == ("differs", 2, 1)
    assert compare_tables("t", a, b)[1:4] == ("differs", 2, 1)  # the shortest leading columns


def test_rows_without_a_key_cannot_be_matched():
    a = pd.DataFrame({"scp": [0.1, 0.1]})
    b = pd.DataFrame({"scp": [0.2, 0.2]})
    assert compare_tables("t", a, b) == ("t", "rows", 0, 0, 0, 0, "the rows cannot be matched")


def test_runs_are_compared_table_by_table(tmp_path, default_config):
    for run, values in (("a", [0.5, 0.6]), ("b", [0.5, 0.62]), ("c", [0.5, 0.9])):
        write_scp(tmp_path / run / TABLE, values, default_config)
    navigation = "navigation_scp"
    write_scp(tmp_path / "c/tables/navigation_scp.parquet", [0.1], default_config, navigation)
    a, b, c = (tmp_path / run for run in "abc")
    assert [table[:2] for table in compare_runs(a, b)] == [("flatland_scp", "within")]
    assert [table[:2] for table in compare_runs(a / "tables", c)] == [
        ("flatland_scp", "beyond"),
        ("navigation_scp", "only in B"),
    ]
    assert compare_runs(c, a)[1].status == "only in A"
    (b / TABLE).write_text("x")
    (difference,) = compare_runs(a, b)
    assert difference.status == "unreadable" and not difference.is_by_chance
    assert "not a readable Parquet file" in difference.largest_difference


def test_a_folder_without_tables_is_rejected(tmp_path):
    with pytest.raises(UserError, match="holds no tables; give a folder like results/default"):
        compare_runs(tmp_path, tmp_path)

"""runs/: where files come from, and how two runs differ."""

from __future__ import annotations

import json

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from sensory_commutativity.cli import main
from sensory_commutativity.runs.compare import compare_runs, compare_tables
from sensory_commutativity.runs.origin import OriginError, origin_of
from sensory_commutativity.storage.arrays import write_arrays
from sensory_commutativity.storage.checkpoints import save_state
from sensory_commutativity.storage.provenance import provenance
from sensory_commutativity.storage.tables import write_table
from sensory_commutativity.studies.plotting import Film, save


def scp(values, n: int = 100, width: float = 0.05) -> pd.DataFrame:
    """A table flatland_scp with these values."""
    rows = [
        ("furnished", "polyphemus", 50, f"dof-{i}", 0.0, n, round(v * n), v, v - width, v + width)
        for i, v in enumerate(values)
    ]
    return pd.DataFrame(
        rows,
        columns=[
            "world",
            "agent",
            "length",
            "dof",
            "threshold",
            "n",
            "commuted",
            "scp",
            "ci_low",
            "ci_high",
        ],
    )


@pytest.fixture(scope="module")
def files(tmp_path_factory, default_config):
    """A file of every kind."""
    folder = tmp_path_factory.mktemp("files")
    write_table("flatland_scp", scp([0.5]), folder / "flatland_scp.parquet", default_config)
    write_arrays(folder / "arrays.h5", "pairs", {"a": np.zeros(3)}, provenance(default_config))
    save_state(folder / "a.policy", {"about": provenance(default_config)})
    figure, axes = plt.subplots()
    axes.plot([0, 1])
    with plt.rc_context():
        film = Film(5, default_config)
        with film.saving(figure, str(folder / "a.gif"), dpi=50):
            film.grab_frame()
            axes.plot([1, 0])
            film.grab_frame()
        save(figure, folder / "a.png", default_config)
    return folder


@pytest.mark.parametrize(
    "name", ["flatland_scp.parquet", "arrays.h5", "a.policy", "a.png", "a.pdf", "a.gif"]
)
def test_every_kind_of_file_says_where_it_comes_from(files, name, default_config):
    found = origin_of(files / name)
    assert {key: found[key] for key in provenance(default_config)} == provenance(default_config)
    said = CliRunner().invoke(main, ["provenance", str(files / name)])
    assert (
        said.exit_code == 0 and default_config.digest() in said.output and "numpy " in said.output
    )
    assert (
        json.loads(CliRunner().invoke(main, ["provenance", "--json", str(files / name)]).output)
        == found
    )


def test_a_file_that_does_not_say_is_told(files, tmp_path):
    (tmp_path / "a.txt").write_text("x")
    (tmp_path / "a.parquet").write_text("x")
    pd.DataFrame({"a": [1]}).to_parquet(tmp_path / "b.parquet")
    for name, message in (
        ("none.png", "there is no such file"), ("a.txt", "do not say"), ("a.parquet", "cannot be read"), ("b.parquet", "does not say"),
    ):  # fmt: skip
        with pytest.raises(OriginError, match=message):
            origin_of(tmp_path / name)


def test_tables_are_compared_by_hand():
    a = scp([0.5, 0.6, 0.9])
    assert compare_tables("t", a, a).verdict == "identical"
    assert compare_tables("t", a, scp([0.5, 0.6, 0.9 + 1e-12])).verdict == "rounding"
    within = compare_tables("t", a, scp([0.5, 0.65, 0.9]))
    assert (within.verdict, within.rows, within.differing, within.intervals, within.beyond) == (
        "within",
        3,
        1,
        3,
        0,
    )
    beyond = compare_tables("t", a, scp([0.5, 0.65, 0.7]))
    assert (beyond.verdict, beyond.differing, beyond.beyond) == ("beyond", 2, 1)
    assert beyond.most.endswith("furnished, polyphemus, 50, dof-2")
    shuffled = a.sample(frac=1, random_state=1).reset_index(drop=True)
    assert compare_tables("t", a, shuffled).verdict == "rounding"  # the same rows in another order
    fewer = compare_tables("t", a, a.iloc[:2])
    assert fewer.verdict == "rows" and fewer.most.startswith("1 rows only in A")
    words = pd.DataFrame({"claim": ["a", "b"], "holds": [True, False]})
    assert compare_tables("t", words, words.assign(holds=True)).verdict == "differs"


def test_two_runs_are_compared(tmp_path, default_config):
    for run, values in (("a", [0.5, 0.6]), ("b", [0.5, 0.62]), ("c", [0.5, 0.9])):
        write_table(
            "flatland_scp",
            scp(values),
            tmp_path / run / "tables" / "flatland_scp.parquet",
            default_config,
        )
    write_table(
        "navigation_scp",
        scp([0.1]),
        tmp_path / "c" / "tables" / "navigation_scp.parquet",
        default_config,
    )
    assert [one.verdict for one in compare_runs(tmp_path / "a", tmp_path / "b")] == ["within"]
    assert [one.verdict for one in compare_runs(tmp_path / "a", tmp_path / "c")] == [
        "beyond",
        "only in B",
    ]
    said = CliRunner().invoke(main, ["compare", str(tmp_path / "a"), str(tmp_path / "b")])
    assert (
        said.exit_code == 0
        and "within their intervals; 1 of 2 rows, 0 of 2 intervals apart" in said.output
    )
    said = CliRunner().invoke(main, ["compare", str(tmp_path / "a"), str(tmp_path / "c")])
    assert said.exit_code == 1 and "BEYOND" in said.output and "only in B" in said.output
    (tmp_path / "b" / "tables" / "flatland_scp.parquet").write_text("x")
    assert [one.verdict for one in compare_runs(tmp_path / "a", tmp_path / "b")] == ["unreadable"]


def test_a_folder_without_tables_is_told(tmp_path, default_config):
    assert "holds no tables" in str(
        CliRunner().invoke(main, ["compare", str(tmp_path), str(tmp_path)]).exception
    )

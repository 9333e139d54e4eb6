"""stages/: what each table holds, from experiments that were played or made up."""

from __future__ import annotations

from functools import partial
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest

from sensory_commutativity.scp.distances import mean_squared_error
from sensory_commutativity.scp.experiment import commutation_experiment, sc_experiment
from sensory_commutativity.scp.sequences import sample_sequence
from sensory_commutativity.seeding import generator, seed_for
from sensory_commutativity.statistics.paired import holm
from sensory_commutativity.statistics.proportions import wilson_interval
from sensory_commutativity.statistics.ranks import rank_correlation
from sensory_commutativity.statistics.trends import cochran_armitage, mantel_haenszel
from sensory_commutativity.storage.tables import TABLES, read_table, write_table
from sensory_commutativity.studies.flatland.builders import flatland_world
from sensory_commutativity.studies.flatland.config import Run
from sensory_commutativity.studies.flatland.tables import flatland_baselines
from sensory_commutativity.studies.flatland.tables.flatland_baselines import (
    gather_baselines,
    write_alternatives,
    write_baseline,
)
from sensory_commutativity.studies.flatland.tables.flatland_commutation import (
    run_commutation,
    write_commutation,
    write_commutation_experiments,
)
from sensory_commutativity.studies.flatland.tables.flatland_comparisons import (
    compare_dofs,
    write_comparisons,
)
from sensory_commutativity.studies.flatland.tables.flatland_experiments import (
    part_bounds,
    run_experiments,
    write_experiments,
)
from sensory_commutativity.studies.flatland.tables.flatland_scp import (
    gather_experiments,
    write_scp,
    write_sensitivity,
)
from sensory_commutativity.studies.flatland.tables.flatland_trends import (
    ARM_LENGTH,
    OBJECTS,
    find_trends,
    write_trends,
)
from sensory_commutativity.studies.paper.tables import paper_comparison
from tests.helpers import DOFS, update_flatland

FURNISHED = Run("furnished", "polyphemus", 6, 6)


def columns(name: str) -> list[str]:
    return [column.name for column in TABLES[name]]


# ---- SC-experiments --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def experiments(tiny_config) -> pd.DataFrame:
    return run_experiments(tiny_config, FURNISHED, 0, 6)


def test_experiments_have_a_row_each(experiments):
    assert experiments.columns.tolist() == columns("flatland_experiments")
    assert len(experiments) == 6 * 8
    assert experiments["dof"].tolist() == DOFS * 6
    assert experiments["experiment"].tolist() == np.repeat(np.arange(6), 8).tolist()
    assert (
        (experiments["length"] == 6).all()
        and (experiments["world"] == "furnished").all()
        and (experiments["agent"] == "polyphemus").all()
    )
    assert experiments.groupby("experiment")["seed"].nunique().eq(1).all()
    assert experiments["seed"].nunique() == 6
    assert (experiments["distance"] >= 0).all()


@pytest.mark.parametrize("cuts", [[0, 6], [0, 1, 6], [0, 3, 4, 6], [0, 1, 2, 3, 4, 5, 6]], ids=str)
def test_experiments_do_not_depend_on_how_they_are_cut(cuts, experiments, tiny_config):
    drawables = [run_experiments(tiny_config, FURNISHED, low, high) for low, high in pairwise(cuts)]
    pd.testing.assert_frame_equal(pd.concat(drawables, ignore_index=True), experiments)
    backwards = [
        run_experiments(tiny_config, FURNISHED, low, high)
        for low, high in reversed(list(pairwise(cuts)))
    ]
    pd.testing.assert_frame_equal(pd.concat(backwards[::-1], ignore_index=True), experiments)


def test_an_experiment_is_what_definition_3_says(experiments, tiny_config):
    """Experiment 4 of the left shoulder, played step by step."""
    row = experiments[
        (experiments["experiment"] == 4) & (experiments["dof"] == "left-shoulder")
    ].iloc[0]
    seed = seed_for(tiny_config.seed, "flatland", "furnished", "polyphemus", 4)
    assert row["seed"] == seed
    world = flatland_world(tiny_config.flatland, "furnished", "polyphemus")
    world.reset(generator(seed, "situation"))
    rng = generator(seed, "sequence", "left-shoulder")
    sequence = sample_sequence(rng, 6, DOFS.index("left-shoulder"), 8)
    assert row["distance"] == mean_squared_error(
        *sc_experiment(world, world.snapshot(), sequence, rng, 3)
    )


def test_other_worlds_agents_and_seeds_are_other_experiments(experiments, tiny_config):
    for config, run in [
        (tiny_config, FURNISHED._replace(world="things-8")),
        (tiny_config, FURNISHED._replace(agent="slow-base")),
        (tiny_config.model_copy(update={"seed": 1}), FURNISHED),
    ]:
        assert not set(run_experiments(config, run, 0, 2)["seed"]) & set(experiments["seed"])


def test_lengths_share_their_start_situations(experiments, tiny_config):
    longer = run_experiments(tiny_config, FURNISHED._replace(length=12), 0, 6)
    assert longer["seed"].tolist() == experiments["seed"].tolist()


def test_adding_worlds_and_agents_changes_no_result(experiments, tiny_config):
    config = update_flatland(
        tiny_config, worlds={"attic": {"objects": 2}}, agents={"giraffe": {"arm_length": 100.0}}
    )
    pd.testing.assert_frame_equal(run_experiments(config, FURNISHED, 0, 6), experiments)


@pytest.mark.parametrize(
    ("per_job", "n", "bounds"),
    [(3, 8, [(0, 3), (3, 6), (6, 8)]), (4, 8, [(0, 4), (4, 8)]), (100, 8, [(0, 8)])],
)
def test_part_bounds(per_job, n, bounds):
    assert [part_bounds(per_job, n, part) for part in range(len(bounds))] == bounds


def test_a_killed_part_resumes(experiments, tiny_config, tmp_path, monkeypatch):
    """Killed in its second batch; the first is not played again."""
    out, config, asked = (
        tmp_path / "part.parquet",
        update_flatland(tiny_config, experiments_per_job=250),
        [],
    )
    run = Run("things-0", "polyphemus", 1, 210)

    def play(config, run, start, stop, dies_at):
        asked.append(start)
        if start >= dies_at:
            raise KeyboardInterrupt
        rows = [(*run[:3], "head", i, i, 0.0) for i in range(start, stop)]
        return pd.DataFrame(rows, columns=columns("flatland_experiments"))

    where = "sensory_commutativity.studies.flatland.tables.flatland_experiments.run_experiments"
    monkeypatch.setattr(where, partial(play, dies_at=100))
    with pytest.raises(KeyboardInterrupt):
        write_experiments(config, run, 0, out)
    assert not out.exists()
    monkeypatch.setattr(where, partial(play, dies_at=1000))
    write_experiments(config, run, 0, out)
    assert asked == [0, 100, 100, 200]
    assert read_table("flatland_experiments", out)["experiment"].tolist() == list(range(210))
    assert [p.name for p in tmp_path.iterdir()] == ["part.parquet"]


def test_gathering_keeps_everything_in_order(experiments, tiny_config, tmp_path):
    for name, rows in (("a", experiments[:16]), ("b", experiments[16:])):
        write_table("flatland_experiments", rows, tmp_path / f"{name}.parquet", tiny_config)
    gather_experiments(
        [tmp_path / "a.parquet", tmp_path / "b.parquet"], tmp_path / "all.parquet", tiny_config
    )
    pd.testing.assert_frame_equal(
        read_table("flatland_experiments", tmp_path / "all.parquet"), experiments
    )


# ---- SCP -------------------------------------------------------------------------------------------------------------------


def made_up(
    distances: dict[str, list[float]], world="furnished", agent="polyphemus", length=4
) -> pd.DataFrame:
    """A table flatland_experiments with these distances for each degree of freedom."""
    rows = [
        (world, agent, length, dof, i, i, d)
        for dof, values in distances.items()
        for i, d in enumerate(values)
    ]
    return pd.DataFrame(rows, columns=columns("flatland_experiments"))


def test_scp_takes_the_main_length_of_every_agent_in_every_world(tiny_config, tmp_path):
    frame = pd.concat(
        [
            made_up({"head": [0, 0, 5]}),
            made_up({"head": [0, 200, 2000]}, world="things-4"),
            made_up({"head": [9, 9]}, length=2),
        ],
        ignore_index=True,
    )
    write_table("flatland_experiments", frame, tmp_path / "e.parquet", tiny_config)
    write_scp(tmp_path / "e.parquet", tmp_path / "scp.parquet", tiny_config)
    scp = read_table("flatland_scp", tmp_path / "scp.parquet")
    assert scp[["world", "threshold", "n", "commuted"]].to_numpy().tolist() == [
        ["furnished", 0.0, 3, 2],
        ["furnished", 1.0, 3, 2],
        ["furnished", 10.0, 3, 3],
        ["furnished", 100.0, 3, 3],
        ["furnished", 1000.0, 3, 3],
        ["things-4", 0.0, 3, 1],
        ["things-4", 1.0, 3, 1],
        ["things-4", 10.0, 3, 1],
        ["things-4", 100.0, 3, 1],
        ["things-4", 1000.0, 3, 2],
    ]
    assert scp["scp"].tolist() == (scp["commuted"] / scp["n"]).tolist()


def test_sensitivity_compares_lengths_on_the_same_situations(tiny_config, tmp_path):
    frame = pd.concat(
        [
            made_up(
                {"head": [0, 0, 0, 9, 9]}
            ),  # the main length has five experiments, the others three
            made_up({"head": [0, 0, 9]}, length=6),
            made_up({"head": [0, 9, 9]}, length=2),
            made_up({"head": [7, 7, 7]}, world="things-4"),
        ],
        ignore_index=True,
    )
    write_table("flatland_experiments", frame, tmp_path / "e.parquet", tiny_config)
    write_sensitivity(tmp_path / "e.parquet", tmp_path / "s.parquet", tiny_config)
    table = read_table("flatland_sensitivity", tmp_path / "s.parquet")
    table = table[table["threshold"] == 0]
    assert table[["world", "length", "n", "commuted"]].to_numpy().tolist() == [
        ["furnished", 2, 3, 1],
        ["furnished", 4, 3, 3],
        ["furnished", 6, 3, 2],
    ]


# ---- comparisons -----------------------------------------------------------------------------------------------------------


def test_comparisons_by_hand():
    """a commutes 8 times of 8, b 4 times, c in the situations in which b does not."""
    table = compare_dofs(
        made_up({"a": [0] * 8, "b": [0, 0, 0, 0, 1, 1, 1, 1], "c": [1, 1, 1, 1, 0, 0, 0, 0]})
    )
    assert table[["dof_a", "dof_b", "n", "only_a", "only_b", "difference"]].to_numpy().tolist() == [
        ["a", "b", 8, 4, 0, 0.5],
        ["a", "c", 8, 4, 0, 0.5],
        ["b", "c", 8, 4, 4, 0.0],
    ]
    assert table["p"].tolist() == pytest.approx([2 / 16, 2 / 16, 1.0])
    assert table["p_adjusted"].tolist() == pytest.approx([3 / 8, 3 / 8, 1.0])
    assert (table["ci_low"] < table["difference"]).all() and (
        table["difference"] < table["ci_high"]
    ).all()


def test_comparisons_pair_by_experiment_not_by_row():
    frame = made_up({"a": [0, 1, 0, 1], "b": [0, 1, 0, 1]})
    shuffled = pd.concat([frame[:4], frame[4:].iloc[::-1]])
    assert compare_dofs(shuffled)[["only_a", "only_b"]].to_numpy().tolist() == [[0, 0]]


def test_comparisons_heed_the_threshold():
    frame = made_up({"a": [0, 5, 5], "b": [0, 0, 50]})
    assert compare_dofs(frame, 10.0)[["only_a", "only_b"]].to_numpy().tolist() == [[1, 0]]
    assert compare_dofs(frame)[["only_a", "only_b"]].to_numpy().tolist() == [[0, 1]]


def test_comparisons_want_the_same_situations():
    with pytest.raises(ValueError, match="same experiments"):
        compare_dofs(made_up({"a": [0, 0, 0], "b": [0, 0]}))


def test_comparisons_are_corrected_within_each_agent_and_world(tiny_config, tmp_path):
    few = made_up({"a": [0] * 10, "b": [1] * 10})
    many = made_up({"a": [0] * 10, "b": [1] * 10, "c": [0] * 10}, agent="slow-base")
    frame = pd.concat(
        [few, many, made_up({"a": [1] * 10, "b": [1] * 10}, length=2)], ignore_index=True
    )
    write_table("flatland_experiments", frame, tmp_path / "e.parquet", tiny_config)
    write_comparisons(tmp_path / "e.parquet", tmp_path / "c.parquet", tiny_config)
    table = read_table("flatland_comparisons", tmp_path / "c.parquet")
    assert table["agent"].tolist() == ["polyphemus"] + ["slow-base"] * 3
    p = 2 / 2**10
    assert table["p_adjusted"].tolist() == pytest.approx([p, 3 * p, 1.0, 3 * p])


# ---- trends ----------------------------------------------------------------------------------------------------------------

WORLDS = ["things-0", "things-4", "things-8", "things-12"]


def scp_table(commuted: dict[tuple[str, str], list[int]], n: int = 100) -> pd.DataFrame:
    """A table flatland_scp: (agent, dof) -> counts in the worlds of the combinations."""
    rows = [
        (world, agent, 4, dof, 0.0, n, k, k / n, 0.0, 1.0)
        for (agent, dof), counts in commuted.items()
        for world, k in zip(WORLDS, counts, strict=True)
    ]
    return pd.DataFrame(rows, columns=columns("flatland_scp"))


COUNTS = {
    ("polyphemus", "left-elbow"): [95, 90, 85, 80],
    ("long-arms", "left-elbow"): [90, 80, 70, 60],
    ("polyphemus", "head"): [100, 100, 100, 100],
    ("long-arms", "head"): [100, 100, 100, 100],
}


def test_trends_by_hand(tiny_config):
    table = find_trends(scp_table(COUNTS), tiny_config).set_index(["trend", "stratum", "dof"])
    assert len(table) == 2 * (2 + 1)
    elbow = table.loc[(OBJECTS, "polyphemus", "left-elbow")]
    assert elbow["effect"] == pytest.approx(-0.05 / 4)  # five percent less with every four things
    expected = cochran_armitage([95, 90, 85, 80], [100] * 4, [0, 4, 8, 12])
    assert (elbow["statistic"], elbow["p"]) == pytest.approx((expected.z, expected.p))
    longer = table.loc[(ARM_LENGTH, "all worlds", "left-elbow")]
    assert longer["effect"] == pytest.approx(np.mean([-0.05, -0.10, -0.15, -0.20]))
    arms = mantel_haenszel([90, 80, 70, 60], [100] * 4, [95, 90, 85, 80], [100] * 4)
    assert (longer["statistic"], longer["p"]) == pytest.approx((arms.odds_ratio, arms.p))
    assert longer["statistic"] < 1
    assert (table.xs("head", level="dof")["p"] == 1).all()
    assert table["p_adjusted"].tolist() == pytest.approx(holm(table["p"].to_numpy()).tolist())


def test_trends_do_not_depend_on_the_order_of_rows(tiny_config):
    table = scp_table(COUNTS)
    expected = find_trends(table, tiny_config)
    swapped = pd.concat([group[::-1] for _, group in table.groupby("dof", sort=False)])
    columns_of_interest = ["trend", "stratum", "dof", "statistic", "effect", "p"]
    found = find_trends(swapped, tiny_config)
    pd.testing.assert_frame_equal(
        found[columns_of_interest].reset_index(drop=True),
        expected[columns_of_interest].reset_index(drop=True),
    )


def test_trends_leave_out_other_rows(tiny_config):
    table = scp_table(COUNTS)
    more = [
        table.assign(threshold=10.0, commuted=0, scp=0.0),
        table.assign(world="furnished", commuted=0, scp=0.0)[:1],
        table.assign(agent="slow-base", commuted=0, scp=0.0),
    ]
    pd.testing.assert_frame_equal(
        find_trends(pd.concat([table, *more]), tiny_config), find_trends(table, tiny_config)
    )


def test_trends_with_one_agent_compare_no_arms(tiny_config):
    config = update_flatland(tiny_config, combinations={"agents": ["polyphemus"]})
    table = find_trends(scp_table(COUNTS), config)
    assert set(table["trend"]) == {OBJECTS}


def test_trends_are_written(tiny_config, tmp_path):
    write_table("flatland_scp", scp_table(COUNTS), tmp_path / "scp.parquet", tiny_config)
    write_trends(tmp_path / "scp.parquet", tmp_path / "t.parquet", tiny_config)
    assert len(read_table("flatland_trends", tmp_path / "t.parquet")) == 6


def test_trends_where_one_agent_always_commutes_are_written(tiny_config, tmp_path):
    """The odds ratio is infinite then."""
    counts = {("polyphemus", "head"): [100] * 4, ("long-arms", "head"): [100, 99, 98, 97]}
    write_table("flatland_scp", scp_table(counts), tmp_path / "scp.parquet", tiny_config)
    write_trends(tmp_path / "scp.parquet", tmp_path / "t.parquet", tiny_config)
    counts = {("long-arms", "head"): [100] * 4, ("polyphemus", "head"): [100, 99, 98, 97]}
    write_table("flatland_scp", scp_table(counts), tmp_path / "scp.parquet", tiny_config)
    write_trends(tmp_path / "scp.parquet", tmp_path / "t.parquet", tiny_config)
    assert np.isinf(read_table("flatland_trends", tmp_path / "t.parquet")["statistic"]).sum() == 1


# ---- commutation -----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def commutation(tiny_config) -> pd.DataFrame:
    return run_commutation(tiny_config, "furnished", 0, 3)


def test_commutation_has_every_unordered_pair_once(commutation):
    assert commutation.columns.tolist() == columns("flatland_commutation_experiments")
    assert len(commutation) == 3 * 36
    pairs = [
        frozenset(pair) for pair in zip(commutation["dof_a"], commutation["dof_b"], strict=True)
    ]
    assert len(set(pairs)) == 36
    assert all(pairs.count(pair) == 3 for pair in set(pairs))


@pytest.mark.parametrize("cuts", [[0, 1, 3], [0, 2, 3], [0, 1, 2, 3]], ids=str)
def test_commutation_does_not_depend_on_how_it_is_cut(cuts, commutation, tiny_config):
    drawables = [
        run_commutation(tiny_config, "furnished", low, high) for low, high in pairwise(cuts)
    ]
    pd.testing.assert_frame_equal(pd.concat(drawables, ignore_index=True), commutation)


@pytest.mark.parametrize(("world", "rest_steps"), [("furnished", 3), ("settled", 5)])
def test_a_commutation_experiment_by_hand(world, rest_steps, tiny_config):
    frame = run_commutation(tiny_config, world, 2, 3)
    row = frame[(frame["dof_a"] == "base-longitudinal") & (frame["dof_b"] == "base-rotation")].iloc[
        0
    ]
    seed = seed_for(tiny_config.seed, "commutation", world, "polyphemus", 2)
    room = flatland_world(tiny_config.flatland, world, "polyphemus")
    room.reset(generator(seed, "situation"))
    h, g = (sample_sequence(generator(seed, "first", DOFS[k]), 4, k, 8) for k in (0, 1))
    assert row["seed"] == seed
    assert row["world"] == world
    assert row["distance"] == mean_squared_error(
        *commutation_experiment(room, room.snapshot(), h, g, rest_steps)
    )
    assert row["distance"] > 0  # ahead and turn, or turn and ahead


def test_a_dof_is_tried_against_another_sequence_of_its_own(tiny_config):
    """Against itself anything would commute. The base, in a small room: blocked in one order only, now and then."""
    config = update_flatland(
        tiny_config,
        sequence_length=60,
        worlds={"furnished": {"width": 320.0, "height": 320.0, "things": 4}},
        baselines=dict(transitions=120, training=60),
    )
    frame = run_commutation(config, "furnished", 0, 12)
    assert (
        frame[(frame["dof_a"] == "base-longitudinal") & (frame["dof_b"] == "base-longitudinal")][
            "distance"
        ]
        > 0
    ).any()


def test_commutation_table_by_hand(tiny_config, tmp_path):
    rows = [
        ("furnished", "head", "head", 0, 0, 0.0),
        ("furnished", "head", "left-elbow", 0, 0, 0.0),
        ("settled", "head", "left-elbow", 0, 0, 0.0),
        ("furnished", "head", "head", 1, 1, 0.0),
        ("furnished", "head", "left-elbow", 1, 1, 7.0),
        ("settled", "head", "left-elbow", 1, 1, 0.0),
    ]
    frame = pd.DataFrame(rows, columns=columns("flatland_commutation_experiments"))
    for name, part in (("a", frame[:3]), ("b", frame[3:])):
        write_table(
            "flatland_commutation_experiments", part, tmp_path / f"{name}.parquet", tiny_config
        )
    write_commutation(
        [tmp_path / "a.parquet", tmp_path / "b.parquet"], tmp_path / "c.parquet", tiny_config
    )
    table = read_table("flatland_commutation", tmp_path / "c.parquet")
    found = {
        tuple(row[:3]): tuple(row[3:])
        for row in table[["world", "dof_a", "dof_b", "n", "commuted", "probability"]]
        .to_numpy()
        .tolist()
    }
    assert found == {
        ("furnished", "head", "head"): (2, 2, 1.0),
        ("furnished", "head", "left-elbow"): (2, 1, 0.5),
        ("furnished", "left-elbow", "head"): (2, 1, 0.5),
        ("settled", "head", "left-elbow"): (2, 2, 1.0),
        ("settled", "left-elbow", "head"): (2, 2, 1.0),
    }
    low, high = wilson_interval(table["commuted"].to_numpy(), table["n"].to_numpy())
    assert np.allclose(table["ci_low"], low) and np.allclose(table["ci_high"], high)


def test_commutation_parts_are_all_experiments(tiny_config, commutation, tmp_path):
    assert tiny_config.flatland.commutation_per_job == 1
    parts = [tmp_path / f"{part}.parquet" for part in range(3)]
    for part, path in enumerate(parts):
        write_commutation_experiments(tiny_config, "furnished", part, path)
    frame = pd.concat(
        [read_table("flatland_commutation_experiments", path) for path in parts], ignore_index=True
    )
    pd.testing.assert_frame_equal(frame, commutation)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["0.parquet", "1.parquet", "2.parquet"]


# ---- alternatives ----------------------------------------------------------------------------------------------------------


def test_a_baseline_is_written(tiny_config, tmp_path):
    write_baseline(tiny_config, "head", tmp_path / "head.parquet")
    row = read_table("flatland_baselines", tmp_path / "head.parquet").iloc[0]
    assert row["dof"] == "head"
    assert row["n_transitions"] == 100 and row["n_test"] == 48
    assert np.isnan(row["excess_error"])  # not known before all are measured
    assert (
        row["naive_mse"] > 0
        and row["naive_se"] > 0
        and row["prediction_mse"] > 0
        and row["prediction_se"] > 0
    )
    first = (tmp_path / "head.parquet").read_bytes()
    write_baseline(tiny_config, "head", tmp_path / "head.parquet")
    assert (tmp_path / "head.parquet").read_bytes() == first


def baselines(errors: dict[str, tuple[float, float]]) -> pd.DataFrame:
    """dof -> (naive, predicted)."""
    rows = [
        (dof, naive, 0.1, predicted, 0.1, 0.0, 100, 20)
        for dof, (naive, predicted) in errors.items()
    ]
    return pd.DataFrame(rows, columns=columns("flatland_baselines"))


MEASURED = {dof: (float(k), 10.0 + (k * 3) % 8) for k, dof in enumerate(DOFS)}


def test_excess_errors_are_above_the_smallest(tiny_config, tmp_path):
    frame = baselines(MEASURED)
    paths = []
    for k in range(8):
        paths.append(tmp_path / f"{k}.parquet")
        write_table("flatland_baselines", frame[k : k + 1], paths[-1], tiny_config)
    gather_baselines(paths, tmp_path / "all.parquet", tiny_config)
    found = read_table("flatland_baselines", tmp_path / "all.parquet")
    assert found["dof"].tolist() == DOFS
    assert found["excess_error"].tolist() == [(k * 3) % 8 for k in range(8)]
    assert found["prediction_mse"].tolist() == frame["prediction_mse"].tolist()


def write_inputs(folder, tiny_config, scp: list[float]) -> None:
    frame = baselines(MEASURED)
    write_table(
        "flatland_baselines",
        frame.assign(excess_error=frame["prediction_mse"] - 10),
        folder / "b.parquet",
        tiny_config,
    )
    rows = [
        ("furnished", "polyphemus", 4, dof, 0.0, 100, round(100 * p), p, 0.0, 1.0)
        for dof, p in zip(DOFS, scp, strict=True)
    ]
    rows += [("furnished", "polyphemus", 4, dof, 10.0, 100, 0, 0.0, 0.0, 1.0) for dof in DOFS]
    rows += [("things-4", "polyphemus", 4, dof, 0.0, 100, 0, 0.0, 0.0, 1.0) for dof in DOFS]
    rows += [("furnished", "slow-base", 4, dof, 0.0, 100, 0, 0.0, 0.0, 1.0) for dof in DOFS]
    write_table(
        "flatland_scp",
        pd.DataFrame(rows, columns=columns("flatland_scp"))[::-1],
        folder / "scp.parquet",
        tiny_config,
    )


@pytest.fixture
def quick_ranks(monkeypatch):
    monkeypatch.setattr(
        flatland_baselines, "rank_correlation", partial(rank_correlation, permutations=99)
    )


def test_alternatives_are_correlated_with_one_minus_scp(tiny_config, tmp_path, quick_ranks):
    write_inputs(
        tmp_path, tiny_config, [1.0 - k / 10 for k in range(8)]
    )  # the naive change puts them in this very order
    write_alternatives(
        tmp_path / "b.parquet", tmp_path / "scp.parquet", tmp_path / "a.parquet", tiny_config
    )
    table = read_table("flatland_alternatives", tmp_path / "a.parquet").set_index("alternative")
    assert table.index.tolist() == ["naive change", "excess prediction error"]
    assert table.loc["naive change", ["n", "spearman", "kendall"]].tolist() == pytest.approx(
        [8, 1.0, 1.0]
    )
    assert table.loc["naive change", "p"] == 0.01
    assert table.loc["excess prediction error", "spearman"] == pytest.approx(
        1 - 6 * sum((k - (3 * k) % 8) ** 2 for k in range(8)) / (8 * 63)
    )


def test_alternatives_where_all_scps_are_equal_are_written(tiny_config, tmp_path, quick_ranks):
    """A tiny run may find every experiment to commute; there is no order then, and that is no reason to crash."""
    write_inputs(tmp_path, tiny_config, [1.0] * 8)
    write_alternatives(
        tmp_path / "b.parquet", tmp_path / "scp.parquet", tmp_path / "a.parquet", tiny_config
    )
    table = read_table("flatland_alternatives", tmp_path / "a.parquet")
    assert table["spearman"].isna().all()
    assert (table["p"] == 1).all()


# ---- the paper's claims ----------------------------------------------------------------------------------------------------


@pytest.fixture(autouse=True)
def without_robots_and_masks(monkeypatch):
    """Claims about them have tests of their own, beside those of their tables."""
    monkeypatch.setattr(paper_comparison, "apartment_claims", lambda tables, config: [])
    monkeypatch.setattr(paper_comparison, "mask_claims", lambda tables, config: [])
    others = [
        name for name in paper_comparison.COMPARED if name.startswith(("flatland", "navigation"))
    ]
    monkeypatch.setattr(paper_comparison, "COMPARED", others)


def as_the_paper_says(config) -> dict[str, pd.DataFrame]:
    """Tables in which every claim holds."""
    n, commuted = (
        10_000,
        dict(zip(DOFS, [7000, 7200, 10_000, 10_000, 8000, 9000, 8000, 9000], strict=True)),
    )
    low, high = wilson_interval(np.array(list(commuted.values())), np.full(8, n))
    rows = [
        ("furnished", "polyphemus", 4, dof, 0.0, n, k, k / n, *ends)
        for (dof, k), *ends in zip(commuted.items(), low, high, strict=True)
    ]
    rows += [
        ("things-0", agent, 4, dof, 0.0, 100, 99, 0.99, 0.95, 1.0)
        for agent in config.flatland.combinations.agents
        for dof in DOFS
    ]
    scp = pd.DataFrame(rows, columns=columns("flatland_scp"))
    pairs = []
    for i, a in enumerate(DOFS):
        for b in DOFS[i + 1 :]:
            difference = (commuted[a] - commuted[b]) / n
            p = 1.0 if difference == 0 else 1e-9
            pairs.append(
                (
                    "furnished",
                    "polyphemus",
                    a,
                    b,
                    "McNemar, exact",
                    n,
                    1,
                    1,
                    difference,
                    difference - 0.01,
                    difference + 0.01,
                    p,
                    p,
                )
            )
    arms = DOFS[4:]
    trends = [
        ("more objects", agent, dof, "x", -9.0, -0.01, 1e-9, 1e-9)
        for agent in config.flatland.combinations.agents
        for dof in arms
    ]
    trends += [("longer arms", "all worlds", dof, "x", 0.5, -0.1, 1e-9, 1e-9) for dof in arms]
    trends += [
        ("longer arms", "all worlds", "base-rotation", "x", 1.0, 0.1, 1.0, 1.0)
    ]  # the paper says nothing about it
    commutation = [
        (
            world,
            a,
            b,
            100,
            100 if {a, b} & {"head", "eyelid"} else 50,
            1.0 if {a, b} & {"head", "eyelid"} else 0.5,
            0.4,
            1.0,
        )
        for world in ("furnished", "settled")
        for a in DOFS
        for b in DOFS
    ]
    excess = dict(zip(DOFS, [10.0, 60, 50, 5, 20, 30, 20, 30], strict=True))
    naive = dict(zip(DOFS, [10.0, 60, 50, 5, 20, 30, 20, 30], strict=True))
    alternatives = [
        ("naive change", 8, 0.1, 0.1, 0.8),
        ("excess prediction error", 8, 0.2, 0.2, 0.7),
    ]
    summary = [
        (name, of, 4, 1.0, 0.5, 1.0, *[np.nan] * 6)
        for name in ("full", "truncated", "adapted")
        for of in ("reached", "solved")
    ]
    steps = ("steps_to_threshold",)
    pairs_of_spaces = [("truncated", "full"), ("adapted", "full"), ("truncated", "adapted")]
    learned = [
        (
            "paper",
            "truncated",
            "full",
            *steps,
            "Welch, against half of b",
            -9.0,
            5.0,
            1e-9,
            1e-9,
            np.nan,
            0.3,
            0.4,
            "ratio",
            0.35,
            "",
        ),
        (
            "paper",
            "truncated",
            "full",
            *steps,
            "Welch",
            -9.0,
            5.0,
            1e-9,
            1e-9,
            -9000.0,
            -10_000.0,
            -8000.0,
            "g",
            -3.0,
            "",
        ),
        (
            "paper",
            "adapted",
            "full",
            *steps,
            "Welch",
            -9.0,
            5.0,
            1e-9,
            1e-9,
            -5000.0,
            -6000.0,
            -4000.0,
            "g",
            -3.0,
            "",
        ),
        (
            "paper",
            "truncated",
            "adapted",
            *steps,
            "Welch",
            -9.0,
            5.0,
            1e-9,
            1e-9,
            -4000.0,
            -5000.0,
            -3000.0,
            "g",
            -3.0,
            "",
        ),
        *(
            (
                "paper",
                a,
                b,
                *steps,
                "log-rank",
                5.0,
                np.nan,
                1e-9,
                1e-9,
                *[np.nan] * 3,
                "",
                np.nan,
                "yes",
            )
            for a, b in pairs_of_spaces
        ),
    ]
    return {
        "navigation_summary": pd.DataFrame(summary, columns=columns("navigation_summary")),
        "navigation_comparisons": pd.DataFrame(learned, columns=columns("navigation_comparisons")),
        "flatland_scp": scp,
        "flatland_comparisons": pd.DataFrame(pairs, columns=columns("flatland_comparisons")),
        "flatland_trends": pd.DataFrame(trends, columns=columns("flatland_trends")),
        "flatland_commutation": pd.DataFrame(commutation, columns=columns("flatland_commutation")),
        "flatland_baselines": baselines(
            {dof: (naive[dof], 100 + excess[dof]) for dof in DOFS}
        ).assign(excess_error=list(excess.values())),
        "flatland_alternatives": pd.DataFrame(
            alternatives, columns=columns("flatland_alternatives")
        ),
    }


def failing(tables: dict[str, pd.DataFrame], config) -> set[str]:
    return {
        claim.claim
        for claim in paper_comparison.compare_with_paper(tables, config)
        if not claim.holds
    }


def test_all_claims_hold_where_all_is_as_the_paper_says(tiny_config):
    claims = paper_comparison.compare_with_paper(as_the_paper_says(tiny_config), tiny_config)
    assert [claim.claim for claim in claims if not claim.holds] == []
    assert len(claims) == len({claim.claim for claim in claims}) == 18
    for claim in claims:
        assert claim.section and claim.paper_value and claim.our_value
        assert (claim.ci_low is None) == (claim.ci_high is None)
        assert claim.ci_low is None or claim.ci_low <= claim.ci_high


TWICE = "SCP-truncated learns more than twice as fast as the full action space"


def where(frame: pd.DataFrame, **values) -> np.ndarray:
    return np.logical_and.reduce([frame[key] == value for key, value in values.items()])


@pytest.mark.parametrize(
    ("table", "rows", "change", "fails"),
    [
        ("flatland_scp", dict(world="furnished", dof="head"), dict(commuted=9999, scp=0.9999), "head and eyelid always commute"),
        ("flatland_scp", dict(world="furnished", dof="left-elbow"), dict(commuted=10_000, scp=1.0), "every other degree of freedom does not"),
        ("flatland_scp", dict(world="things-0", dof="left-elbow"), dict(scp=0.89), "in the closed empty room almost all is 1"),
        ("flatland_comparisons", dict(dof_a="base-rotation", dof_b="left-elbow"), dict(difference=0.2), "base below elbows"),
        ("flatland_comparisons", dict(dof_a="base-rotation", dof_b="left-elbow"), dict(p_adjusted=0.002), "base below elbows"),
        ("flatland_comparisons", dict(dof_a="left-shoulder", dof_b="right-elbow"), dict(difference=0.1), "shoulders below elbows"),
        ("flatland_comparisons", dict(dof_a="head", dof_b="left-elbow"), dict(difference=-0.1), "elbows below head and eyelid"),
        ("flatland_comparisons", dict(dof_a="left-elbow", dof_b="right-elbow"), dict(ci_low=0.01), "left and right commute equally"),
        (
            "flatland_trends", dict(trend="more objects", dof="left-elbow"), dict(effect=0.01),
            "SCP of shoulders and elbows falls with the number of objects",
        ),
        ("flatland_trends", dict(trend="longer arms", dof="left-elbow"), dict(p_adjusted=0.01), "SCP of shoulders and elbows falls with arm length"),
        (
            "flatland_commutation", dict(world="furnished", dof_a="head", dof_b="left-elbow"), dict(commuted=99, probability=0.99),
            "what displaces nothing commutes with everything, where things move by themselves",
        ),
        (
            "flatland_commutation", dict(world="settled", dof_a="left-elbow", dof_b="eyelid"), dict(commuted=99, probability=0.99),
            "what displaces nothing commutes with everything, where nothing moves by itself",
        ),
        (
            "flatland_baselines", dict(dof="head"), dict(naive_mse=15.0),
            "naive change: the head is among the two highest, though it displaces nothing",
        ),
        ("flatland_baselines", dict(dof="head"), dict(prediction_se=20.0), "head is harder to predict than base longitudinal"),
        ("flatland_baselines", dict(dof="head"), dict(excess_error=9.0), "head is harder to predict than base longitudinal"),
        ("flatland_baselines", dict(dof="base-rotation"), dict(excess_error=10.0), "base rotation is harder to predict than base longitudinal"),
        ("navigation_summary", dict(action_space="full", measure="reached"), dict(mean=0.25), "every action space can solve the task"),
        ("navigation_comparisons", dict(test="Welch, against half of b"), dict(ci_high=0.51), TWICE),
        ("navigation_comparisons", dict(test="Welch, against half of b"), dict(p_adjusted=0.06), TWICE),
        ("navigation_comparisons", dict(test="Welch, against half of b"), dict(statistic=9.0), TWICE),
        (
            "navigation_comparisons", dict(test="Welch", a="adapted"), dict(difference=100.0),
            "SCP-adapted learns faster than the full action space",
        ),
        ("navigation_comparisons", dict(test="log-rank", a="adapted"), dict(p_adjusted=0.06), "SCP-adapted learns faster than the full action space"),
        ("navigation_comparisons", dict(test="log-rank", b="adapted"), dict(statistic=-5.0), "SCP-adapted learns slower than SCP-truncated"),
        ("navigation_comparisons", dict(test="log-rank", a="truncated", b="full"), dict(p_adjusted=0.06), TWICE),
        ("navigation_comparisons", dict(test="Welch", b="adapted"), dict(p_adjusted=0.06), "SCP-adapted learns slower than SCP-truncated"),
    ],
)  # fmt: skip
def test_a_claim_fails_where_it_does_not_hold(table, rows, change, fails, tiny_config):
    tables = as_the_paper_says(tiny_config)
    chosen = where(tables[table], **rows)
    assert chosen.any()
    for column, value in change.items():
        tables[table].loc[chosen, column] = value
    assert failing(tables, tiny_config) == {fails}


def test_the_comparison_is_written(tiny_config, tmp_path):
    for name, frame in as_the_paper_says(tiny_config).items():
        write_table(name, frame, tmp_path / f"{name}.parquet", tiny_config)
    paper_comparison.write_paper_comparison(tmp_path, tmp_path / "out.parquet", tiny_config)
    table = read_table("paper_comparison", tmp_path / "out.parquet")
    assert len(table) == 18
    assert table["holds"].all()

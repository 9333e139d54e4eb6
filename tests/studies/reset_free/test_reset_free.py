"""The study without a reset at a tiny size: rows, shards, known answers, figures."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from sensory_commutativity.errors import ConfigError
from sensory_commutativity.scp.distances import mean_squared_error
from sensory_commutativity.scp.experiment import distances_per_dof
from sensory_commutativity.seeding import seed_for
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.declarations import Figure, Table
from sensory_commutativity.studies.flatland.builders import DOFS, flatland_world
from sensory_commutativity.studies.loading import load
from sensory_commutativity.studies.registry import configured, find
from sensory_commutativity.studies.reset_free.builders import reset_free
from sensory_commutativity.studies.reset_free.tables.reset_free_comparisons import test_trials
from sensory_commutativity.studies.reset_free.tables.reset_free_noise import calibrate
from sensory_commutativity.studies.reset_free.tables.reset_free_noise_order import (
    experiments_needed,
)
from sensory_commutativity.studies.reset_free.tables.reset_free_sequential import (
    bernoulli_case,
    fixed_number,
    simulate,
    wrong_runs,
)
from tests.helpers import DEFAULT, ROOT
from tests.studies.examples import overlay

test_trials.__test__ = False  # a function of the study

TINY = dict(
    flatland={
        "settled": {"world": "settled", "lives": 6},
        "furnished": {"world": "furnished", "lives": 6},
        "settled-life": {"world": "settled", "lives": 2, "trials": 2},
    },
    apartment={"fetch-rs": {"experiments": 2}},
    noise={"sensor": [4.0], "actuator": [0.1], "reset": [0.3], "experiments": 4},
    sequential={"largest": 200, "runs": 20},
    imagined={
        name: dict(sequences=20, experiments=3, length=4, rest_steps=2, epochs=1, members=1)
        for name in ("reacher", "pusher")
    },
)


@pytest.fixture(scope="module")
def config(default_config: Config) -> Config:
    few = dict(sequence_length=4, image_size=32, supersampling=1, thresholds=[0.0, 50.0])
    return overlay(
        default_config, reset_free=TINY, apartment={**few, "sensitivity": {"lengths": [2]}}
    )


def compute(name: str, config: Config, *inputs: pd.DataFrame) -> pd.DataFrame:
    """A table; with shards, all of them."""
    table = find(Table, name)
    if table.shards is None:
        return table(*inputs, config)
    frames = []
    for shard in table.shards.all(config):
        found = table(config, shard.run)
        batch = found if isinstance(found, pd.DataFrame) else found.compute(shard.start, shard.stop)
        frames.append(batch)
    return pd.concat(frames, ignore_index=True)


@pytest.fixture(scope="module")
def tables(config: Config) -> dict[str, pd.DataFrame]:
    """All tables of the study."""
    found: dict[str, pd.DataFrame] = {}
    for name, table in configured(Table, config).items():
        if name.startswith("reset_free_"):
            for one in (*table.input_names(config), name):
                if one not in found:
                    sources = find(Table, one).input_names(config)
                    found[one] = compute(one, config, *(found[source] for source in sources))
    return found


def test_every_table_has_its_columns_and_its_rows(config, tables) -> None:
    assert len(tables) == 13
    for name, frame in tables.items():
        table = find(Table, name)
        assert set(table.column_names) <= set(frame.columns), name
        assert len(frame) and not frame.duplicated(table.key).any(), name
        for column in table.columns:
            if not column.nullable:
                assert frame[column.name].notna().all(), (name, column.name)
        if table.expected is not None:
            expected = table.expected(config)
            sizes = frame.groupby(list(expected.columns)).size().to_dict()
            for key, n in expected.counts.items():
                assert sizes[key if len(key) > 1 else key[0]] == n or n is None, (name, key)


def test_columns_that_others_rely_on() -> None:
    assert find(Table, "reset_free_scp").column_names == [
        "world", "dof", "protocol", "threshold", "n", "scp", "ci_low", "ci_high", "relative",
        "relative_low", "relative_high",
    ]  # fmt: skip
    agreement = ["world", "dof", "n", "agreement", "spearman"]
    assert find(Table, "reset_free_agreement").column_names == agreement


def test_the_truth_is_the_experiment_with_a_restored_start(config, tables) -> None:
    trials = tables["reset_free_trials"]
    world = flatland_world(config.flatland, "settled", "polyphemus")
    for life in range(2):
        seed = seed_for(config.seed, "reset-free", "settled", life)
        expected = distances_per_dof(world, seed, config.flatland.sequence_length)
        rows = trials[(trials["world"] == "settled") & (trials["experiment"] == life)]
        assert rows.set_index("dof")["reset"].to_dict() == expected
    assert mean_squared_error(world.observe(), world.observe()) == 0


def test_how_trials_are_cut_changes_none(config, tables) -> None:
    table = find(Table, "reset_free_trials")
    for run in ("settled", "settled-life"):
        alone = table(config, run).compute(1, 2)
        trials = tables["reset_free_trials"]
        rows = trials[(trials["world"] == run) & (trials["life"] == 1)].reset_index(drop=True)
        pd.testing.assert_frame_equal(alone, rows)


def test_without_noise_both_protocols_are_those_without_noise(tables) -> None:
    experiments = tables["reset_free_noise_experiments"]
    clean = experiments[experiments["level"] == 0]
    by_kind = [
        group.set_index(["dof", "experiment"])["distance"]
        for (_, protocol), group in clean.groupby(["noise", "protocol"])
        if protocol == "reset"
    ]
    assert len(by_kind) == 3 and by_kind[0].equals(by_kind[1]) and by_kind[0].equals(by_kind[2])
    assert (clean.loc[clean["protocol"] == "reset", "control"] == 0).all()


def test_every_figure_is_drawn(config, tables) -> None:
    drawn = 0
    for name, figure in configured(Figure, config).items():
        if name.startswith("reset_free_"):
            chosen = {one: tables[one] for one in figure.input_names(config)}
            plt.close(figure.compute(chosen, config))
            assert (ROOT / "workflow" / "report" / f"{name}.rst").is_file()
            drawn += 1
    assert drawn == 5


# ---- known answers ------------------------------------------------------------------------------


def test_thresholds_come_from_other_experiments_than_those_that_they_decide() -> None:
    control = np.array([1.0, 10.0] * 10)  # even: 1, odd: 10
    distance = np.full(20, 5.0)
    assert calibrate(distance, control, 0.95).tolist() == [True, False] * 10
    rng = np.random.default_rng(0)
    distance, control = rng.exponential(size=(2, 4000))
    assert calibrate(distance, control, 0.95).mean() == pytest.approx(0.95, abs=0.015)


def test_steps_of_the_hierarchy_are_tested_relative_to_the_control() -> None:
    rng = np.random.default_rng(1)
    scp = dict(zip(DOFS, (0.5, 0.4, 1.0, 1.0, 0.6, 0.85, 0.6, 0.85), strict=True))
    n = 2000
    time = rng.random(n) < 0.7  # nothing moved meanwhile; the same for all
    rows = []
    for dof, p in scp.items():
        distance, control = np.where(time & (rng.random(n) < p), 0.0, 9.0), np.where(time, 0.0, 9.0)
        rows.append(
            pd.DataFrame(dict(dof=dof, experiment=np.arange(n), distance=distance, control=control))
        )
    found = test_trials(pd.concat(rows), 0.0)
    steps = found[found["test"] == "step of the hierarchy"]
    assert len(steps) == 12 and (steps["p_adjusted"] < 1e-6).all()
    assert (steps["lower_value"] < steps["higher_value"]).all()
    effects = found[found["test"] == "below its control"].set_index("lower")["p_adjusted"]
    assert (
        effects["head"] == effects["eyelid"] == 1
        and (effects.drop(["head", "eyelid"]) < 0.01).all()
    )


def test_experiments_needed_rise_as_differences_shrink() -> None:
    rng = np.random.default_rng(2)

    def needed(**scp: float) -> float:
        values = [scp.get(dof.replace("-", "_"), 0.5) for dof in DOFS]
        return experiments_needed(pd.DataFrame(rng.random((4000, 8)) < values, columns=DOFS))

    far = needed(head=1.0, eyelid=1.0, left_elbow=0.8, right_elbow=0.8)
    near = needed(head=1.0, eyelid=1.0, left_elbow=0.6, right_elbow=0.6)
    assert 10 < far < near < 4000
    assert needed(head=0.1) == float("inf")


def test_runs_are_wrong_seldom_and_a_fixed_number_is_larger(config) -> None:
    settings = reset_free(config).sequential.model_copy(update=dict(runs=200, largest=3000))
    case = bernoulli_case("two steps", np.array([0.6, 0.8, 1.0, 1.0]))
    rng = np.random.default_rng(3)
    found = simulate(case, settings, rng)
    wrong = wrong_runs(found.relations, found.pairs, case.scp, settings.margin)
    assert wrong.mean() <= settings.alpha and (found.relations != 0).all()
    fixed = fixed_number(case, settings, 0.9, rng)
    assert found.units.mean() < fixed < 10 * settings.largest


# ---- configuration ------------------------------------------------------------------------------


def test_the_section_can_be_left_out() -> None:
    paper = load(DEFAULT, ROOT / "config" / "paper.yaml")
    with pytest.raises(ConfigError, match="reset_free is null"):
        reset_free(paper)
    assert not [name for name in configured(Table, paper) if name.startswith("reset_free")]
    assert "reset_free_scp" in configured(Table, load(DEFAULT))


def test_the_paper_sizes_are_those_of_the_default_profile_and_larger() -> None:
    small, large = (
        reset_free(load(DEFAULT, *files)) for files in ((), (ROOT / "config/reset-free.yaml",))
    )
    for run, settings in small.flatland.items():
        assert large.flatland[run].experiments > settings.experiments
        assert large.flatland[run].world == settings.world


@pytest.mark.parametrize(
    ("section", "message"),
    [
        (dict(agent="nobody"), "reset_free.agent names 'nobody'"),
        (dict(noise={"world": "nowhere"}), "names 'nowhere', which flatland.worlds"),
        (dict(flatland={"x": {"world": "nowhere", "lives": 3}}), "names 'nowhere'"),
        (dict(apartment={"fetch-rs": {"scene": "nowhere"}}), "names 'nowhere'"),
        (dict(apartment={"settled": {"experiments": 3}}), "both have a key 'settled'"),
        (dict(thresholds=[1.0]), "must hold 0.0"),
    ],
)
def test_wrong_names_are_refused(default_config, section, message) -> None:
    with pytest.raises(ConfigError, match=message):
        overlay(default_config, reset_free=section)

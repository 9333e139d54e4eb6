"""Declarations fit together, with the workflow's rules and captions, and with the configuration."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator

import pyarrow as pa
import pytest

from sensory_commutativity.errors import UserError
from sensory_commutativity.storage.columns import FLOAT, INT
from sensory_commutativity.studies import registry
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.declarations import (
    Animation,
    Arrays,
    Figure,
    Model,
    Product,
    Shard,
    Shards,
    Table,
)
from sensory_commutativity.studies.registry import (
    KINDS,
    declarations,
    find_input,
    input_shards,
    settings_digest,
)
from tests.helpers import ROOT, update_flatland
from tests.studies.examples import overlay

TABLES = declarations(Table)
PRODUCTS = {f"{KINDS[kind]} {name}": p for kind in KINDS for name, p in declarations(kind).items()}
"""Kind and name -> declaration; a figure may have the name of its table."""


def jobs(product: Product, config: Config) -> list[Shard | None]:
    """What is computed by one job each: the shards, or all of it."""
    return list(product.shards.all(config)) if product.shards else [None]


# ---- declarations -----------------------------------------------------------------------------


def test_files_are_distinct_and_every_product_has_a_title(default_config):
    files = []
    for label, product in PRODUCTS.items():
        assert product.title and "\n" not in product.title, label
        assert len(product.title) <= 80, label  # a line of --list
        whole = not isinstance(product, Model) and (
            isinstance(product, Table | Figure) or product.shards is None
        )
        shards = list(product.shards.all(default_config)) if product.shards else []
        files += [product.file(shard) for shard in [*shards, *([None] if whole else [])]]
    assert len(set(files)) == len(files) > 100
    assert set(registry.table_names()) == set(declarations(Table, optional=True))


def test_inputs_exist_and_their_file_names_are_distinct(default_config, small_config):
    for label, product in PRODUCTS.items():
        for config in (default_config, small_config):
            for job in jobs(product, config):
                run = job.run if job else None
                for specification in product.input_names(config, run):
                    source, source_run, _ = find_input(specification)
                    assert not isinstance(source, Figure | Animation), (label, specification)
                    assert source_run is None or source_run in source.shards.runs(config), label
                found = input_shards(product, config, job)
                assert all(shards for _, shards in found), (label, job)
                names = [source.file(one).name for source, shards in found for one in shards]
                assert len(set(names)) == len(names), (label, job)


def test_functions_take_the_inputs_the_configuration_and_the_run(default_config):
    for label, product in PRODUCTS.items():
        shard = next((job for job in jobs(product, default_config) if job), None)
        values = [None] * len(product.input_names(default_config, shard.run if shard else None))
        if isinstance(product, Figure):
            values = [None]  # the tables by name
        extra = [None] if shard else []
        if isinstance(product, Model):
            extra = [None, None]  # run and outputs
        if isinstance(product, Animation):
            extra = [None, None]  # run and output
        signature = inspect.signature(product.compute)
        try:
            signature.bind(*values, default_config, *extra)
        except TypeError as error:
            pytest.fail(f"{label}: {error}")


def test_columns_are_described_and_keys_are_complete():
    for name, table in TABLES.items():
        assert table.key and len(set(table.column_names)) == len(table.columns), name
        for column in table.columns:
            where = f"{name}.{column.name}"
            assert len(column.description) > 2 and "\n" not in column.description, where
            assert column.unit or column.type not in (INT, FLOAT), where
            assert not (column.key and column.nullable), where
            assert not column.nullable or column.type in (FLOAT, pa.string()), where


def test_the_rows_that_are_expected_are_counted_by_the_key(default_config, small_config):
    for config in (default_config, small_config):
        for name, table in registry.configured(Table, config).items():
            if table.expected is not None:
                several = table.expected(config)
                for expected in several if isinstance(several, tuple) else (several,):
                    assert set(expected.columns) <= set(table.key), name
                    assert expected.counts or not expected.columns, name
                    for values, rows in expected.counts.items():
                        assert len(values) == len(expected.columns), name
                        assert rows is None or rows > 0, (name, values)


# ---- workflow ---------------------------------------------------------------------------------


def test_every_product_has_rules_of_its_name():
    rules = set()
    for file in (ROOT / "workflow" / "rules").glob("*.smk"):
        rules |= set(re.findall(r"^rule (\w+):", file.read_text(), re.MULTILINE))
    trained = {model.curve for model in declarations(Model, optional=True).values()}
    expected = set()
    for name, product in (
        declarations(Table, optional=True) | declarations(Arrays, optional=True)
    ).items():
        if product.shards is not None and name not in trained:
            expected.add(f"{name}_shard")
        if product.shards is None or (isinstance(product, Table) and not product.shards_only):
            expected.add(name)
    expected |= set(declarations(Model, optional=True)) | set(
        declarations(Animation, optional=True)
    )
    assert not expected - rules
    of_shards = {rule for rule in rules if rule.endswith("_shard")}
    assert of_shards <= expected  # others would be rules of products that are not declared


def test_every_figure_has_a_caption():
    captions = {path.stem for path in (ROOT / "workflow" / "report").glob("*.rst")}
    assert captions == {
        "workflow",
        *declarations(Figure, optional=True),
        *declarations(Animation, optional=True),
    }


# ---- shards -----------------------------------------------------------------------------------


def test_shards_cover_every_unit_once(default_config, small_config):
    for label, product in PRODUCTS.items():
        for config in (default_config, small_config):
            if product.shards is None:
                continue
            for run, units in product.shards.runs(config).items():
                shards = product.shards.of_run(config, run)
                covered = [i for shard in shards for i in range(shard.start, shard.stop)]
                assert covered == list(range(units)) and units > 0, (label, run)
                for i, shard in enumerate(shards):
                    assert product.shards.find(config, shard.name) == shard, label
                    if product.shards.per_shard is None:
                        assert shard.name == run and len(shards) == 1, label
                    else:
                        assert shard.name == f"{run}.{i + 1}-of-{len(shards)}", label
                        assert shard.stop - shard.start <= product.shards.per_shard(config), label


def test_shards_are_as_large_as_allowed_and_found_by_name(default_config):
    for per_shard, units, bounds in (
        (3, 8, [(0, 3), (3, 6), (6, 8)]),
        (4, 8, [(0, 4), (4, 8)]),
        (100, 8, [(0, 8)]),
    ):
        shards = Shards(
            lambda _, n=units: {"a": n, "b": 1}, lambda *_: None, lambda _, n=per_shard: n
        )
        found = shards.of_run(default_config, "a")
        assert [(shard.start, shard.stop) for shard in found] == bounds
        assert [shard.run for shard in shards.all(default_config)] == ["a"] * len(bounds) + ["b"]
    with pytest.raises(UserError, match=r"no run 'c'; choose one of a, b"):
        shards.of_run(default_config, "c")
    with pytest.raises(UserError, match=r"no shard 'a\.2-of-2'; it has 2: a\.1-of-1, b\.1-of-1"):
        shards.find(default_config, "a.2-of-2")


def test_names_that_do_not_exist_get_names_that_are_close():
    for kind, name, message in (
        (Table, "flatland_spc", "no table 'flatland_spc'; did you mean flatland_scp"),
        (Arrays, "mask_pears", "no arrays 'mask_pears'; did you mean mask_pairs"),
        (Model, "mask_pairs", "no model 'mask_pairs'; did you mean"),
        (Figure, "portrait", "no figure 'portrait'; the option --list shows all names"),
    ):
        with pytest.raises(UserError, match=message):
            registry.find(kind, name)
    with pytest.raises(LookupError, match="portrait"):
        registry.find_product("portrait")


# ---- digests ----------------------------------------------------------------------------------


def digests(config: Config) -> dict[str, str]:
    """Digest of every product; those of models and shards, of all runs together."""
    return {label: settings_digest(product, config) for label, product in PRODUCTS.items()}


def runs_of(config: Config) -> dict[str, str]:
    """Digest of every run of every product."""
    return {
        f"{label}/{run}": settings_digest(product, config, run)
        for label, product in PRODUCTS.items() if product.shards
        for run in product.shards.runs(config)
    }  # fmt: skip


def downstream(config: Config, names: set[str]) -> set[str]:
    """Labels of the products of these names and of everything that is computed from them."""
    found = {label for label in PRODUCTS if label.split()[1] in names and "figure" not in label}
    assert {label.split()[1] for label in found} == names
    while True:
        files = {PRODUCTS[label].name for label in found if not label.startswith("figure")}
        more = {label for label in PRODUCTS if set(sources(label, config)) & files} - found
        if not more:
            return found
        found |= more


def sources(label: str, config: Config) -> Iterator[str]:
    """Names of the inputs of all runs of a product."""
    product = PRODUCTS[label]
    for run in product.shards.runs(config) if product.shards else [None]:
        for specification in product.input_names(config, run):
            yield find_input(specification)[0].name


def test_digests_do_not_depend_on_how_work_is_cut_nor_on_where_results_go(default_config):
    before = digests(default_config) | runs_of(default_config)
    config = overlay(
        default_config,
        profile="other",
        results="elsewhere",
        flatland={"experiments_per_job": 7},
        apartment={"experiments_per_job": 2},
        masks={"data": {"scenes_per_job": 2}, "tests": {"scenes_per_job": 3},
               "map": {"poses_per_job": 9}},
    )  # fmt: skip
    after = digests(config) | runs_of(config)
    assert [label for label in before if after[label] != before[label]] == []
    assert len(set(before.values())) == len(before)


def test_a_setting_changes_what_depends_on_it_and_nothing_else(default_config):
    before = digests(default_config)
    own_settings = {label for label in before if label.split()[0] in ("figure", "animation")}
    own_settings.add("table paper_comparison")  # depends on all settings, through its claims
    for sections, roots in (
        ({"flatland": {"thresholds": [0.0, 5.0]}}, {"flatland_scp", "flatland_sensitivity"}),
        ({"flatland": {"rest_steps": 4}},
         {"flatland_experiments", "flatland_commutation_experiments", "reset_free_trials",
          "reset_free_noise_experiments"}),
        ({"flatland": {"commutation": {"settled_rest_steps": 9}}},
         {"flatland_commutation_experiments"}),
        ({"flatland": {"baselines": {"epochs": 3}}}, {"flatland_baselines"}),
        ({"flatland": {"agents": {"unused": {"arm_length": 20.0}}}}, set()),
        ({"masks": {"objects": 12}}, {"mask_pairs", "mask_tuples"}),
        ({"masks": {"raft": {"samples": 32}}}, {"mask_training", "mask_curves"}),
        ({"masks": {"view_classifier": {"samples": 32}}}, {"mask_predictor"}),
        ({"masks": {"view_classifier": {"pairs": 3}}}, {"mask_predictor", "mask_regions"}),
        ({"masks": {"tests": {"tuples": 5}}}, {"mask_scores"}),
        ({"masks": {"tests": {"experiments": 49}}}, {"mask_tuples"}),
        ({"masks": {"map": {"headings": 2}}}, {"local_scp_experiments"}),
        ({"masks": {"map": {"cramped_room": "bath"}}}, {"local_scp_summary"}),
    ):  # fmt: skip
        config = overlay(default_config, **sections)
        after = digests(config)
        changed = {label for label in after if after[label] != before[label]}
        expected = downstream(config, roots)
        assert expected <= changed, (sections, sorted(expected - changed))
        assert changed <= expected | own_settings, (sections, sorted(changed - expected))
    after = digests(overlay(default_config, seed=7))
    assert not [label for label in after if after[label] == before[label]]


def test_a_run_depends_on_its_own_world_agent_and_model_alone(default_config):
    before = runs_of(default_config)
    experiments, training = "table flatland_experiments", "model mask_training"
    config = overlay(
        update_flatland(default_config, worlds={"furnished": {"objects": 9}},
                        agents={"long-arms": {"arm_length": 70.0}, "new": {}}),
        masks={"raft": {"learning_rate": 0.5}},
    )  # fmt: skip
    after = runs_of(config)
    for run, changes in (
        (f"{experiments}/furnished.polyphemus.50", True),
        (f"{experiments}/things-4.long-arms.50", True),
        (f"{experiments}/things-4.polyphemus.50", False),
        ("table flatland_commutation_experiments/furnished", True),
        ("table flatland_commutation_experiments/settled", False),
        (f"{training}/raft", True),
        (f"{training}/flownet", False),
        ("arrays mask_regions/flownet", False),
        ("model mask_predictor/raft", True),
        ("model mask_predictor/flownet", False),
        ("model mask_predictor/difference", False),
        ("table mask_scores/raft", True),
        ("table mask_scores/difference", False),
    ):
        assert (after[run] != before[run]) == changes, run
    more = overlay(default_config, flatland={"reference": {"experiments": 1234}})
    assert runs_of(more) == before | {
        run: digest for run, digest in runs_of(more).items() if run not in before
    }

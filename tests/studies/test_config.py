"""The configuration: profiles, layers, defaults, digest, schema and documentation.

What is refused is tested in test_config_errors.py.
"""

from __future__ import annotations

import copy
import json
import os
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from sensory_commutativity.errors import ConfigError
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.flatland.config import Run
from sensory_commutativity.studies.loading import (
    json_schema,
    load,
    merge,
    remove_keys,
    validate,
    write_resolved,
)
from tests.helpers import DEFAULT, ROOT, update_flatland

PROFILES = sorted(path for path in (ROOT / "config").glob("*.yaml") if path != DEFAULT)


# ---- profiles ---------------------------------------------------------------------------------


def test_the_default_profile_is_complete(default_config):
    assert isinstance(default_config, Config)
    assert default_config.profile == "default"
    assert default_config.folder == Path("results/default")


OVERLAYS = ("base-control",)
"""Files that are merged over another profile, and keep its name."""


def test_every_profile_loads_over_the_default_one(default_config):
    assert len(PROFILES) >= 2
    for file in PROFILES:
        config = load(DEFAULT, file)
        if file.stem not in OVERLAYS:
            assert config.profile == file.stem
        assert config != default_config


def test_the_paper_profile_has_the_sizes_of_the_paper():
    config = load(DEFAULT, ROOT / "config" / "paper.yaml")
    assert config.flatland.reference.experiments == 10_000  # section III-B
    baselines = config.flatland.baselines  # appendix A
    assert (baselines.transitions, baselines.training) == (100_000, 80_000)
    assert config.masks.data.pairs == 10_000  # section IV-A


def test_a_configuration_is_immutable(default_config):
    with pytest.raises(Exception, match="frozen"):
        default_config.seed = 3


# ---- runs of Flatland -------------------------------------------------------------------------


def test_runs_follow_the_sections_in_order(tiny_config):
    runs = tiny_config.flatland.runs()
    assert runs[0] == Run("furnished", "polyphemus", 4, 5)
    assert runs[1:3] == [
        Run("free-space", "polyphemus", 4, 3),
        Run("free-space", "joint-stops", 4, 3),
    ]
    assert runs[-2:] == [Run("furnished", "polyphemus", 2, 3), Run("furnished", "polyphemus", 6, 3)]
    assert len(runs) == 1 + 2 + 4 * 2 + 3 + 2
    assert len({run[:3] for run in runs}) == len(runs)


def test_commutation_jobs_are_a_tenth_as_long(tiny_config):
    for per_job, expected in ((1, 1), (9, 1), (10, 1), (25, 2), (1000, 100)):
        config = update_flatland(tiny_config, experiments_per_job=per_job)
        assert config.flatland.commutation_per_job == expected, per_job
    assert tiny_config.flatland.commutation_worlds() == {"furnished": 3, "settled": 5}


# ---- digest -----------------------------------------------------------------------------------


def reverse_keys(value):
    """The same mappings with their keys in reverse order; lists keep their order."""
    if isinstance(value, dict):
        return {key: reverse_keys(value[key]) for key in reversed(value)}
    return value


def test_the_digest_depends_on_values_alone(default_settings, default_config):
    """Not on the order of keys, on defaults that are written out, or on 60 instead of 60.0."""
    reordered = validate(reverse_keys(default_settings))
    assert list(reordered.flatland.worlds) != list(default_config.flatland.worlds)
    agent = {"flatland": {"agents": {"polyphemus": {"arm_length": 50.0}}}}
    same = {
        "reordered": reordered,
        "a default written out": validate(merge(default_settings, agent)),
        "all defaults written out": validate(default_config.model_dump(mode="json")),
    }
    assert len(default_config.digest()) == 64
    for name, config in same.items():
        assert config == default_config, name
        assert config.digest() == default_config.digest(), name
    whole, decimal = (
        validate(merge(default_settings, {"flatland": {"agents": {"mine": {"arm_length": value}}}}))
        for value in (60, 60.0)
    )
    assert whole == decimal and whole.digest() == decimal.digest()


def test_the_digest_depends_on_every_setting(default_settings, default_config):
    changes = (
        {"seed": 2},
        {"profile": "other"},
        {"flatland": {"rest_steps": 4}},
        {"flatland": {"thresholds": [0.0]}},
        {"flatland": {"worlds": {"things-4": {"objects": 5}}}},
        {"apartment": {"reach": 0.2}},
        {"masks": {"raft": {"samples": 1616}}},
        {"navigation": {"learner": {"epochs": 5}}},
    )
    digests = {validate(merge(default_settings, change)).digest() for change in changes}
    assert len(digests - {default_config.digest()}) == len(changes)


# ---- files ------------------------------------------------------------------------------------


def test_files_are_merged_in_order(tmp_path, default_config):
    first, second = tmp_path / "first.yaml", tmp_path / "second.yaml"
    first.write_text("seed: 1\nflatland: {reference: {experiments: 700}}\n")
    second.write_text("seed: 2\nflatland: {thresholds: [0.0, 5.0]}\n")
    config = load(DEFAULT, first, second)
    assert config.seed == 2
    assert config.flatland.reference.experiments == 700
    assert config.flatland.reference.world == default_config.flatland.reference.world
    assert config.flatland.thresholds == [0.0, 5.0]  # a list is replaced as a whole
    assert load(DEFAULT, second, first).seed == 1


def test_a_resolved_configuration_loads_again(tmp_path, default_config):
    file = tmp_path / "new" / "config.yaml"
    write_resolved(default_config, file)
    assert load(file) == default_config
    agents = yaml.safe_load(file.read_text())["flatland"]["agents"]
    assert agents["polyphemus"]["arm_length"] == 50.0  # defaults are filled in
    assert [path.name for path in file.parent.iterdir()] == ["config.yaml"]


def test_a_resolved_configuration_is_rewritten_only_if_it_changes(
    tmp_path, default_config, tiny_config
):
    file = tmp_path / "config.yaml"
    write_resolved(default_config, file)
    os.utime(file, (1, 1))
    write_resolved(default_config, file)
    assert file.stat().st_mtime == 1
    write_resolved(tiny_config, file)
    assert load(file) == tiny_config


# ---- merge ------------------------------------------------------------------------------------


def test_merge_examples():
    cases = (
        ({"a": 1}, {}, {"a": 1}),
        ({}, {"a": 1}, {"a": 1}),
        ({"a": 1, "b": 2}, {"a": 3}, {"a": 3, "b": 2}),
        ({"a": {"b": 1, "c": 2}}, {"a": {"b": 3}}, {"a": {"b": 3, "c": 2}}),
        ({"a": {"b": 1}}, {"a": 5}, {"a": 5}),
        ({"a": 5}, {"a": {"b": 1}}, {"a": {"b": 1}}),
        ({"a": [1, 2]}, {"a": [3]}, {"a": [3]}),
        ({"a": {"b": {"c": 1}}}, {"a": {"b": {"d": 2}}}, {"a": {"b": {"c": 1, "d": 2}}}),
        ({"a": {"b": 1}}, {"a": None}, {"a": None}),
        ({"a": {"b": {"c": 1}}}, {"a": {"b": {}}}, {"a": {"b": {}}}),
    )
    for base, overlay, merged in cases:
        arguments = copy.deepcopy((base, overlay))
        assert merge(base, overlay) == merged
        assert (base, overlay) == arguments  # merge does not modify them


def test_an_overlay_can_remove_keys(default_settings):
    assert default_settings["masks"]["fixed"]
    overlay = {"masks": {"fixed": {}}, "apartment": {"robots": {"jackrabbot": None}}}
    overlay["apartment"] |= {"robots_compared": {"robots": []}}
    for group in ("scenes_compared", "free_space", "within_reach"):
        overlay["apartment"][group] = {"robots": ["fetch"]}
    config = validate(merge(default_settings, overlay))
    assert config.masks.fixed == {} and list(config.apartment.robots) == ["fetch"]


@pytest.mark.parametrize("key", ["sequence_length", "sequnce_length"])
def test_null_does_not_remove_a_setting_nor_hide_a_misspelt_one(default_settings, key):
    with pytest.raises(ConfigError, match=rf"flatland\.{key}: "):
        validate(merge(default_settings, {"flatland": {key: None}}))


def test_what_snakemake_merged_loses_the_keys_that_an_overlay_removes():
    base, overlay = {"a": {"b": {"c": 1}, "d": 2}}, {"a": {"b": {}}}
    assert remove_keys({"a": {"b": {"c": 1}, "d": 2}}, [base, overlay]) == {"a": {"b": {}, "d": 2}}
    from_command_line = {"a": {"b": {"c": 5}, "d": 2}, "e": 3}
    assert remove_keys(from_command_line, [base, overlay]) == from_command_line


trees = st.recursive(
    st.integers(0, 3),
    lambda inner: st.dictionaries(st.sampled_from("abc"), inner, max_size=3),
    max_leaves=8,
)
mappings = st.dictionaries(st.sampled_from("abc"), trees, max_size=3)


@given(mappings, mappings)
def test_merge_is_idempotent_and_prefers_the_overlay(a, b):
    assert merge(a, a) == a
    assert merge(a, {}) == a == merge({}, a)
    assert merge(merge(a, b), b) == merge(a, b)
    assert set(merge(a, b)) == set(a) | set(b)
    for key, value in b.items():
        if not isinstance(value, dict):
            assert merge(a, b)[key] == value


# ---- schema and documentation -----------------------------------------------------------------


def schema_sections() -> list[dict]:
    schema = json_schema()
    return [schema, *schema["$defs"].values()]


def test_the_schema_file_is_up_to_date():
    """If it is not, run ``make schema``."""
    schema = json.loads((ROOT / "config" / "schema.json").read_text())
    assert schema == json.loads(json.dumps(json_schema()))


def test_the_schema_describes_every_section():
    assert json_schema()["$schema"].startswith("https://json-schema.org/")
    sections = schema_sections()
    assert len(sections) > 20
    described = set()
    for section in sections:
        assert section["additionalProperties"] is False
        properties = section["properties"].items()
        described |= {key for key, value in properties if "description" in value}
        for key, value in properties:  # numbers, texts and lists are described; sections may not be
            assert "description" in value or "$ref" in value or value["type"] == "object", key
    assert {"objects", "arm_length", "sequence_length", "samples", "epochs"} <= described


def test_the_readme_names_every_key():
    text = (ROOT / "config" / "README.md").read_text()
    keys = {key for section in schema_sections() for key in section["properties"]}
    assert not sorted(key for key in keys if key not in text)

"""config/: what may be set, and how a wrong setting is refused."""

from __future__ import annotations

import copy
import datetime
import json
import math
import os
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from tests.helpers import DEFAULT, ROOT, update_flatland

from sensory_commutativity.errors import ConfigError, UserError
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.flatland.config import Run
from sensory_commutativity.studies.loading import (
    joint_range,
    json_schema,
    load,
    merge,
    validate,
    write_resolved,
)

ABSENT = object()
LAID_OVER = sorted(p for p in (ROOT / "config").glob("*.yaml") if p != DEFAULT)


def spoil(settings: dict, key: str, value) -> dict:
    """The settings with the value at a dotted key replaced, added, or (ABSENT) removed."""
    settings = copy.deepcopy(settings)
    *parents, last = key.split("/")
    section = settings
    for parent in parents:
        section = section.setdefault(parent, {})
    if value is ABSENT:
        del section[last]
    else:
        section[last] = value
    return settings


WRONG = [
    # unknown keys, with and without a likely meaning
    ("sede", 1, "sede", "did you mean 'seed'?"),
    ("flatland/sequence_lenght", 50, "flatland.sequence_lenght", "did you mean 'sequence_length'?"),
    (
        "flatland/worlds/furnished/thing",
        3,
        "flatland.worlds.furnished.thing",
        "did you mean 'things'?",
    ),
    (
        "flatland/agents/polyphemus/arm_lenght",
        3.0,
        "flatland.agents.polyphemus.arm_lenght",
        "did you mean 'arm_length'?",
    ),
    ("flatland/baselines/epoch", 3, "flatland.baselines.epoch", "did you mean 'epochs'?"),
    ("flatland/reference/zzz", 3, "flatland.reference.zzz", "world, agent, experiments"),
    ("flatland/sensitivity/length", [5], "flatland.sensitivity.length", "did you mean 'lengths'?"),
    # missing keys
    ("profile", ABSENT, "profile", "missing"),
    ("seed", ABSENT, "seed", "missing"),
    ("flatland", ABSENT, "flatland", "missing"),
    ("flatland/agents", ABSENT, "flatland.agents", "missing"),
    ("flatland/reference", ABSENT, "flatland.reference", "missing"),
    ("flatland/reference/experiments", ABSENT, "flatland.reference.experiments", "missing"),
    ("flatland/variants/worlds", ABSENT, "flatland.variants.worlds", "missing"),
    ("flatland/baselines/transitions", ABSENT, "flatland.baselines.transitions", "missing"),
    # wrong types
    ("profile", 3, "profile", "got 3"),
    ("profile", None, "profile", "got None"),
    ("seed", "1", "seed", "got '1'"),
    ("seed", 1.5, "seed", "got 1.5"),
    ("seed", True, "seed", "got True"),
    ("results", ["a"], "results", "got ['a']"),
    ("flatland", None, "flatland", "got None"),
    ("flatland", [1], "flatland", "got [1]"),
    ("flatland/sequence_length", "50", "flatland.sequence_length", "got '50'"),
    ("flatland/thresholds", 0.0, "flatland.thresholds", "got 0.0"),
    ("flatland/thresholds", ["0"], "flatland.thresholds.0", "got '0'"),
    ("flatland/worlds/furnished/walls", "yes", "flatland.worlds.furnished.walls", "got 'yes'"),
    ("flatland/worlds/furnished/objects", 2.5, "flatland.worlds.furnished.objects", "got 2.5"),
    ("flatland/worlds/furnished", 7, "flatland.worlds.furnished", "got 7"),
    ("flatland/agents", ["polyphemus"], "flatland.agents", "got ['polyphemus']"),
    ("flatland/combinations/worlds", "things-0", "flatland.combinations.worlds", "got 'things-0'"),
    # out of range
    ("profile", "", "profile", "got ''"),
    ("profile", "Bad Name", "profile", "got 'Bad Name'"),
    ("profile", "a/b", "profile", "got 'a/b'"),
    ("profile", "..", "profile", "got '..'"),
    ("profile", "a" * 41, "profile", "40"),
    ("results", "", "results", "got ''"),
    ("results", "x" * 201, "results", "200"),
    ("seed", -1, "seed", "got -1"),
    ("seed", 2**63, "seed", "got 9223372036854775808"),
    ("flatland/sequence_length", 0, "flatland.sequence_length", "got 0"),
    ("flatland/sequence_length", 2001, "flatland.sequence_length", "2000"),
    ("flatland/rest_steps", -1, "flatland.rest_steps", "got -1"),
    ("flatland/rest_steps", 101, "flatland.rest_steps", "100"),
    ("flatland/thresholds", [], "flatland.thresholds", "at least 1"),
    ("flatland/thresholds", [0.0, -1.0], "flatland.thresholds.1", "got -1.0"),
    ("flatland/agents", {}, "flatland.agents", "at least 1"),
    ("flatland/worlds", {}, "flatland.worlds", "at least 1"),
    ("flatland/agents/Big", {}, "flatland.agents.Big", "pattern"),
    ("flatland/agents/polyphemus/arm_length", 0, "flatland.agents.polyphemus.arm_length", "got 0"),
    ("flatland/agents/polyphemus/arm_length", 151, "flatland.agents.polyphemus.arm_length", "150"),
    (
        "flatland/agents/polyphemus/longitudinal_speed",
        0.0,
        "flatland.agents.polyphemus.longitudinal_speed",
        "got 0.0",
    ),
    (
        "flatland/agents/polyphemus/angular_speed",
        0.6,
        "flatland.agents.polyphemus.angular_speed",
        "got 0.6",
    ),
    (
        "flatland/agents/polyphemus/joint_range_degrees",
        0,
        "flatland.agents.polyphemus.joint_range_degrees",
        "got 0",
    ),
    (
        "flatland/agents/polyphemus/joint_range_degrees",
        361,
        "flatland.agents.polyphemus.joint_range_degrees",
        "360",
    ),
    ("flatland/worlds/furnished/objects", -1, "flatland.worlds.furnished.objects", "got -1"),
    ("flatland/worlds/furnished/objects", 25, "flatland.worlds.furnished.objects", "24"),
    ("flatland/worlds/furnished/width", 100, "flatland.worlds.furnished.width", "200"),
    ("flatland/worlds/furnished/height", 5001, "flatland.worlds.furnished.height", "5000"),
    ("flatland/worlds/furnished/start_margin", 39, "flatland.worlds.furnished.start_margin", "40"),
    (
        "flatland/worlds/furnished/path_speed",
        -0.1,
        "flatland.worlds.furnished.path_speed",
        "got -0.1",
    ),
    ("flatland/reference/experiments", 1, "flatland.reference.experiments", "got 1"),
    ("flatland/free_space/agents", [], "flatland.free_space.agents", "at least 1"),
    ("flatland/sensitivity/lengths", [], "flatland.sensitivity.lengths", "at least 1"),
    ("flatland/sensitivity/lengths", [10, 0], "flatland.sensitivity.lengths.1", "got 0"),
    (
        "flatland/commutation/settled_rest_steps",
        -1,
        "flatland.commutation.settled_rest_steps",
        "got -1",
    ),
    ("flatland/baselines/batch_size", 0, "flatland.baselines.batch_size", "got 0"),
    ("flatland/baselines/learning_rate", 0, "flatland.baselines.learning_rate", "got 0"),
    ("flatland/baselines/epochs", 0, "flatland.baselines.epochs", "got 0"),
    ("flatland/experiments_per_job", 0, "flatland.experiments_per_job", "got 0"),
    ("results", "~/results", "results", "got '~/results'"),
    ("results", "of {profile}", "results", "pattern"),
    ("results", "re*", "results", "pattern"),
    ("results", "two\nlines", "results", "pattern"),
    # what YAML has and JSON has not
    ("seed", math.nan, "seed", "not a finite number"),
    (
        "flatland/agents/polyphemus/arm_length",
        math.inf,
        "flatland.agents.polyphemus.arm_length",
        "not a finite number",
    ),
    ("flatland/thresholds", [0.0, -math.inf], "flatland.thresholds.1", "not a finite number"),
    ("profile", datetime.date(2020, 1, 1), "profile", "put it in quotes"),
    ("flatland/agents", {2: {}}, "flatland.agents", "the key 2 is not text"),
    # several keys that do not go together
    (
        "flatland/worlds/furnished/start_margin",
        300,
        "flatland.worlds.furnished",
        "start_margin 300 leaves no place",
    ),
    ("flatland/worlds/furnished/width", 300.0, "flatland.worlds.furnished", "set it below 150"),
    ("flatland/reference/world", "nowhere", "reference.world", "choose one of furnished, "),
    ("flatland/reference/agent", "nobody", "reference.agent", "choose one of polyphemus, "),
    ("flatland/free_space/worlds", ["nowhere"], "free_space.worlds", "'nowhere'"),
    ("flatland/variants/agents", ["nobody"], "variants.agents", "'nobody'"),
    ("flatland/combinations/worlds", ["things-0", "things-0"], "combinations.worlds", "twice"),
    ("flatland/free_space/worlds", ["furnished"], "free_space.worlds", "walls: false"),
    ("flatland/free_space/worlds", ["things-0"], "free_space.worlds", "walls"),
    (
        "flatland/variants/agents",
        ["polyphemus"],
        "flatland",
        "'polyphemus' in 'furnished' is asked for by two sections",
    ),
    ("flatland/sensitivity/lengths", [10, 50], "sensitivity.lengths", "main sequence_length 50"),
    ("flatland/sensitivity/lengths", [10, 10], "sensitivity.lengths", "twice"),
    (
        "flatland/sensitivity/experiments",
        1001,
        "sensitivity.experiments",
        "more than reference.experiments 1000",
    ),
    ("flatland/thresholds", [0.0, 1.0, 1.0], "thresholds", "twice"),
    ("flatland/thresholds", [1.0, 10.0], "thresholds", "must hold 0.0"),
    ("flatland/baselines/training", 10_000, "flatland.baselines", "training 10000 leaves none"),
    ("flatland/baselines/training", 8_010, "baselines.training", "multiples of sequence_length 50"),
    ("flatland/baselines/transitions", 10_010, "baselines.transitions", "multiples"),
    ("flatland/commutation/settled_world", "nowhere", "commutation.settled_world", "'nowhere'"),
    ("flatland/commutation/settled_world", "furnished", "commutation.settled_world", "path_speed"),
    (
        "flatland/commutation/settled_world",
        "things-4",
        "commutation.settled_world",
        "path_speed: 0.0",
    ),
]


@pytest.mark.parametrize(
    ("key", "value", "names", "says"),
    WRONG,
    ids=[f"{key}={'ABSENT' if value is ABSENT else value!r:.30}" for key, value, *_ in WRONG],
)
def test_a_wrong_setting_is_refused_in_one_line(default_settings, key, value, names, says):
    validate(default_settings)  # as it stands it is right
    with pytest.raises(ConfigError) as caught:
        validate(spoil(default_settings, key, value))
    message = str(caught.value)
    assert message.startswith("config")
    assert "\n" not in message
    assert names in message
    assert says in message
    assert len(message) < 600


@pytest.mark.parametrize("key", ["new\nline", "seed\n"])
def test_a_strange_key_does_not_break_the_line(default_settings, key):
    with pytest.raises(ConfigError) as caught:
        validate({**default_settings, key: 1})
    assert "\n" not in str(caught.value)


def test_a_long_value_is_cut_short(default_settings):
    with pytest.raises(ConfigError) as caught:
        validate(spoil(default_settings, "flatland/sequence_length", "x" * 5000))
    assert len(str(caught.value)) < 300


def test_several_mistakes_are_counted(default_settings):
    with pytest.raises(ConfigError, match=r"and 2 more"):
        validate({**default_settings, "a": 1, "b": 2, "c": 3})


@pytest.mark.parametrize("settings", [None, [], "text", 3])
def test_settings_must_be_a_mapping(settings):
    with pytest.raises(ConfigError, match="expected a mapping"):
        validate(settings)


def test_config_errors_are_the_user_s():
    assert issubclass(ConfigError, UserError)


# ---- right settings --------------------------------------------------------------------------------------------------------


def test_the_default_profile_says_what_it_says(default_config):
    flatland = default_config.flatland
    assert default_config.profile == "default"
    assert default_config.folder == Path("results/default")
    assert flatland.sequence_length == 50
    assert flatland.worlds["free-space"].walls is False
    assert flatland.worlds["furnished"].objects == 10
    assert joint_range(flatland.agents["joint-stops"]) == pytest.approx(math.pi / 3)
    assert joint_range(flatland.agents["polyphemus"]) == math.inf


@pytest.mark.parametrize("file", LAID_OVER, ids=lambda p: p.name)
def test_every_profile_loads_over_the_default_one(file, default_config):
    config = load(DEFAULT, file)
    assert config.profile == file.stem
    assert config != default_config


def test_the_paper_profile_has_the_paper_s_sizes():
    flatland = load(DEFAULT, ROOT / "config" / "paper.yaml").flatland
    assert flatland.reference.experiments == 10_000  # section III-B
    assert (flatland.baselines.transitions, flatland.baselines.training) == (
        100_000,
        80_000,
    )  # appendix A


def test_a_config_cannot_be_changed(default_config):
    with pytest.raises(Exception, match="frozen"):
        default_config.seed = 3


def test_runs_are_all_experiments_in_order(tiny_config):
    runs = tiny_config.flatland.runs()
    assert runs[0] == Run("furnished", "polyphemus", 4, 5)
    assert runs[1:3] == [
        Run("free-space", "polyphemus", 4, 3),
        Run("free-space", "joint-stops", 4, 3),
    ]
    assert runs[-2:] == [Run("furnished", "polyphemus", 2, 3), Run("furnished", "polyphemus", 6, 3)]
    assert len(runs) == 1 + 2 + 4 * 2 + 3 + 2
    assert len({run[:3] for run in runs}) == len(runs)


@pytest.mark.parametrize(("per_job", "expected"), [(1, 1), (9, 1), (10, 1), (25, 2), (1000, 100)])
def test_commutation_jobs_are_a_tenth(tiny_config, per_job, expected):
    assert (
        update_flatland(tiny_config, experiments_per_job=per_job).flatland.commutation_per_job == expected
    )


@pytest.mark.parametrize(
    ("per_job", "jobs", "commutation_jobs"),
    [(1, 5, 3), (2, 3, 3), (5, 1, 3), (20, 1, 2), (1000, 1, 1)],
)
def test_jobs_hold_all_experiments(tiny_config, per_job, jobs, commutation_jobs):
    flatland = update_flatland(tiny_config, experiments_per_job=per_job).flatland
    assert flatland.n_jobs(flatland.reference.experiments) == jobs
    assert flatland.n_commutation_jobs == commutation_jobs


def test_commutation_worlds(tiny_config):
    assert tiny_config.flatland.commutation_worlds() == {"furnished": 3, "settled": 5}


def test_whole_numbers_pass_for_lengths(default_settings):
    one, other = (
        validate(spoil(default_settings, "flatland/agents/polyphemus/arm_length", value))
        for value in (60, 60.0)
    )
    assert one == other
    assert one.digest() == other.digest()


# ---- digest ----------------------------------------------------------------------------------------------------------------


def reordered(value):
    """The same mappings, keys the other way round; lists keep their order."""
    if isinstance(value, dict):
        return {key: reordered(value[key]) for key in reversed(value)}
    return value


def test_the_digest_does_not_depend_on_the_order_of_keys(default_settings, default_config):
    other = validate(reordered(default_settings))
    assert list(other.flatland.worlds) != list(default_config.flatland.worlds)
    assert other.digest() == default_config.digest()
    assert len(other.digest()) == 64


def test_the_digest_does_not_depend_on_whether_a_default_is_written(
    default_settings, default_config
):
    written = validate(spoil(default_settings, "flatland/agents/polyphemus/arm_length", 50.0))
    assert written.digest() == default_config.digest()
    everything = validate(default_config.model_dump(mode="json"))
    assert everything.digest() == default_config.digest()


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("seed", 2),
        ("profile", "other"),
        ("flatland/rest_steps", 4),
        ("flatland/thresholds", [0.0]),
        ("flatland/worlds/things-4/things", 5),
    ],
)
def test_the_digest_depends_on_every_setting(default_settings, default_config, key, value):
    assert validate(spoil(default_settings, key, value)).digest() != default_config.digest()


# ---- files -----------------------------------------------------------------------------------------------------------------


def write(folder: Path, name: str, text: str) -> Path:
    file = folder / name
    file.write_text(text)
    return file


def test_files_are_laid_over_one_another(tmp_path, default_config):
    first = write(tmp_path, "first.yaml", "seed: 1\nflatland: {reference: {experiments: 700}}\n")
    second = write(tmp_path, "second.yaml", "seed: 2\nflatland: {thresholds: [0.0, 5.0]}\n")
    config = load(DEFAULT, first, second)
    assert config.seed == 2
    assert config.flatland.reference.experiments == 700
    assert config.flatland.reference.world == default_config.flatland.reference.world
    assert config.flatland.thresholds == [0.0, 5.0]  # a list is replaced as a whole
    assert load(DEFAULT, second, first).seed == 1


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "expected a mapping"),
        ("- a\n- b\n", "expected a mapping"),
        ("seed: [1\n", "not valid YAML in line"),
        ("a: b: c\n", "not valid YAML in line 1"),
        ("seed: !!python/object:os.system x\n", "not valid YAML"),
        ("seed: 2020-01-01\n", "config.seed: datetime.date(2020, 1, 1) is a date"),
        ("seed: .nan\n", "config.seed: nan is not a finite number"),
        ("1: 2\n", "the key 1 is not text"),
        (
            "seed: 1e3\n",
            "got '1e3'; write numbers without quotes and as 0.001 or 1.0e-3",
        ),  # a text, as far as YAML is concerned
    ],
)
def test_a_broken_file_is_named(tmp_path, text, says):
    with pytest.raises(ConfigError) as caught:
        load(DEFAULT, write(tmp_path, "broken.yaml", text))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    if "YAML" in says or "mapping" in says:
        assert "broken.yaml" in str(caught.value)


def test_a_file_that_is_not_there_or_not_text(tmp_path):
    with pytest.raises(ConfigError, match=r"gone\.yaml: there is no such file"):
        load(tmp_path / "gone.yaml")
    with pytest.raises(ConfigError, match="cannot be read"):
        load(tmp_path)
    (tmp_path / "bytes.yaml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match=r"bytes\.yaml: (cannot be read|not valid YAML)"):
        load(tmp_path / "bytes.yaml")


def test_resolved_settings_load_again(tmp_path, default_config):
    file = write(tmp_path, "resolved.yaml", yaml.safe_dump(default_config.model_dump(mode="json")))
    assert load(file) == default_config


def test_write_resolved_is_a_round_trip(tmp_path, default_config):
    file = tmp_path / "new" / "config.yaml"
    write_resolved(default_config, file)
    assert load(file) == default_config
    assert (
        yaml.safe_load(file.read_text())["flatland"]["agents"]["polyphemus"]["arm_length"] == 50.0
    )  # defaults are filled in
    assert [p.name for p in file.parent.iterdir()] == ["config.yaml"]


def test_write_resolved_leaves_alone_what_says_the_same(tmp_path, default_config, tiny_config):
    file = tmp_path / "config.yaml"
    write_resolved(default_config, file)
    os.utime(file, (1, 1))
    write_resolved(default_config, file)
    assert file.stat().st_mtime == 1
    write_resolved(tiny_config, file)
    assert load(file) == tiny_config


# ---- merge -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("base", "overlay", "merged"),
    [
        ({"a": 1}, {}, {"a": 1}),
        ({}, {"a": 1}, {"a": 1}),
        ({"a": 1, "b": 2}, {"a": 3}, {"a": 3, "b": 2}),
        ({"a": {"b": 1, "c": 2}}, {"a": {"b": 3}}, {"a": {"b": 3, "c": 2}}),
        ({"a": {"b": 1}}, {"a": 5}, {"a": 5}),
        ({"a": 5}, {"a": {"b": 1}}, {"a": {"b": 1}}),
        ({"a": [1, 2]}, {"a": [3]}, {"a": [3]}),
        ({"a": {"b": {"c": 1}}}, {"a": {"b": {"d": 2}}}, {"a": {"b": {"c": 1, "d": 2}}}),
        ({"a": {"b": 1}}, {"a": None}, {"a": None}),
    ],
)
def test_merge_by_hand(base, overlay, merged):
    kept = copy.deepcopy((base, overlay))
    assert merge(base, overlay) == merged
    assert (base, overlay) == kept


trees = st.recursive(
    st.integers(0, 3),
    lambda inner: st.dictionaries(st.sampled_from("abc"), inner, max_size=3),
    max_leaves=8,
)
mappings = st.dictionaries(st.sampled_from("abc"), trees, max_size=3)


@given(mappings, mappings, mappings)
def test_merge_is_a_sensible_overlay(a, b, c):
    assert merge(a, a) == a
    assert merge(a, {}) == a == merge({}, a)
    assert merge(merge(a, b), b) == merge(a, b)
    assert set(merge(a, b)) == set(a) | set(b)
    for key, value in b.items():
        if not isinstance(value, dict):
            assert merge(a, b)[key] == value


# ---- schema ----------------------------------------------------------------------------------------------------------------


def test_the_schema_file_is_up_to_date():
    """Otherwise run: sensory-commutativity schema --out config/schema.json"""
    assert json.loads((ROOT / "config" / "schema.json").read_text()) == json.loads(
        json.dumps(json_schema())
    )


def test_the_schema_describes_every_key():
    schema = json_schema()
    assert schema["$schema"].startswith("https://json-schema.org/")
    sections = [schema, *schema["$defs"].values()]
    assert len(sections) == 1 + len(schema["$defs"]) > 8
    for section in sections:
        assert section["additionalProperties"] is False
    described = [
        key
        for section in schema["$defs"].values()
        for key, value in section["properties"].items()
        if "description" in value
    ]
    assert {"things", "arm_length", "sequence_length", "experiments", "epochs"} <= set(described)


def test_the_readme_names_every_key():
    text = (ROOT / "config" / "README.md").read_text()
    schema = json_schema()
    keys = {key for section in [schema, *schema["$defs"].values()] for key in section["properties"]}
    assert not sorted(key for key in keys if key not in text)


def test_a_config_is_what_load_gives(default_config):
    assert isinstance(default_config, Config)

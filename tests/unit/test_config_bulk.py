"""Wrong configurations by the hundred, made from the schema: each is told in one line that names the key, at once, and leaves nothing behind."""

from __future__ import annotations

import copy
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml
from tests.helpers import DEFAULT, ROOT

from sensory_commutativity import cli
from sensory_commutativity.storage.yamlfile import read_yaml
from sensory_commutativity.studies import loading
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import json_schema, load, merge, validate

PROGRAM = str(Path(sys.executable).parent / "sensory-commutativity")
PREFIX = "sensory-commutativity: error: "
SECONDS = 3.0
"""Within which a person should be told."""
SCHEMA = json_schema()
OTHER_TYPES: dict[str, list[Any]] = {
    "integer": ["many", 1.5, True, None, [], {}],
    "number": ["many", True, None, [], {}],
    "string": [7, True, None, [], {}],
    "boolean": ["yes", 1, None, []],
    "array": ["a", 7, True, None, {}],
    "object": ["a", 7, True, None, []],
}


class Wrong(NamedTuple):
    """A layer with one mistake over the right settings, or `whole` settings, since no layer takes anything away; and what the message must name."""

    name: str
    settings: dict[str, Any]
    key: str
    whole: bool = False


class Place(NamedTuple):
    """A value in the configuration and what the schema says of it."""

    path: tuple[str | int, ...]
    schema: dict[str, Any]
    value: Any

    @property
    def key(self) -> str:
        return ".".join(map(str, self.path))


@pytest.fixture(scope="module")
def right() -> dict[str, Any]:
    """All settings of the default profile with every default filled in; files are named so that any folder will do."""
    text = yaml.safe_dump(load(DEFAULT).model_dump(mode="json"))
    return yaml.safe_load(
        text.replace("config/robots/", f"{ROOT}/config/robots/").replace(
            "config/apartments/", f"{ROOT}/config/apartments/"
        )
    )


def plain(schema: dict[str, Any]) -> dict[str, Any]:
    """The schema without references; of a value that may be null, that of the rest."""
    while "$ref" in schema:
        schema = SCHEMA["$defs"][schema["$ref"].rpartition("/")[2]]
    if "anyOf" in schema:
        return {
            **next(plain(one) for one in schema["anyOf"] if one.get("type") != "null"),
            "nullable": True,
        }
    return schema


def places(schema: dict[str, Any], value: Any, path: tuple[str | int, ...] = ()) -> Iterator[Place]:
    """Every value; of lists and of mappings with free keys the first."""
    schema = plain(schema)
    if path:
        yield Place(path, schema, value)
    if "properties" in schema:
        for key, inner in schema["properties"].items():
            yield from places(inner, value[key], (*path, key))
    elif schema["type"] == "object" and value:
        key = next(iter(value))
        inner = schema.get("additionalProperties") or next(
            iter(schema["patternProperties"].values())
        )
        yield from places(inner, value[key], (*path, key))
    elif schema["type"] == "array" and value:
        yield from places(schema["items"], value[0], (*path, 0))


def sections(right: dict[str, Any]) -> list[Place]:
    """What has keys that the schema names."""
    return [
        Place((), SCHEMA, right),
        *(place for place in places(SCHEMA, right) if "properties" in place.schema),
    ]


def spoilt(right: dict[str, Any], path: tuple[str | int, ...], value: Any) -> dict[str, Any]:
    """A layer that puts another value at a path; a list is laid over as a whole."""
    names = list(path)
    while any(isinstance(part, int) for part in names):
        numbers = next(i for i, part in enumerate(names) if isinstance(part, int))
        above: Any = copy.deepcopy(right)
        for part in names[:numbers]:
            above = above[part]
        inner = above
        for part in names[numbers:-1]:
            inner = inner[part]
        inner[names[-1]] = value
        names, value = names[:numbers], above
    for part in reversed(names):
        value = {part: value}
    return value


def without(right: dict[str, Any], path: tuple[str | int, ...]) -> dict[str, Any]:
    settings = copy.deepcopy(right)
    at: Any = settings
    for part in path[:-1]:
        at = at[part]
    del at[path[-1]]
    return settings


# ---- the mistakes ----------------------------------------------------------------------------------------------------------


def missing(right: dict[str, Any]) -> Iterator[Wrong]:
    for section in sections(right):
        for key in section.schema.get("required", ()):
            path = (*section.path, key)
            yield Wrong(
                f"without {'.'.join(map(str, path))}",
                without(right, path),
                ".".join(map(str, path)),
                whole=True,
            )


def misspelt(right: dict[str, Any]) -> Iterator[Wrong]:
    for section in sections(right):
        for key in section.schema["properties"]:
            typed = (
                f"{key[:-2]}{key[-1]}{key[-2]}"
                if len(key) > 1 and key[-1] != key[-2]
                else f"{key}s"
            )
            typed = typed if typed not in section.schema["properties"] else f"{key}_"
            path = (*section.path, typed)
            value = right
            for part in (*section.path, key):
                value = value[part]
            yield Wrong(
                ".".join(map(str, path)), spoilt(right, path, value), ".".join(map(str, path))
            )


def of_another_type(right: dict[str, Any]) -> Iterator[Wrong]:
    for place in places(SCHEMA, right):
        for value in OTHER_TYPES[place.schema["type"]]:
            if not (value is None and place.schema.get("nullable")) and value != place.value:
                yield Wrong(f"{place.key}={value!r}", spoilt(right, place.path, value), place.key)


def beyond(schema: dict[str, Any]) -> Iterator[Any]:
    """Values of the right type just outside of what the schema allows."""
    step = 1 if schema["type"] == "integer" else 0.001
    if "minimum" in schema:
        yield schema["minimum"] - step
    if "maximum" in schema:
        yield schema["maximum"] + step
    if "exclusiveMinimum" in schema:
        yield schema["exclusiveMinimum"]
    if "exclusiveMaximum" in schema:
        yield schema["exclusiveMaximum"]
    if "multipleOf" in schema:
        yield schema["multipleOf"] * 10 + 1
    if schema.get("minLength"):
        yield ""
    if "maxLength" in schema:
        yield "a" * (schema["maxLength"] + 1)
    if "pattern" in schema:
        yield from (
            ("", "a\tb", "a\n")
            if "~" in schema["pattern"]
            else ("", "Upper", "a b", "a/b", "..", "-a", "a-", "a\n", "$(a)", "ä")
        )
    if "enum" in schema:
        yield "none-of-them"
    if schema.get("minItems"):
        yield []
    if schema["type"] == "number":
        yield from (1e301, -1e301) if "maximum" in schema else ()


def out_of_range(right: dict[str, Any]) -> Iterator[Wrong]:
    for place in places(SCHEMA, right):
        for value in beyond(place.schema):
            yield Wrong(f"{place.key}={value!r:.40}", spoilt(right, place.path, value), place.key)
        if "minProperties" in place.schema:
            empty = merge(without(right, place.path), spoilt(right, place.path, {}))
            yield Wrong(f"{place.key} empty", empty, place.key, whole=True)
        if "maxItems" in place.schema:
            yield Wrong(
                f"{place.key} too long",
                spoilt(right, place.path, place.value * (place.schema["maxItems"] + 1)),
                place.key,
            )


INCONSISTENT: list[
    tuple[str, str]
] = [  # a layer over the default profile, and what the message names
    # names that are defined nowhere
    ("flatland: {reference: {world: nowhere}}", "reference.world"),
    ("flatland: {reference: {agent: nobody}}", "reference.agent"),
    ("flatland: {free_space: {worlds: [nowhere]}}", "free_space.worlds"),
    ("flatland: {free_space: {agents: [nobody]}}", "free_space.agents"),
    ("flatland: {combinations: {worlds: [nowhere]}}", "combinations.worlds"),
    ("flatland: {combinations: {agents: [nobody]}}", "combinations.agents"),
    ("flatland: {variants: {worlds: [nowhere]}}", "variants.worlds"),
    ("flatland: {variants: {agents: [nobody]}}", "variants.agents"),
    ("flatland: {commutation: {settled_world: nowhere}}", "commutation.settled_world"),
    ("apartment: {reference: {robot: nobody}}", "reference.robot"),
    ("apartment: {reference: {scene: nowhere}}", "reference.scene"),
    ("apartment: {robots_compared: {robots: [nobody]}}", "robots_compared.robots"),
    ("apartment: {robots_compared: {scenes: [nowhere]}}", "robots_compared.scenes"),
    ("apartment: {scenes_compared: {robots: [nobody]}}", "scenes_compared.robots"),
    ("apartment: {scenes_compared: {scenes: [nowhere]}}", "scenes_compared.scenes"),
    ("apartment: {within_reach: {robots: [nobody]}}", "within_reach.robots"),
    ("apartment: {within_reach: {scenes: [nowhere]}}", "within_reach.scenes"),
    ("apartment: {free_space: {robots: [nobody]}}", "free_space.robots"),
    ("apartment: {free_space: {scenes: [nowhere]}}", "free_space.scenes"),
    ("masks: {robot: nobody}", "masks.robot"),
    ("masks: {data: {scene: nowhere}}", "masks.data.scene"),
    ("masks: {tests: {scenes: [nowhere]}}", "masks.tests.scenes"),
    ("masks: {map: {scene: nowhere}}", "masks.map.scene"),
    ("masks: {map: {cramped_room: ballroom}}", "masks.map.cramped_room"),
    ("masks: {map: {low_furniture: [throne]}}", "masks.map.low_furniture"),
    ("masks: {fixed: {third_arm_joint: 0.0}}", "masks: fixed"),
    ("navigation: {world: nowhere}", "navigation.world"),
    ("navigation: {agent: nobody}", "navigation.agent"),
    ("navigation: {scp_world: nowhere}", "navigation.scp_world"),
    # worlds and agents that do not serve
    ("flatland: {free_space: {worlds: [furnished]}}", "free_space.worlds"),
    ("flatland: {free_space: {worlds: [things-0]}}", "free_space.worlds"),
    ("flatland: {worlds: {free-space: {objects: 4}}}", "free_space.worlds"),
    ("flatland: {commutation: {settled_world: things-4}}", "commutation.settled_world"),
    ("flatland: {commutation: {settled_world: furnished}}", "commutation.settled_world"),
    ("flatland: {worlds: {settled: {path_speed: 1.0}}}", "commutation.settled_world"),
    ("flatland: {worlds: {furnished: {start_margin: 300.0}}}", "flatland.worlds.furnished"),
    ("flatland: {worlds: {furnished: {width: 300.0}}}", "flatland.worlds.furnished"),
    (
        "flatland: {worlds: {furnished: {objects: 24, width: 200.0, height: 200.0, start_margin: 90.0}}}",
        "flatland.worlds.furnished",
    ),
    ("apartment: {free_space: {scenes: [rs-stand-in]}}", "free_space.scenes"),
    ("masks: {data: {scene: free-space}}", "masks.data.scene"),
    ("masks: {tests: {scenes: [free-space]}}", "masks.tests.scenes"),
    ("masks: {map: {scene: free-space}}", "masks.map.scene"),
    ("masks: {robot: jackrabbot}", "masks.robot"),
    (
        "apartment: {reference: {robot: jackrabbot}, robots_compared: {robots: [fetch]}}",
        "masks.robot",
    ),
    ("navigation: {agent: long-arms}", "flatland.variants"),
    ("navigation: {scp_world: arena}", "flatland.variants"),
    ("flatland: {variants: {agents: [slow-base]}}", "navigation needs the SCP"),
    # what is there twice
    ("flatland: {variants: {agents: [polyphemus]}}", "'polyphemus' in 'furnished'"),
    ("flatland: {variants: {agents: [sprinter, sprinter]}}", "variants.agents"),
    ("flatland: {combinations: {worlds: [things-0, things-0]}}", "combinations.worlds"),
    ("flatland: {thresholds: [0.0, 1.0, 1.0]}", "thresholds"),
    ("flatland: {sensitivity: {lengths: [10, 10]}}", "sensitivity.lengths"),
    ("flatland: {sensitivity: {lengths: [10, 50]}}", "sensitivity.lengths"),
    ("apartment: {robots_compared: {robots: [fetch]}}", "'fetch' in 'rs-stand-in'"),
    ("apartment: {scenes_compared: {scenes: [rs-stand-in]}}", "'fetch' in 'rs-stand-in'"),
    ("apartment: {thresholds: [0.0, 50.0, 50.0]}", "thresholds"),
    ("apartment: {fields_of_view: [90.0, 90.0]}", "fields_of_view"),
    ("apartment: {sensitivity: {lengths: [50]}}", "sensitivity.lengths"),
    ("masks: {tests: {scenes: [rs-stand-in, rs-stand-in]}}", "tests.scenes"),
    ("masks: {tests: {scenes: [placida-stand-in]}}", "tests.scenes"),
    ("masks: {tests: {field_of_view: 45.0}}", "tests.field_of_view"),
    ("navigation: {seeds: [1, 2, 3, 3]}", "seeds"),
    ("navigation: {action_spaces: [full, full, truncated, adapted]}", "action_spaces"),
    # sizes
    ("flatland: {thresholds: [1.0, 10.0]}", "thresholds"),
    ("flatland: {sensitivity: {experiments: 1001}}", "sensitivity.experiments"),
    ("flatland: {baselines: {training: 10000}}", "training"),
    ("flatland: {baselines: {training: 8010}}", "baselines.training"),
    ("flatland: {baselines: {transitions: 10010}}", "baselines.transitions"),
    ("flatland: {sequence_length: 37}", "sequence_length"),
    ("apartment: {thresholds: [20.0, 0.0, 50.0]}", "thresholds"),
    ("apartment: {reference: {threshold: 51.0}}", "reference.threshold"),
    ("apartment: {sensitivity: {experiments: 25}}", "sensitivity.experiments"),
    ("navigation: {steps: 40961}", "steps"),
    ("navigation: {checkpoints: 7}", "steps"),
    ("navigation: {learner: {batch_size: 100}}", "batch_size"),
    ("navigation: {learner: {batch_size: 4096}}", "batch_size"),  # more than a rollout holds
    ("navigation: {learner: {rooms: 5}}", "batch_size"),
    ("navigation: {threshold_return: 51.0}", "threshold_return"),
    ("navigation: {action_spaces: [full, truncated, inverse]}", "action_spaces"),
    # zones
    (
        "navigation: {zones: [{x: 120.0, y: 120.0, radius: 80.0, reward: 0.0}]}",
        "navigation.zones.0",
    ),
    ("navigation: {zones: [{x: 120.0, y: 120.0, radius: 80.0, reward: -1.0}]}", "zones"),
    ("navigation: {zones: [{x: 20.0, y: 120.0, radius: 80.0, reward: 50.0}]}", "navigation.zones"),
    ("navigation: {zones: [{x: 590.0, y: 120.0, radius: 80.0, reward: 50.0}]}", "navigation.zones"),
    (
        "{flatland: {worlds: {arena: {start_margin: 200.0}}}, navigation: {zones: [{x: 300.0, y: 300.0, radius: 299.0, reward: 50.0}]}}",
        "navigation.zones",
    ),
    (
        "navigation: {zones: [{x: 120.0, y: 120.0, radius: 80.0, reward: 50.0}, {x: 150.0, y: 120.0, radius: 80.0, reward: -50.0}]}",
        "zones",
    ),
    ("flatland: {worlds: {arena: {width: 300.0}}}", "navigation.zones"),
    # files and folders
    ("apartment: {robots: {fetch: {description: gone.yaml}}}", "gone.yaml"),
    ("apartment: {robots: {fetch: {description: .}}}", "cannot be read"),
    (f"apartment: {{robots: {{fetch: {{description: {ROOT}/README.md}}}}}}", "README.md"),
    (
        f"apartment: {{robots: {{fetch: {{description: {ROOT}/config/apartments/rs-stand-in.yaml}}}}}}",
        "rs-stand-in.yaml",
    ),
    ("apartment: {scenes: {rs-stand-in: {file: gone.yaml}}}", "gone.yaml"),
    (f"apartment: {{scenes: {{rs-stand-in: {{file: {ROOT}/config/robots/fetch.yaml}}}}}}", "kind"),
    ("apartment: {weights: gone.npz}", "apartment.weights"),
    ("masks: {fixed: {head_tilt_joint: 99.0}}", "masks: fixed"),
    ("masks: {fixed: {shoulder_pan_joint: 0.0}}", "masks: fixed"),
    ("results: ../elsewhere", "results"),
    ("results: a/../../b", "results"),
    ("results: -r", "results"),
    ("results: layer.yaml", "'results'"),
    ("results: layer.yaml/below", "'results'"),
    ("results: /proc/nowhere", "'results'"),
]


# ---- trying them -----------------------------------------------------------------------------------------------------------


class Tried:
    """What the command line said of wrong configurations, and how long it took."""

    def __init__(self, monkeypatch, capsys, folder: Path, base: dict[str, Any]):
        self.monkeypatch, self.capsys, self.folder, self.base = monkeypatch, capsys, folder, base
        self.count, self.slowest, self.problems = 0, (0.0, 0.0, ""), []
        monkeypatch.chdir(folder)

    def check(self, name: str, files: list[str], key: str) -> None:
        """Run `sensory-commutativity check` in this process and note everything that is not as it should be."""
        before = self._files()
        self.monkeypatch.setattr(sys, "argv", [PROGRAM, "check", *files])
        start, busy, code = time.monotonic(), time.process_time(), 0
        try:
            cli.run()
        except SystemExit as leave:
            code = leave.code
        except Exception as error:  # a traceback, for a person
            code = repr(error)[:200]
        seconds, busy = time.monotonic() - start, time.process_time() - busy
        out, err = self.capsys.readouterr()
        self.count, self.slowest = self.count + 1, max(self.slowest, (busy, seconds, name))
        faults = {
            f"exit code {code}": code != 2,
            f"printed {out!r:.80}": bool(out),
            f"said {err!r:.300}": not (
                err.startswith(PREFIX) and err.endswith("\n") and len(err.splitlines()) == 1
            ),
            f"does not name {key!r}: {err!r:.300}": key not in err,
            f"took {busy:.1f} s": busy
            >= SECONDS,  # of its own: where other programs have the cores, a clock tells nothing
            "wrote something": self._files() != before,
        }
        self.problems += [f"{name}: {fault}" for fault, there in faults.items() if there]

    def _files(self) -> dict[Path, int]:
        return {path: path.stat().st_mtime_ns for path in self.folder.rglob("*")}

    def report(self, least: int) -> None:
        busy, seconds, name = self.slowest
        print(
            f"{self.count} wrong configurations; the slowest took {busy:.3f} s, {seconds:.3f} s by the clock: {name}"
        )
        assert not self.problems, "\n".join(self.problems)
        assert self.count >= least


@pytest.fixture
def tried(monkeypatch, capsys, tmp_path, right) -> Tried:
    """With the right settings as base.yaml, which is not read anew each time: that would take longer than all else."""
    trial = Tried(monkeypatch, capsys, tmp_path, right)
    monkeypatch.setattr(
        loading,
        "read_yaml",
        lambda file, *rest: trial.base if file == "base.yaml" else read_yaml(file, *rest),
    )
    return trial


@pytest.mark.parametrize(
    ("mistakes", "least"),
    [(missing, 40), (misspelt, 130), (of_another_type, 600), (out_of_range, 250)],
)
def test_every_key_spoilt_in_turn_is_refused_in_one_line_that_names_it(
    right, tried, mistakes, least
):
    validate(right)
    layer = tried.folder / "layer.yaml"
    for wrong in mistakes(right):
        tried.base = wrong.settings if wrong.whole else right
        layer.write_text(json.dumps({} if wrong.whole else wrong.settings))  # JSON is YAML, too
        tried.check(wrong.name, ["base.yaml", "layer.yaml"], wrong.key)
    tried.report(least)


def test_settings_that_do_not_go_together_are_refused_in_one_line_that_names_them(right, tried):
    layer = tried.folder / "layer.yaml"
    for text, key in INCONSISTENT:
        layer.write_text(text)
        tried.check(text, ["base.yaml", "layer.yaml"], key)
    tried.report(90)


def test_every_constraint_of_the_models_is_among_the_mistakes():
    """So that a new kind of limit does not go untried."""
    known = {
        "minimum",
        "maximum",
        "exclusiveMinimum",
        "exclusiveMaximum",
        "multipleOf",
        "minLength",
        "maxLength",
        "pattern",
        "enum",
    }
    known |= {"minItems", "maxItems", "minProperties"}
    shape = {
        "title",
        "description",
        "default",
        "type",
        "properties",
        "required",
        "additionalProperties",
        "patternProperties",
        "propertyNames",
    }
    shape |= {"items", "anyOf", "$ref", "$defs", "$schema"}

    def words(schema: Any) -> Iterator[str]:
        for word, inner in schema.items():
            yield word
            if word in ("properties", "$defs", "patternProperties"):
                for part in inner.values():
                    yield from words(part)
            elif word in ("items", "additionalProperties", "propertyNames") and isinstance(
                inner, dict
            ):
                yield from words(inner)
            elif word == "anyOf":
                for part in inner:
                    yield from words(part)

    assert set(words(SCHEMA)) <= known | shape


def test_every_key_of_the_models_is_walked_over(right):
    keys = {part for place in places(SCHEMA, right) for part in place.path if isinstance(part, str)}
    assert {
        key for section in [SCHEMA, *SCHEMA["$defs"].values()] for key in section["properties"]
    } <= keys
    assert isinstance(validate(merge(right, {})), Config)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("sede: 1", "sede"),
        ("seed: 1\nseed: 2", "'seed'"),
        ("flatland: {reference: {agent: nobody}}", "reference.agent"),
        ("masks: {map: {cramped_room: ballroom}}", "masks.map.cramped_room"),
        ("results: ../elsewhere", "results"),
    ],
)
def test_the_installed_program_says_the_same(tmp_path, right, text, key):
    (tmp_path / "base.yaml").write_text(json.dumps(right))
    (tmp_path / "layer.yaml").write_text(text)
    run = subprocess.run(
        [PROGRAM, "check", "base.yaml", "layer.yaml"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
        env=os.environ,
    )
    assert run.returncode == 2
    assert not run.stdout
    assert run.stderr.startswith(PREFIX) and run.stderr.count("\n") == 1 and key in run.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["base.yaml", "layer.yaml"]

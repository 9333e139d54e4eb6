"""Configurations with one mistake each: generated from the schema, and written by hand."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any, NamedTuple

from sensory_commutativity.studies.loading import json_schema
from tests.helpers import ROOT

SCHEMA = json_schema()
WRONG_TYPES: dict[str, list[Any]] = {
    "integer": ["many", "1", 1.5, True, None, [], {}],
    "number": ["many", "0.5", True, None, [], {}],
    "string": [7, True, None, [], {}],
    "boolean": ["yes", 1, None, []],
    "array": ["a", 7, True, None, {}],
    "object": ["a", 7, True, None, []],
}
BAD_NAMES = ("", "Upper", "a b", "a/b", "..", "-a", "a-", "a\n", "$(a)", "ä")
BAD_FOLDERS = ("", "~/a", "{a}", "a*", "a?", "a\tb", "a\n", "a\nb")
CONSTRAINTS = {
    "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "multipleOf", "minLength",
    "maxLength", "pattern", "enum", "minItems", "maxItems", "minProperties",
}  # fmt: skip
"""Words of the schema of which :func:`out_of_range` makes mistakes."""
STRUCTURE = {
    "title", "description", "default", "type", "properties", "required", "additionalProperties",
    "patternProperties", "propertyNames", "items", "anyOf", "$ref", "$defs", "$schema",
    "affects_results",
}  # fmt: skip


class Wrong(NamedTuple):
    """A configuration with one mistake.

    Attributes
    ----------
    layer : dict or str
        Merged over the right settings; text is YAML.
    key : str
        The message must contain it, and all of `words`.
    words : tuple of str
    base : dict, optional
        In place of the right settings: merging cannot remove a key.
    """

    layer: dict[str, Any] | str
    key: str
    words: tuple[str, ...] = ()
    base: dict[str, Any] | None = None


class Setting(NamedTuple):
    """A value in the configuration, and its schema."""

    path: tuple[str | int, ...]
    schema: dict[str, Any]
    value: Any
    removable: bool = False  # an entry of a mapping whose keys are names: null leaves it out

    @property
    def key(self) -> str:
        return ".".join(map(str, self.path))


# ---- walking over the schema ------------------------------------------------------------------


def resolve(schema: dict[str, Any]) -> dict[str, Any]:
    """The schema without references; of a value that may be null, that of the other type."""
    while "$ref" in schema:
        schema = SCHEMA["$defs"][schema["$ref"].rpartition("/")[2]]
    if "anyOf" in schema:
        inner = next(one for one in schema["anyOf"] if one.get("type") != "null")
        return {**resolve(inner), "nullable": True}
    return schema


def walk(
    schema: dict[str, Any], value: Any, path: tuple = (), removable: bool = False
) -> Iterator[Setting]:
    """All settings; of lists, and of mappings with free keys, the first element."""
    schema = resolve(schema)
    if path:
        yield Setting(path, schema, value, removable)
    if "properties" in schema:
        for key, inner in schema["properties"].items():
            yield from walk(inner, value[key], (*path, key))
    elif schema["type"] == "object" and value:
        key = next(iter(value))
        inner = schema.get("additionalProperties") or next(
            iter(schema["patternProperties"].values())
        )
        yield from walk(inner, value[key], (*path, key), removable=True)
    elif schema["type"] == "array" and value:
        yield from walk(schema["items"], value[0], (*path, 0))


def sections(right: dict[str, Any]) -> list[Setting]:
    """Everything with keys that the schema names."""
    found = [setting for setting in walk(SCHEMA, right) if "properties" in setting.schema]
    return [Setting((), SCHEMA, right), *found]


def get(settings: Any, path: tuple) -> Any:
    for part in path:
        settings = settings[part]
    return settings


def replace(settings: Any, path: tuple, value: Any) -> Any:
    """A copy of the settings with another value at a path."""
    if not path:
        return value
    settings = copy.copy(settings)
    settings[path[0]] = replace(settings[path[0]], path[1:], value)
    return settings


def layer_for(right: dict[str, Any], path: tuple, value: Any) -> dict[str, Any]:
    """A layer that sets another value at a path; a list is replaced as a whole."""
    numbers = [i for i, part in enumerate(path) if isinstance(part, int)]
    names = path[: numbers[0]] if numbers else path
    value = replace(get(right, names), path[len(names) :], value)
    for part in reversed(names):
        value = {part: value}
    return value


def remove(right: dict[str, Any], path: tuple) -> dict[str, Any]:
    settings = copy.deepcopy(right)
    del get(settings, path[:-1])[path[-1]]
    return settings


# ---- generated mistakes -----------------------------------------------------------------------


def missing(right: dict[str, Any]) -> Iterator[Wrong]:
    """Every required key in turn is absent."""
    for section in sections(right):
        for key in section.schema.get("required", ()):
            path = (*section.path, key)
            words = (f"config: {'.'.join(map(str, path))}: ", "missing; add it")
            yield Wrong({}, key, words, base=remove(right, path))


def misspelt(right: dict[str, Any]) -> Iterator[Wrong]:
    """The last two letters of every key in turn are exchanged; the right key is suggested."""
    for section in sections(right):
        keys = section.schema["properties"]
        for key in keys:
            typo = f"{key}s"
            if len(key) > 1 and key[-1] != key[-2]:
                typo = f"{key[:-2]}{key[-1]}{key[-2]}"
            if typo in keys:
                typo = f"{key}_"
            path = (*section.path, typo)
            layer = layer_for(right, section.path, {**section.value, typo: section.value[key]})
            yield Wrong(layer, ".".join(map(str, path)), (f"did you mean {key!r}?",))


def of_another_type(right: dict[str, Any]) -> Iterator[Wrong]:
    """Every setting in turn has a value of every wrong type."""
    for setting in walk(SCHEMA, right):
        for value in WRONG_TYPES[setting.schema["type"]]:
            nullable = setting.removable or setting.schema.get("nullable")
            if not (value is None and nullable) and value != setting.value:
                layer = layer_for(right, setting.path, value)
                yield Wrong(layer, setting.key, (f"got {value!r}; ",))


def values_out_of_range(schema: dict[str, Any]) -> Iterator[Any]:
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
        yield from BAD_FOLDERS if "~" in schema["pattern"] else BAD_NAMES
    if "enum" in schema:
        yield "none-of-them"
    if schema.get("minItems"):
        yield []
    if schema["type"] == "number" and "maximum" in schema:
        yield from (1e301, -1e301)


def out_of_range(right: dict[str, Any]) -> Iterator[Wrong]:
    """Every setting in turn violates every one of its constraints."""
    for setting in walk(SCHEMA, right):
        for value in values_out_of_range(setting.schema):
            shown = repr(value)[:50]
            yield Wrong(layer_for(right, setting.path, value), setting.key, (f"got {shown}",))
        if "minProperties" in setting.schema:
            base = replace(right, setting.path, {})
            yield Wrong({}, setting.key, ("at least 1",), base=base)
        if "maxItems" in setting.schema:
            limit = setting.schema["maxItems"]
            long = layer_for(right, setting.path, setting.value * (limit + 1))
            yield Wrong(long, setting.key, (f"at most {limit}",))


# ---- mistakes written by hand -----------------------------------------------------------------

KEYS = (
    Wrong("flatland: {reference: {zzz: 3}}", "flatland.reference.zzz", ("world, agent, exper",)),
    Wrong("flatland: {agents: {Big: {}}}", "flatland.agents.Big", ("write 'big'",)),
    Wrong("flatland: {agents: {2: {}}}", "flatland.agents", ("the key 2 is not text",)),
    Wrong('"new\\nline": 1', "new\\nline"),
    Wrong('"seed\\n": 1', "seed\\n"),
    Wrong("{a: 1, b: 2, c: 3}", "config: a", ("and 2 more",)),
    Wrong("flatland: {worlds: {furnished: {things: 3}}}", "furnished.things", ("unknown key",)),
)
VALUES = (
    Wrong("flatland: {thresholds: [0.0, -1.0]}", "flatland.thresholds.1", ("got -1.0",)),
    Wrong("flatland: {thresholds: ['0']}", "flatland.thresholds.0", ("got '0'",)),
    Wrong("flatland: {sensitivity: {lengths: [10, 0]}}", "sensitivity.lengths.1", ("got 0",)),
    Wrong("seed: .nan", "seed", ("not a finite number",)),
    Wrong("apartment: {reach: .inf}", "apartment.reach", ("not a finite number",)),
    Wrong("flatland: {thresholds: [0.0, -.inf]}", "thresholds.1", ("not a finite number",)),
    Wrong("profile: 2020-01-01", "profile", ("put it in quotes",)),
    Wrong("seed: 1e3", "seed", ("got '1e3'; write numbers without quotes and as 0.001",)),
    Wrong(f"seed: {'x' * 5000}", "seed", ("xx...",)),
)
NAMES = (
    Wrong("flatland: {reference: {world: nowhere}}", "reference.world",
          ("'nowhere'", "choose one of furnished, ")),
    Wrong("flatland: {reference: {agent: nobody}}", "reference.agent",
          ("'nobody'", "choose one of polyphemus, ")),
    Wrong("flatland: {free_space: {worlds: [nowhere]}}", "free_space.worlds", ("'nowhere'",)),
    Wrong("flatland: {free_space: {agents: [nobody]}}", "free_space.agents", ("'nobody'",)),
    Wrong("flatland: {combinations: {worlds: [nowhere]}}", "combinations.worlds"),
    Wrong("flatland: {combinations: {agents: [nobody]}}", "combinations.agents"),
    Wrong("flatland: {variants: {worlds: [nowhere]}}", "variants.worlds"),
    Wrong("flatland: {variants: {agents: [nobody]}}", "variants.agents", ("'nobody'",)),
    Wrong("flatland: {commutation: {settled_world: nowhere}}", "commutation.settled_world",
          ("'nowhere'",)),
    Wrong("apartment: {reference: {robot: nobody}}", "reference.robot"),
    Wrong("apartment: {reference: {scene: nowhere}}", "reference.scene"),
    Wrong("apartment: {robots_compared: {robots: [nobody]}}", "robots_compared.robots"),
    Wrong("apartment: {robots_compared: {scenes: [nowhere]}}", "robots_compared.scenes"),
    Wrong("apartment: {scenes_compared: {robots: [nobody]}}", "scenes_compared.robots"),
    Wrong("apartment: {scenes_compared: {scenes: [nowhere]}}", "scenes_compared.scenes"),
    Wrong("apartment: {within_reach: {robots: [nobody]}}", "within_reach.robots"),
    Wrong("apartment: {within_reach: {scenes: [nowhere]}}", "within_reach.scenes"),
    Wrong("apartment: {free_space: {robots: [nobody]}}", "free_space.robots"),
    Wrong("apartment: {free_space: {scenes: [nowhere]}}", "free_space.scenes"),
    Wrong("masks: {robot: nobody}", "masks.robot"),
    Wrong("masks: {data: {scene: nowhere}}", "masks.data.scene"),
    Wrong("masks: {tests: {scenes: [nowhere]}}", "masks.tests.scenes"),
    Wrong("masks: {map: {scene: nowhere}}", "masks.map.scene"),
    Wrong("masks: {map: {cramped_room: ballroom}}", "masks.map.cramped_room"),
    Wrong("masks: {map: {low_furniture: [throne]}}", "masks.map.low_furniture"),
    Wrong("masks: {fixed: {third_arm_joint: 0.0}}", "masks: fixed"),
    Wrong("navigation: {world: nowhere}", "navigation.world"),
    Wrong("navigation: {agent: nobody}", "navigation.agent"),
    Wrong("navigation: {scp_world: nowhere}", "navigation.scp_world"),
)  # fmt: skip
UNSUITABLE = (
    Wrong("flatland: {free_space: {worlds: [furnished]}}", "free_space.worlds", ("walls: false",)),
    Wrong("flatland: {free_space: {worlds: [things-0]}}", "free_space.worlds", ("walls",)),
    Wrong("flatland: {worlds: {free-space: {objects: 4}}}", "free_space.worlds", ("objects: 0",)),
    Wrong("flatland: {commutation: {settled_world: things-4}}", "commutation.settled_world",
          ("path_speed: 0.0",)),
    Wrong("flatland: {commutation: {settled_world: furnished}}", "commutation.settled_world",
          ("path_speed",)),
    Wrong("flatland: {worlds: {settled: {path_speed: 1.0}}}", "commutation.settled_world"),
    Wrong("flatland: {worlds: {furnished: {start_margin: 300.0}}}", "flatland.worlds.furnished",
          ("start_margin 300 leaves no place",)),
    Wrong("flatland: {worlds: {furnished: {width: 300.0}}}", "flatland.worlds.furnished",
          ("set it below 150",)),
    Wrong("flatland: {worlds: {furnished: {objects: 24, width: 200.0, height: 200.0,"
          " start_margin: 90.0}}}", "flatland.worlds.furnished"),
    Wrong("apartment: {free_space: {scenes: [rs-stand-in]}}", "free_space.scenes"),
    Wrong("masks: {data: {scene: free-space}}", "masks.data.scene"),
    Wrong("masks: {tests: {scenes: [free-space]}}", "masks.tests.scenes"),
    Wrong("masks: {map: {scene: free-space}}", "masks.map.scene"),
    Wrong("masks: {robot: jackrabbot}", "masks.robot"),
    Wrong("apartment: {reference: {robot: jackrabbot}, robots_compared: {robots: [fetch]}}",
          "masks.robot"),
    Wrong("navigation: {agent: long-arms}", "flatland.variants"),
    Wrong("navigation: {scp_world: arena}", "flatland.variants"),
    Wrong("flatland: {variants: {agents: [slow-base]}}", "navigation needs the SCP"),
)  # fmt: skip
TWICE = (
    Wrong("flatland: {variants: {agents: [polyphemus]}}", "flatland",
          ("'polyphemus' in 'furnished' is asked for by two sections",)),
    Wrong("flatland: {variants: {agents: [sprinter, sprinter]}}", "variants.agents", ("twice",)),
    Wrong("flatland: {combinations: {worlds: [things-0, things-0]}}", "combinations.worlds",
          ("twice",)),
    Wrong("flatland: {thresholds: [0.0, 1.0, 1.0]}", "thresholds", ("twice",)),
    Wrong("flatland: {sensitivity: {lengths: [10, 10]}}", "sensitivity.lengths", ("twice",)),
    Wrong("flatland: {sensitivity: {lengths: [10, 50]}}", "sensitivity.lengths",
          ("main sequence_length 50",)),
    Wrong("apartment: {robots_compared: {robots: [fetch]}}", "'fetch' in 'rs-stand-in'"),
    Wrong("apartment: {scenes_compared: {scenes: [rs-stand-in]}}", "'fetch' in 'rs-stand-in'"),
    Wrong("apartment: {thresholds: [0.0, 50.0, 50.0]}", "thresholds"),
    Wrong("apartment: {fields_of_view: [90.0, 90.0]}", "fields_of_view"),
    Wrong("apartment: {sensitivity: {lengths: [50]}}", "sensitivity.lengths"),
    Wrong("masks: {tests: {scenes: [rs-stand-in, rs-stand-in]}}", "tests.scenes"),
    Wrong("masks: {tests: {scenes: [placida-stand-in]}}", "tests.scenes"),
    Wrong("masks: {tests: {field_of_view: 45.0}}", "tests.field_of_view"),
    Wrong("navigation: {seeds: [1, 2, 3, 3]}", "seeds"),
    Wrong("navigation: {action_spaces: [full, full, truncated, adapted]}", "action_spaces"),
)  # fmt: skip
SIZES = (
    Wrong("flatland: {thresholds: [1.0, 10.0]}", "thresholds", ("must hold 0.0",)),
    Wrong("flatland: {sensitivity: {experiments: 1001}}", "sensitivity.experiments",
          ("more than reference.experiments 1000",)),
    Wrong("flatland: {baselines: {training: 10000}}", "flatland.baselines",
          ("training 10000 leaves none",)),
    Wrong("flatland: {baselines: {training: 8010}}", "baselines.training",
          ("multiples of sequence_length 50",)),
    Wrong("flatland: {baselines: {transitions: 10010}}", "baselines.transitions", ("multiples",)),
    Wrong("flatland: {sequence_length: 37}", "sequence_length"),
    Wrong("apartment: {thresholds: [20.0, 0.0, 50.0]}", "thresholds"),
    Wrong("apartment: {reference: {threshold: 51.0}}", "reference.threshold"),
    Wrong("apartment: {sensitivity: {experiments: 25}}", "sensitivity.experiments"),
    Wrong("navigation: {steps: 40961}", "steps"),
    Wrong("navigation: {checkpoints: 7}", "steps"),
    Wrong("navigation: {learner: {batch_size: 100}}", "batch_size"),
    Wrong("navigation: {learner: {batch_size: 4096}}", "batch_size"),  # more than a rollout
    Wrong("navigation: {learner: {rooms: 5}}", "batch_size"),
    Wrong("navigation: {threshold_return: 51.0}", "threshold_return"),
    Wrong("navigation: {action_spaces: [full, truncated, inverse]}", "action_spaces"),
)  # fmt: skip
ZONES = (
    Wrong("navigation: {zones: [{x: 120.0, y: 120.0, radius: 80.0, reward: 0.0}]}",
          "navigation.zones.0"),
    Wrong("navigation: {zones: [{x: 120.0, y: 120.0, radius: 80.0, reward: -1.0}]}", "zones"),
    Wrong("navigation: {zones: [{x: 20.0, y: 120.0, radius: 80.0, reward: 50.0}]}",
          "navigation.zones"),
    Wrong("navigation: {zones: [{x: 590.0, y: 120.0, radius: 80.0, reward: 50.0}]}",
          "navigation.zones"),
    Wrong("{flatland: {worlds: {arena: {start_margin: 200.0}}}, navigation:"
          " {zones: [{x: 300.0, y: 300.0, radius: 299.0, reward: 50.0}]}}", "navigation.zones"),
    Wrong("navigation: {zones: [{x: 120.0, y: 120.0, radius: 80.0, reward: 50.0},"
          " {x: 150.0, y: 120.0, radius: 80.0, reward: -50.0}]}", "zones"),
    Wrong("flatland: {worlds: {arena: {width: 300.0}}}", "navigation.zones"),
)  # fmt: skip
FILES = (
    Wrong("apartment: {robots: {fetch: {description: gone.yaml}}}", "gone.yaml"),
    Wrong("apartment: {robots: {fetch: {description: .}}}", "cannot be read"),
    Wrong(f"apartment: {{robots: {{fetch: {{description: {ROOT}/README.md}}}}}}", "README.md"),
    Wrong(f"apartment: {{robots: {{fetch: {{description: {ROOT}/config/apartments/"
          "rs-stand-in.yaml}}}", "rs-stand-in.yaml"),
    Wrong("apartment: {scenes: {rs-stand-in: {file: gone.yaml}}}", "gone.yaml"),
    Wrong(f"apartment: {{scenes: {{rs-stand-in: {{file: {ROOT}/config/robots/fetch.yaml}}}}}}",
          "kind"),
    Wrong("apartment: {weights: gone.npz}", "apartment.weights"),
    Wrong("masks: {fixed: {head_tilt_joint: 99.0}}", "masks: fixed"),
    Wrong("masks: {fixed: {shoulder_pan_joint: 0.0}}", "masks: fixed"),
    Wrong("results: ../elsewhere", "results"),
    Wrong("results: a/../../b", "results"),
    Wrong("results: -r", "results"),
    Wrong("results: layer.yaml", "'results'"),
    Wrong("results: layer.yaml/below", "'results'"),
    Wrong("results: /proc/nowhere", "'results'"),
)  # fmt: skip
BY_HAND = (*KEYS, *VALUES, *NAMES, *UNSUITABLE, *TWICE, *SIZES, *ZONES, *FILES)

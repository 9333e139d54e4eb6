"""Configuration files that nobody would write: they load, or are refused in one line.

Whatever they contain, nothing is executed or written.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from sensory_commutativity.errors import ConfigError
from sensory_commutativity.storage.yamlfile import MAX_BYTES, MAX_DEPTH, MAX_VALUES, read_yaml
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import load, validate
from tests.helpers import DEFAULT, ROOT

EXAMPLES = int(os.environ.get("FUZZ_EXAMPLES", "200"))
"""Of each kind; FUZZ_EXAMPLES=5000 searches longer."""
SETTINGS = load(
    DEFAULT, ROOT / "config" / "atlas.yaml", ROOT / "config" / "gallery.yaml"
).model_dump(mode="json")
TOKENS = [
    "a: ", "seed: ", "- ", "[", "]", "{", "}", "&a ", "*a", "<<: ", "? ", "!!int ",
    "!!python/name:os.system ", "'", '"', "|", ">", "\n", "\n  ", "---", "%YAML 1.1\n", "#", "1",
    "1:2", "2020-13-13", ".nan", "0x", "\t", "\0", "é", "\ud7ff", "\u2028", ", ", ": ",
]  # fmt: skip
"""Parts of YAML."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("fuzz")


def refusal(act: Callable[[], Any]) -> str | None:
    """The message of the ConfigError that `act` raises, or None; no other exception is caught."""
    try:
        act()
    except ConfigError as error:
        message = str(error)
        assert message and len(message.splitlines()) == 1 and len(message) < 700
        return message
    return None


def load_bytes(folder: Path, content: bytes) -> str | None:
    """The refusal of a file with this content; no other file may be written."""
    file = folder / "fuzz.yaml"
    file.write_bytes(content)
    before = sorted(folder.iterdir())
    message = refusal(lambda: load(file))
    assert sorted(folder.iterdir()) == before
    return message


@settings(max_examples=EXAMPLES)
@given(content=st.binary(max_size=200))
def test_any_bytes_are_refused_in_one_line(folder, content):
    assert load_bytes(folder, content)


@settings(max_examples=EXAMPLES)
@given(content=st.text(max_size=200) | st.lists(st.sampled_from(TOKENS), max_size=25).map("".join))
def test_any_text_is_refused_in_one_line(folder, content):
    assert load_bytes(folder, content.encode("utf-8", "surrogatepass"))


def list_paths(value: Any, path: tuple = ()) -> list[tuple]:
    """Paths of all values, and of all mappings and lists."""
    items: Any = ()
    if isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list):
        items = enumerate(value)
    return [path, *(p for key, inner in items for p in list_paths(inner, (*path, key)))]


def replace(settings: Any, path: tuple, value: Any) -> Any:
    """A copy of the settings with another value at a path."""
    if not path:
        return value
    settings = settings.copy()
    settings[path[0]] = replace(settings[path[0]], path[1:], value)
    return settings


scalars = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.integers(-(2**2000), 2**2000)
    | st.floats()
    | st.text(max_size=30)
    | st.dates()
)
values = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.text(max_size=8) | st.integers(), inner, max_size=4)
    ),
    max_leaves=8,
)


@settings(max_examples=EXAMPLES)
@given(path=st.sampled_from(list_paths(SETTINGS)), value=values)
def test_any_value_anywhere_loads_or_is_refused_in_one_line(path, value):
    configs = []
    if refusal(lambda: configs.append(validate(replace(SETTINGS, path, value)))) is None:
        assert isinstance(configs[0], Config)
        assert validate(configs[0].model_dump(mode="json")) == configs[0]


MALFORMED = {
    "nothing is executed": (
        b"seed: !!python/object/apply:os.system ['touch executed']",
        "not valid YAML in line 1",
    ),
    "nothing is imported": (b"seed: !!python/module:antigravity", "not valid YAML"),
    "no object is constructed": (b"seed: !!python/object/new:type [a, [], {}]", "not valid YAML"),
    "a key twice": (
        b"seed: 1\nprofile: a\nseed: 2",
        "in line 3: the key 'seed' is already in line 1",
    ),
    "a key twice, quoted": (b"seed: 1\n'seed': 2", "in line 2: the key 'seed'"),
    "a key twice, inside": (b"flatland: {rest_steps: 3, rest_steps: 4}", "the key 'rest_steps'"),
    "aliases of aliases": (
        b"a: &a [x,x,x,x,x,x,x,x,x]\n"
        + b"".join(
            b"%c: &%c [%s]\n" % (98 + i, 98 + i, b",".join([b"*%c" % (97 + i)] * 9))
            for i in range(20)
        ),
        "aliases that stand for more than",
    ),
    "merged aliases": (
        b"a: &a {x: 1}\n"
        + b"".join(
            b"%c: &%c {<<: [%s]}\n" % (98 + i, 98 + i, b",".join([b"*%c" % (97 + i)] * 9))
            for i in range(20)
        ),
        "aliases that stand for more than",
    ),
    "aliases in a chain": (
        b"a0: &a0 [1]\n" + b"".join(b"a%d: &a%d [*a%d]\n" % (i, i, i - 1) for i in range(1, 200)),
        f"aliases that stand for more than {MAX_DEPTH} levels",
    ),
    "a list that contains itself": (b"seed: &a [*a]", "a value that contains itself"),
    "a mapping that contains itself": (
        b"flatland: &a {agents: *a}",
        "a value that contains itself",
    ),
    "deep lists": (b"seed: " + b"[" * 20_000, f"more than {MAX_DEPTH} levels"),
    "deep mappings": (b"{a: " * 20_000, f"more than {MAX_DEPTH} levels"),
    "deep by indentation": (
        b"".join(b" " * i + b"a:\n" for i in range(300)),
        f"more than {MAX_DEPTH} levels",
    ),
    "very many values": (b"seed: [" + b"1," * MAX_VALUES + b"]", "more than 20,000 values"),
    "a very large file": (b"#" * (MAX_BYTES + 1), "more than 1,000,000 bytes"),
    "a zero byte": (b"seed: 1\0", "not valid YAML"),
    "a zero byte, escaped": (b'results: "a\\0b"', "config.results"),
    "a lone surrogate": (b'profile: "\\ud800"', "config.profile"),
    "a lone surrogate in a key": (b'"\\ud800": 1', "the key"),
    "bytes that are not UTF-8": (b"profile: \xff", "cannot be read"),
    "UTF-16": ("seed: 1".encode("utf-16"), "cannot be read"),
    "a number of 5000 digits": (b"seed: " + b"9" * 5000, "not a valid int"),
    "a number of 20000 bits": (b"seed: 0x" + b"f" * 5000, "config.seed: a number of 20000 bits"),
    "more than a float holds": (
        b"navigation: {threshold_return: 1" + b"0" * 400 + b"}",
        "config.navigation.threshold_return",
    ),
    "not a number": (b"seed: .nan", "config.seed: nan"),
    "an infinite number": (b"seed: 1.0e+400", "config.seed: inf"),
    "an impossible date": (b"seed: 2020-99-99", "not a valid timestamp"),
    "a tagged text that is no number": (b"seed: !!int x", "not a valid int"),
    "a tagged number without digits": (b"seed: !!int ", "not a valid int"),
    "a date outside of the calendar": (b"seed: 0001-01-01 00:00:00 +23:00", "config.seed"),
    "a hexadecimal number without digits": (b"seed: 0x_", "not a valid int"),
    "a tagged text that is no boolean": (b"seed: !!bool x", "not a valid bool"),
    "a set": (b"seed: !!set {a, b}", "config.seed"),
    "a list as a key": (b"? [a]\n: 1", "not valid YAML"),
    "two documents": (b"seed: 1\n---\nseed: 2", "not valid YAML"),
    "an empty file": (b"", "expected a mapping"),
    "a list": (b"- a\n- b\n", "expected a mapping"),
    "a text": (b"text", "expected a mapping"),
    "a bracket that is not closed": (b"seed: [1\n", "not valid YAML in line"),
    "two colons": (b"a: b: c\n", "not valid YAML in line 1"),
    "a date": (b"seed: 2020-01-01\n", "config.seed: datetime.date(2020, 1, 1) is a date"),
    "a key that is not text": (b"1: 2\n", "the key 1 is not text"),
}
"""Name -> content of a file, and what the message says."""


def test_malformed_files_are_refused_in_one_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # where a file that is created by an executed command would appear
    file = Path("malformed.yaml")
    for name, (content, words) in MALFORMED.items():
        file.write_bytes(content)
        message = refusal(lambda: load(file))
        assert message is not None and words in message, f"{name}: {message}"
        if any(problem in words for problem in ("not valid", "cannot be read", "a mapping")):
            assert message.startswith("malformed.yaml: "), f"{name}: {message}"
        assert [path.name for path in tmp_path.iterdir()] == ["malformed.yaml"], name


def test_absent_unreadable_and_endless_files_are_refused(tmp_path):
    absent = tmp_path / "absent.yaml"
    assert "absent.yaml: there is no such file; give the path" in refusal(lambda: load(absent))
    assert "cannot be read" in refusal(lambda: load(tmp_path))
    assert "a device, not a regular file" in refusal(lambda: load("/dev/zero"))
    file = tmp_path / "secret.yaml"
    file.write_text("seed: 1")
    file.chmod(0)
    if not os.access(file, os.R_OK):  # root may read everything
        assert "cannot be read" in refusal(lambda: load(file))


def test_common_features_of_yaml_work(tmp_path):
    """Anchors, merged mappings, and the same key in different mappings."""
    file = tmp_path / "good.yaml"
    file.write_text(
        "a: &a {x: 1, y: 2}\nb: {<<: *a, x: 3}\nc: [*a, *a]\nd: 2020-01-01\n"
        "e: {1: a, '1': b}\nf: '='\n"
    )
    content = read_yaml(file, ConfigError, "a file")
    assert content == yaml.safe_load(file.read_text())
    assert content["b"] == {"x": 3, "y": 2} and content["c"][0] == {"x": 1, "y": 2}
    assert math.isclose(read_yaml(DEFAULT, ConfigError, "a file")["apartment"]["reach"], 0.15)

"""Configuration files that nobody would write by hand: whatever they hold, they load, or are refused in one line. Nothing is executed or written."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.helpers import DEFAULT

from sensory_commutativity.errors import ConfigError
from sensory_commutativity.storage.yamlfile import MAX_BYTES, MAX_DEPTH, MAX_VALUES, read_yaml
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import load, validate

EXAMPLES = int(os.environ.get("FUZZ_EXAMPLES", "200"))
"""Of each kind; FUZZ_EXAMPLES=5000 looks further."""

SETTINGS = load(DEFAULT).model_dump(mode="json")


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("strange")


def refusal(act) -> str | None:
    """The one line with which a ConfigError refuses, None where there is none; any other exception is a failure."""
    try:
        act()
    except ConfigError as error:
        message = str(error)
        assert message and len(message.splitlines()) == 1 and len(message) < 700
        return message
    return None


def loaded(folder: Path, content: bytes) -> Any:
    file = folder / "strange.yaml"
    file.write_bytes(content)
    before = sorted(folder.iterdir())
    message = refusal(lambda: load(file))
    assert sorted(folder.iterdir()) == before
    return message


TOKENS = [
    "a: ",
    "seed: ",
    "- ",
    "[",
    "]",
    "{",
    "}",
    "&a ",
    "*a",
    "<<: ",
    "? ",
    "!!int ",
    "!!python/name:os.system ",
    "'",
    '"',
    "|",
    ">",
    "\n",
    "\n  ",
]
TOKENS += [
    "---",
    "%YAML 1.1\n",
    "#",
    "1",
    "1:2",
    "2020-13-13",
    ".nan",
    "0x",
    "\t",
    "\0",
    "é",
    "\ud7ff",
    "\u2028",
    ", ",
    ": ",
]


@settings(max_examples=EXAMPLES)
@given(content=st.binary(max_size=200))
def test_any_bytes_are_refused_in_one_line(folder, content):
    assert loaded(folder, content)


@settings(max_examples=EXAMPLES)
@given(content=st.text(max_size=200) | st.lists(st.sampled_from(TOKENS), max_size=25).map("".join))
def test_any_text_is_refused_in_one_line(folder, content):
    assert loaded(folder, content.encode("utf-8", "surrogatepass"))


def paths(value: Any, path: tuple = ()) -> list[tuple]:
    """Where there is a value."""
    inner = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    return [path, *(found for key, below in inner for found in paths(below, (*path, key)))]


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


def replaced(settings: Any, path: tuple, value: Any) -> Any:
    if not path:
        return value
    if isinstance(settings, dict):
        return {**settings, path[0]: replaced(settings[path[0]], path[1:], value)}
    return [
        replaced(one, path[1:], value) if i == path[0] else one for i, one in enumerate(settings)
    ]


@settings(max_examples=EXAMPLES)
@given(path=st.sampled_from(paths(SETTINGS)), value=values)
def test_any_value_anywhere_loads_or_is_refused_in_one_line(path, value):
    found = []
    if refusal(lambda: found.append(validate(replaced(SETTINGS, path, value)))) is None:
        assert isinstance(found[0], Config)
        assert validate(found[0].model_dump(mode="json")) == found[0]


STRANGE = {
    "nothing is executed": (
        b"seed: !!python/object/apply:os.system ['touch executed']",
        "not valid YAML in line 1",
    ),
    "nothing is imported": (b"seed: !!python/module:antigravity", "not valid YAML"),
    "objects are not made": (b"seed: !!python/object/new:type [a, [], {}]", "not valid YAML"),
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
    "itself in a list": (b"seed: &a [*a]", "a value that contains itself"),
    "itself in a mapping": (b"flatland: &a {agents: *a}", "a value that contains itself"),
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
    "half a character": (b'profile: "\\ud800"', "config.profile"),
    "half a character in a key": (b'"\\ud800": 1', "the key"),
    "bytes that are no UTF-8": (b"profile: \xff", "cannot be read"),
    "UTF-16": ("seed: 1".encode("utf-16"), "cannot be read"),
    "a number of 5000 digits": (b"seed: " + b"9" * 5000, "not a valid int"),
    "a number of 20000 bits": (b"seed: 0x" + b"f" * 5000, "config.seed: a number of 20000 bits"),
    "more than a float holds": (
        b"navigation: {threshold_return: 1" + b"0" * 400 + b"}",
        "config.navigation.threshold_return",
    ),
    "no number": (b"seed: .nan", "config.seed: nan"),
    "an infinite number": (b"seed: 1.0e+400", "config.seed: inf"),
    "a date that is none": (b"seed: 2020-99-99", "not a valid timestamp"),
    "a number that is none": (b"seed: !!int x", "not a valid int"),
    "a number without digits": (b"seed: !!int ", "not a valid int"),
    "a date beyond all time": (b"seed: 0001-01-01 00:00:00 +23:00", "config.seed"),
    "digits of no number": (b"seed: 0x_", "not a valid int"),
    "a truth that is none": (b"seed: !!bool x", "not a valid bool"),
    "a set": (b"seed: !!set {a, b}", "config.seed"),
    "a list for a key": (b"? [a]\n: 1", "not valid YAML"),
    "two documents": (b"seed: 1\n---\nseed: 2", "not valid YAML"),
    "nothing": (b"", "expected a mapping"),
}


@pytest.mark.parametrize(("content", "says"), STRANGE.values(), ids=STRANGE.keys())
def test_a_strange_file_is_refused_in_one_line(tmp_path, monkeypatch, content, says):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "strange.yaml").write_bytes(content)
    message = refusal(lambda: load("strange.yaml"))
    assert message is not None and says in message
    assert [path.name for path in tmp_path.iterdir()] == [
        "strange.yaml"
    ]  # above all no file that an executed command would have made


def test_a_folder_and_a_file_without_end_are_refused(tmp_path):
    assert "cannot be read" in refusal(lambda: load(tmp_path))
    assert "more than 1,000,000 bytes" in refusal(lambda: load("/dev/zero"))


def test_what_yaml_is_used_for_still_works(tmp_path):
    """Anchors, merged mappings, and the same key in different mappings."""
    file = tmp_path / "good.yaml"
    file.write_text(
        "a: &a {x: 1, y: 2}\nb: {<<: *a, x: 3}\nc: [*a, *a]\nd: 2020-01-01\ne: {1: a, '1': b}\nf: '='\n"
    )
    found = read_yaml(file, ConfigError, "a file")
    assert found == yaml.safe_load(file.read_text())
    assert found["b"] == {"x": 3, "y": 2} and found["c"][0] == {"x": 1, "y": 2}
    assert math.isclose(read_yaml(DEFAULT, ConfigError, "a file")["apartment"]["reach"], 0.15)


def test_a_file_that_must_not_be_read_is_refused(tmp_path):
    file = tmp_path / "secret.yaml"
    file.write_text("seed: 1")
    file.chmod(0)
    if os.access(file, os.R_OK):
        pytest.skip("this user may read everything")
    assert "cannot be read" in refusal(lambda: load(file))

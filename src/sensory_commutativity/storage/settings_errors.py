"""Error messages for settings: one line with the key, what is wrong, and the remedy."""

from __future__ import annotations

import difflib
import math
import re
from types import UnionType
from typing import Any

from pydantic import BaseModel, ValidationError

from ..errors import ConfigError
from .settings import NAME_PATTERN

MAX_INTEGER = 10**300
"""Chosen: larger integers overflow to infinity in floating-point arithmetic."""
MAX_SHOWN = 60
"""Characters of a value that a message shows; chosen: so that the message fits on a line or two."""

_NUMBERS = ("int", "float", "finite", "greater", "less", "multiple")
"""Beginnings of pydantic's error types that concern numbers."""


def check_json_value(value: Any, key: str) -> None:
    """Check that a value read from YAML consists of what JSON can express.

    YAML also has dates, infinities, integers of any size, keys that are not text, and text that no
    file name can contain.

    Raises
    ------
    ConfigError
        With the key of the value, which starts with `key`.
    """
    if isinstance(value, dict):
        for name, inner in value.items():
            if not isinstance(name, str):
                raise ConfigError(
                    f"{key}: the key {_shorten(name)} is not text; put it in quotes or remove it"
                )
            _check_text(name, f"{key}: the key")
            check_json_value(inner, f"{key}.{_escape(name)}")
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            check_json_value(inner, f"{key}.{i}")
    elif not (value is None or isinstance(value, str | bool | int | float)):
        raise ConfigError(
            f"{key}: {_shorten(value)} is a {type(value).__name__}; "
            "put it in quotes if it is meant as text"
        )
    elif isinstance(value, str):
        _check_text(value, f"{key}:")
    elif isinstance(value, int) and abs(value) > MAX_INTEGER:
        raise ConfigError(
            f"{key}: a number of {value.bit_length()} bits is too large; set a smaller one"
        )
    elif isinstance(value, float) and not math.isfinite(value):
        raise ConfigError(
            f"{key}: {value!r} is not a finite number; "
            "set a finite one, or null where the key allows it"
        )


def _check_text(text: str, where: str) -> None:
    """Reject lone surrogates, which cannot be encoded, and zero bytes, which no path can have."""
    if "\0" in text or any("\ud800" <= letter <= "\udfff" for letter in text):
        raise ConfigError(
            f"{where} {_shorten(text)} contains a zero byte or half a character; remove it"
        )


def explain(error: ValidationError, root: type[BaseModel]) -> str:
    """Describe in one line the first problem that pydantic found in settings of the model `root`.

    The line is ``config: KEY: PROBLEM; REMEDY (and N more)``.
    """
    problems = error.errors(include_url=False)
    first = problems[0]
    key = ".".join(str(part) for part in first["loc"] if part != "[key]") or "config"
    if first["type"] == "extra_forbidden":
        message = f"unknown key; {_suggest(first['loc'], root)}"
    elif first["type"] == "missing":
        message = "this key is missing; add it (see config/README.md)"
    elif first["type"] == "value_error":
        message = str(first["ctx"]["error"])
    else:
        expected = f"{first['msg'][0].lower()}{first['msg'][1:]}"
        remedy = "set such a value"
        if first["type"] == "string_pattern_mismatch" and first["ctx"]["pattern"] == NAME_PATTERN:
            expected = "names consist of lower-case letters, digits and hyphens"
            remedy = f"write {_suggest_name(str(first['input']))!r}, for example"
        elif isinstance(first["input"], str) and first["type"].startswith(_NUMBERS):
            remedy = "write numbers without quotes and as 0.001 or 1.0e-3"
        message = f"{expected}, got {_shorten(first['input'])}; {remedy} (see config/README.md)"
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    return f"config: {_escape(key)}: {message}{more}"


def _escape(key: str) -> str:
    """Write a key with any characters on one line."""
    return key.encode("unicode_escape").decode("ascii") if not key.isprintable() else key


def _shorten(value: Any) -> str:
    try:
        text = repr(value)
    except ValueError:  # Python converts no integer of more than 4300 digits
        text = f"a {type(value).__name__} of very many digits"
    return text if len(text) <= MAX_SHOWN else text[: MAX_SHOWN - 3] + "..."


def _suggest_name(text: str) -> str:
    """The valid name that is most like a text."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:40].strip("-") or "name"


def _suggest(location: tuple[str | int, ...], root: type[BaseModel]) -> str:
    """Suggest a known key for the unknown one at `location`."""
    model: Any = root
    for part in location[:-1]:
        if isinstance(model, type) and issubclass(model, BaseModel):
            model = _without_none(model.model_fields[str(part)].annotation)
        elif getattr(model, "__args__", None):
            model = model.__args__[-1]
    is_model = isinstance(model, type) and issubclass(model, BaseModel)
    keys = list(model.model_fields) if is_model else []
    close = difflib.get_close_matches(str(location[-1]), keys, 1)
    return f"did you mean {close[0]!r}?" if close else f"known here are {', '.join(keys)}"


def _without_none(annotation: Any) -> Any:
    """The section in the annotation of an optional one, ``Section | None``."""
    parts = [part for part in getattr(annotation, "__args__", ()) if part is not type(None)]
    return parts[0] if isinstance(annotation, UnionType) and len(parts) == 1 else annotation

"""Telling a person what is wrong with a configuration: one line, the key, the remedy."""

from __future__ import annotations

import difflib
import math
from typing import Any

from pydantic import BaseModel, ValidationError

from ..errors import ConfigError

LARGEST = 10**300
"""Whole numbers beyond it become infinite where they are calculated with."""


def refuse_what_json_has_not(value: Any, key: str) -> None:
    """YAML knows dates, infinities, numbers without end, keys that are no text and texts that no file can hold; a configuration may not hold them."""
    if isinstance(value, dict):
        for name, inner in value.items():
            if not isinstance(name, str):
                raise ConfigError(
                    f"{key}: the key {_short(name)} is no text; put it in quotes or remove it"
                )
            _refuse_strange_text(name, f"{key}: the key")
            refuse_what_json_has_not(inner, f"{key}.{_line(name)}")
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            refuse_what_json_has_not(inner, f"{key}.{i}")
    elif not (value is None or isinstance(value, str | bool | int | float)):
        raise ConfigError(
            f"{key}: {_short(value)} is a {type(value).__name__}; put it in quotes if it is meant as text"
        )
    elif isinstance(value, str):
        _refuse_strange_text(value, f"{key}:")
    elif isinstance(value, int) and abs(value) > LARGEST:
        raise ConfigError(
            f"{key}: a number of {value.bit_length()} bits is too large; set a smaller one"
        )
    elif isinstance(value, float) and not math.isfinite(value):
        raise ConfigError(
            f"{key}: {value!r} is not a finite number; set a finite one, or null where the key allows it"
        )


def _refuse_strange_text(text: str, where: str) -> None:
    """Half a character (a lone surrogate) cannot be written, and no name of a file holds a zero byte."""
    if "\0" in text or any("\ud800" <= letter <= "\udfff" for letter in text):
        raise ConfigError(
            f"{where} {_short(text)} holds a zero byte or half a character; take it out"
        )


def explain(error: ValidationError, root: type[BaseModel]) -> str:
    """One line for the first problem that pydantic found in a configuration of the model `root`: the key, what is wrong, the remedy."""
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
        remedy = (
            "write numbers without quotes and as 0.001 or 1.0e-3"
            if isinstance(first["input"], str)
            else "set such a value"
        )
        message = f"{first['msg'][0].lower()}{first['msg'][1:]}, got {_short(first['input'])}; {remedy} (see config/README.md)"
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    return f"config: {_line(key)}: {message}{more}"


def _line(key: str) -> str:
    """A key on one line, whatever it holds."""
    return key.encode("unicode_escape").decode("ascii") if not key.isprintable() else key


def _short(value: Any) -> str:
    try:
        text = repr(value)
    except ValueError:  # Python writes no whole number of more than 4300 digits
        text = f"a {type(value).__name__} of very many digits"
    return text if len(text) <= 60 else text[:57] + "..."


def _suggest(location: tuple[str | int, ...], root: type[BaseModel]) -> str:
    """What the unknown key at `location` may have been meant to be."""
    model: Any = root
    for part in location[:-1]:
        if isinstance(model, type) and issubclass(model, BaseModel):
            model = model.model_fields[str(part)].annotation
        elif getattr(model, "__args__", None):
            model = model.__args__[-1]
    known = (
        list(model.model_fields) if isinstance(model, type) and issubclass(model, BaseModel) else []
    )
    close = difflib.get_close_matches(str(location[-1]), known, 1)
    return f"did you mean {close[0]!r}?" if close else f"known here are {', '.join(known)}"

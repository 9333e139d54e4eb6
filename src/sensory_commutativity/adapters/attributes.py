"""The state of Python objects: what plain attributes and random generators hold, and back again."""

from __future__ import annotations

import copy
import random
import types
from collections import deque
from collections.abc import Callable
from enum import Enum
from typing import Any

import numpy as np

MAX_DEPTH = 12
"""Levels of attributes that are followed. Chosen: wrappers, environment, robot, task."""
_PLAIN = (
    type(None), bool, int, float, complex, str, bytes, np.generic, np.dtype, Enum, type, range,
    slice, types.ModuleType,
)  # fmt: skip
_OPAQUE = (
    "gymnasium.spaces", "gymnasium.envs.registration", "gymnasium.envs.mujoco.mujoco_rendering",
    "mujoco", "dm_control.mjcf", "dm_control.mujoco", "dm_env.specs", "pygame", "Box2D",
)  # fmt: skip
"""Modules whose objects hold no state of their own, or state that Python cannot read."""


def record(value: Any, seen: dict[int, Any], depth: int) -> Callable[[], Any]:
    """A function that gives `value` back in its present state.

    What can change is changed in place, so that views and shared references hold. `seen` keeps the
    objects, so that no other gets the same id.
    """
    if isinstance(value, _PLAIN) or id(value) in seen or depth > MAX_DEPTH:
        return lambda: value
    seen[id(value)] = value
    if isinstance(value, np.random.Generator):
        return _record_generator(value)
    if isinstance(value, np.random.RandomState):
        return _record_legacy_generator(value)
    if isinstance(value, np.ndarray) and value.dtype != object:
        return _record_array(value)
    if isinstance(value, random.Random):
        kept = value.getstate()
        return lambda: (value.setstate(kept), value)[1]  # type: ignore[func-returns-value]
    if isinstance(value, set):
        return _record_set(value)
    if isinstance(value, list | deque):
        return _record_list(value, seen, depth)
    if isinstance(value, tuple):
        parts = [record(part, seen, depth + 1) for part in value]
        return lambda: ([part() for part in parts], value)[1]
    return _record_attributes(value, seen, depth)


def _record_generator(value: np.random.Generator) -> Callable[[], Any]:
    state = copy.deepcopy(value.bit_generator.state)

    def restore() -> np.random.Generator:
        value.bit_generator.state = state
        return value

    return restore


def _record_legacy_generator(value: np.random.RandomState) -> Callable[[], Any]:
    state = value.get_state()

    def restore() -> np.random.RandomState:
        value.set_state(state)
        return value

    return restore


def _record_array(value: np.ndarray) -> Callable[[], Any]:
    if not value.flags.writeable:
        return lambda: value
    content = value.copy()

    def restore() -> np.ndarray:
        np.copyto(value, content)
        return value

    return restore


def _record_set(value: set) -> Callable[[], Any]:
    content = set(value)

    def restore() -> set:
        value.clear()
        value.update(content)
        return value

    return restore


def _record_list(value: Any, seen: dict[int, Any], depth: int) -> Callable[[], Any]:
    parts = [record(part, seen, depth + 1) for part in value]

    def restore() -> Any:
        new = [part() for part in parts]
        value.clear()
        value.extend(new)
        return value

    return restore


def _record_attributes(value: Any, seen: dict[int, Any], depth: int) -> Callable[[], Any]:
    held = value if isinstance(value, dict) else getattr(value, "__dict__", None)
    function = callable(value) and not hasattr(value, "step")
    if held is None or type(value).__module__.startswith(_OPAQUE) or function:
        return lambda: value
    items = {key: record(part, seen, depth + 1) for key, part in held.items()}

    def restore() -> Any:
        new = {key: part() for key, part in items.items()}
        for key in [key for key in held if key not in new]:
            del held[key]
        held.update(new)
        return value

    return restore

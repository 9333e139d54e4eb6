"""Checks of the content of a predictor file before it is used.

A network whose weights are not numbers calls every pair identical, and one that refines its masks a
billion times never ends.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import torch
from torch import nn

from .decision import REFERENCE_AREA, DecisionThresholds

MAX_CHANNELS = 512
"""Largest number of channels; chosen: five times that of our models."""
MAX_REPEATS = 32
"""Most updates, levels, and pixels of a radius; chosen: RAFT's authors use at most 32 updates."""
_REPEATS = ("updates", "levels", "radius")
_LIST_LENGTHS = {"widths": 5}

Network = TypeVar("Network", bound=nn.Module)


def read_thresholds(values: Any) -> DecisionThresholds:
    """Decision thresholds from what a file holds. Raises ValueError."""
    if not isinstance(values, list | tuple) or len(values) != len(DecisionThresholds._fields):
        raise ValueError("expected three decision thresholds")
    limits = (1.0, 1.0, 2.0 * REFERENCE_AREA)
    for name, value, limit in zip(DecisionThresholds._fields, values, limits, strict=True):
        if not _is_number(value) or not 0 <= value <= limit:
            raise ValueError(f"the threshold {name} is {value!r:.40}, not between 0 and {limit:g}")
    return DecisionThresholds(*map(float, values))


def build_network(network_class: Callable[..., Network], packed: Any) -> Network:
    """Build a network from its architecture and weights.

    The architecture is bounded, and the network is first built without memory to compare the
    shapes of its weights with those in the file.

    Raises
    ------
    ValueError, KeyError, TypeError, RuntimeError
        If they do not fit, or if a weight is not a finite number.
    """
    architecture, stored = packed["architecture"], packed["weights"]
    check_architecture(architecture)
    with torch.device("meta"):
        expected = network_class(**architecture).state_dict()
    check_weights(stored, expected)
    network = network_class(**architecture)
    network.load_state_dict(
        {key: v.float() if v.is_floating_point() else v for key, v in stored.items()}
    )
    return network


def check_architecture(architecture: Any) -> None:
    """Raise ValueError if an argument of a network is of another kind, or too large."""
    if not isinstance(architecture, dict):
        raise ValueError("its architecture is no mapping of names to numbers")
    for name, value in architecture.items():
        if isinstance(value, list | tuple):
            whole = len(value) == _LIST_LENGTHS.get(name) and all(type(v) is int for v in value)
            valid = whole and all(1 <= v <= MAX_CHANNELS for v in value)
        elif name == "scale":
            valid = _is_number(value) and 0 < value <= 1
        else:
            limit = MAX_REPEATS if name in _REPEATS else MAX_CHANNELS
            valid = type(value) is int and 1 <= value <= limit
        if not valid:
            raise ValueError(f"its architecture has {name!s:.40} = {value!r:.40}")


def check_weights(stored: Any, expected: Mapping[str, torch.Tensor]) -> None:
    """Raise ValueError if weights are missing, of another shape, or not finite."""
    if not isinstance(stored, dict) or stored.keys() != expected.keys():
        raise ValueError("its weights are those of another network")
    for key, weight in stored.items():
        if not isinstance(weight, torch.Tensor) or weight.shape != expected[key].shape:
            raise ValueError(f"the weights {key:.60} have another shape")
        if weight.dtype.is_complex or not torch.isfinite(weight).all():
            raise ValueError(f"the weights {key:.60} are not all finite numbers")
        if key.endswith("running_var") and bool((weight < 0).any()):
            raise ValueError(f"the variances {key:.60} are negative")


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value)

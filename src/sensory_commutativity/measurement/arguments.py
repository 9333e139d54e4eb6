"""Checks of the arguments of :func:`.measure.measure`; messages begin with the argument's name."""

from __future__ import annotations

import difflib
import math
import numbers
from typing import Any

import numpy as np

from ..errors import ArgumentError
from ..scp.distances import Distance, mean_squared_error
from ..scp.experiment import Outcome, compare_orders, orders_per_dof
from ..scp.world import World
from ..seeding import generator

DISTANCES = ("mse", "scaled", "vgg16")
"""Names that `distance` may have."""


def check_whole_number(name: str, value: Any, least: int, most: int = 2**63 - 1) -> int:
    """Return `value` as an int. Raises ArgumentError if it is not a whole number in range."""
    whole = isinstance(value, numbers.Integral) and not isinstance(value, bool | np.bool_)
    if not whole or not least <= value <= most:
        limit = f"at least {least}" if most == 2**63 - 1 else f"from {least} to {most}"
        raise ArgumentError(f"{name}: expected a whole number, {limit}; got {value!r}")
    return int(value)


def default_thresholds(distance: str) -> tuple[float, ...]:
    """Thresholds for a distance: .1 and .01 of the spread of the sensors, or 0."""
    return (0.1, 0.01) if distance == "scaled" else (0.0,)


def check_thresholds(thresholds: Any) -> tuple[float, ...]:
    """Return the thresholds as floats, in the order given. Raises ArgumentError."""
    if isinstance(thresholds, numbers.Real):
        thresholds = (thresholds,)
    try:
        values = tuple(float(threshold) for threshold in thresholds)
    except (TypeError, ValueError):
        raise ArgumentError(
            f"thresholds: expected numbers, got {thresholds!r}; write e.g. thresholds=(0, 10)"
        ) from None
    if not values or not all(math.isfinite(value) and value >= 0 for value in values):
        raise ArgumentError(f"thresholds: expected numbers of at least 0, got {thresholds!r}")
    if len(set(values)) < len(values):
        raise ArgumentError(f"thresholds: {thresholds!r} holds a number twice; leave it out once")
    return values


def resolve_distance(distance: str | Distance | None, world: Any) -> tuple[str, Distance]:
    """Name and function of a distance, for a world.

    By default ``scaled`` for a world whose sensors have units, such as a Gymnasium environment, and
    ``mse`` for others.

    Raises
    ------
    ArgumentError
        If there is no distance of this name.
    MissingExtraError
        If it needs an extra that is not installed.
    """
    if callable(distance):
        return getattr(distance, "__qualname__", type(distance).__name__), distance
    scaled = getattr(world, "distance", None)
    images = getattr(world, "observes_images", False)
    if distance is None:
        distance = "scaled" if scaled is not None and not images else "mse"
    if distance == "scaled":
        if scaled is None or images:
            raise ArgumentError(
                "distance: scaled needs a world whose sensors have units, such as a Gymnasium "
                "environment without images; choose mse"
            )
        return "scaled", scaled
    if distance == "mse":
        return "mse", mean_squared_error
    if distance == "vgg16":
        return "vgg16", _vgg16_distance()
    near = difflib.get_close_matches(str(distance), DISTANCES, 1, 0.4)
    hint = f"did you mean {near[0]!r}? " if near else ""
    raise ArgumentError(
        f"distance: there is no distance {distance!r}; {hint}choose one of {', '.join(DISTANCES)}, "
        "or give a function of two observations"
    )


def _vgg16_distance() -> Distance:
    from ..extras import extra_needed

    with extra_needed("change-detection"):
        from ..perceptual.features import PerceptualFeatures
        from ..perceptual.weights import load_vgg16_weights

        features = PerceptualFeatures(load_vgg16_weights(None))

    def vgg16(first: np.ndarray, second: np.ndarray) -> float:
        """Squared distance of VGG16 features; the largest, if there are several cameras."""
        if first.dtype != np.uint8 or first.ndim not in (3, 4) or first.shape[-1] != 3:
            raise ArgumentError(
                "distance: vgg16 compares RGB images, uint8 (height, width, 3); the observations "
                f"are {first.dtype} {first.shape}; choose mse"
            )
        pairs = (first, second) if first.ndim == 4 else (first[None], second[None])
        return float(features.distances(*pairs).max())

    return vgg16


def try_distance(world: World, distance: Distance, seed: int, length: int, rest_steps: int) -> None:
    """Play one experiment, and check that `distance` returns numbers of at least 0.

    Raises
    ------
    ArgumentError
    """
    world.reset(generator(seed, "situation"))
    start = world.snapshot()
    _, sequence, permuted = next(iter(orders_per_dof(world, seed, length, start)))
    outcome: Outcome = compare_orders(world, start, sequence, permuted, rest_steps)
    for first, second in ((outcome.first, outcome.second), (outcome.first, outcome.first)):
        value = distance(first, second)
        if not isinstance(value, numbers.Real) or not value >= 0:  # also refuses NaN
            raise ArgumentError(
                f"distance: expected a number of at least 0, got {value!r} for two observations "
                f"{first.dtype} {first.shape}; correct the function"
            )
    if value != 0:
        raise ArgumentError(
            f"distance: expected 0 for two equal observations, got {value!r}; correct the function"
        )

"""Equivalence of action sequences, and what is left when two do not commute (paper, sections II-B and II-C)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .distances import Distance, mean_squared_error
from .experiment import REST_STEPS, compare_orders
from .sequences import compose
from .world import Snapshot, World


def equivalent(
    world: World,
    start: Snapshot,
    h: np.ndarray,
    g: np.ndarray,
    distance: Distance = mean_squared_error,
    threshold: float = 0.0,
    rest_steps: int = REST_STEPS,
) -> bool:
    """h ~ g under `start` (definition 1): played from there, do they end in the same sensory state?

    With threshold 0 this is an equivalence relation (proposition 1); with a larger one it need not be transitive.
    """
    return distance(*compare_orders(world, start, h, g, rest_steps)) <= threshold


def commute(world: World, start: Snapshot, h: np.ndarray, g: np.ndarray, **how) -> bool:
    """Is h then g equivalent to g then h? Keyword arguments as for :func:`equivalent`."""
    return equivalent(world, start, compose(h, g), compose(g, h), **how)


def is_commutative_residue(
    world: World, start: Snapshot, residue: np.ndarray, first: np.ndarray, second: np.ndarray, **how
) -> bool:
    """Does `residue` make up for the order (definition 2): first, then second ~ second, then first, then residue?

    Keyword arguments as for :func:`equivalent`. When the empty sequence is a residue, `first` and `second` commute.
    """
    return equivalent(world, start, compose(first, second), compose(second, first, residue), **how)


def commutative_residue(
    world: World,
    start: Snapshot,
    first: np.ndarray,
    second: np.ndarray,
    candidates: Iterable[np.ndarray],
    **how,
) -> np.ndarray | None:
    """The first of `candidates` that is a commutative residue of (`first`, `second`), or None when none of them is."""
    for residue in candidates:
        if is_commutative_residue(world, start, residue, first, second, **how):
            return residue
    return None

"""Equivalence of action sequences and commutative residues (paper, sections II-B and II-C)."""

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
    """Whether h ~ g from `start` (definition 1): both end in the same sensory state.

    Parameters
    ----------
    world : World
    start : Snapshot
        Of `world`.
    h, g : float (steps, n_dofs), in [-1, 1]
    distance : callable
    threshold : float
        Largest distance that counts as equal. With 0 this is an equivalence relation
        (proposition 1); with a larger one it need not be transitive.
    rest_steps : int
        Steps without a command that end each sequence.
    """
    return distance(*compare_orders(world, start, h, g, rest_steps)) <= threshold


def commute(world: World, start: Snapshot, h: np.ndarray, g: np.ndarray, **options) -> bool:
    """Whether h then g is equivalent to g then h; `options` as for :func:`equivalent`."""
    return equivalent(world, start, compose(h, g), compose(g, h), **options)


def is_commutative_residue(
    world: World,
    start: Snapshot,
    residue: np.ndarray,
    first: np.ndarray,
    second: np.ndarray,
    **options,
) -> bool:
    """Whether first, then second is equivalent to second, then first, then residue (definition 2).

    `options` as for :func:`equivalent`. If the empty sequence is a residue, `first` and `second`
    commute.
    """
    return equivalent(
        world, start, compose(first, second), compose(second, first, residue), **options
    )


def commutative_residue(
    world: World,
    start: Snapshot,
    first: np.ndarray,
    second: np.ndarray,
    candidates: Iterable[np.ndarray],
    **options,
) -> np.ndarray | None:
    """Return the first of `candidates` that is a commutative residue, or None."""
    for residue in candidates:
        if is_commutative_residue(world, start, residue, first, second, **options):
            return residue
    return None

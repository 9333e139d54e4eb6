"""Action sequences: Seq(M), composition and random permutation (paper, sections II-B and II-D).

A sequence is a float64 array of shape (steps, n_dofs) with elements in [-1, 1]; an action on one
degree of freedom has zeros elsewhere.
"""

from __future__ import annotations

import numpy as np

from ..errors import ArgumentError


def sample_sequence(rng: np.random.Generator, length: int, dof: int, n_dofs: int) -> np.ndarray:
    """Sample a sequence of Seq(M_k): actions uniform in [-1, 1] on the degree of freedom `dof`.

    Returns
    -------
    float64 (length, n_dofs)
    """
    sequence = np.zeros((length, n_dofs))
    sequence[:, dof] = rng.uniform(-1.0, 1.0, length)
    return sequence


def permute(rng: np.random.Generator, sequence: np.ndarray) -> np.ndarray:
    """The same actions in a random order: h_p of definition 3."""
    return sequence[rng.permutation(len(sequence))]


def compose(first: np.ndarray, *following: np.ndarray) -> np.ndarray:
    """Play `first`, then `following`: the paper's composition, read from left to right in time."""
    return np.concatenate([first, *following])


def no_op(length: int, n_dofs: int) -> np.ndarray:
    """The identity of Seq(M): `length` actions that command nothing."""
    return np.zeros((length, n_dofs))


def inverse(sequence: np.ndarray) -> np.ndarray:
    """The opposite actions in reverse order: undoes `sequence` if the environment is reversible."""
    return -sequence[::-1]


def check_sequence(sequence: np.ndarray, n_dofs: int) -> None:
    """Raise ArgumentError if `sequence` is not finite, (steps, n_dofs) and in [-1, 1]."""
    shape = np.shape(sequence)
    if len(shape) != 2 or shape[1] != n_dofs:
        raise ArgumentError(
            f"sequence: expected an array of the shape (steps, {n_dofs}), one column per degree of "
            f"freedom; got {shape}"
        )
    if sequence.size and not np.abs(sequence).max() <= 1:  # also false for NaN
        raise ArgumentError(
            f"sequence: actions lie in [-1, 1], got values from {np.min(sequence):g} to "
            f"{np.max(sequence):g}; divide by the largest action"
        )

"""One root seed, a stream of its own for everything that is random.

A seed is derived from the root seed and the names and numbers of what it is for (stage, world, agent, index), so that adding a world, an agent or
a degree of freedom never changes the numbers of another, and cutting work into jobs changes none.
"""

from __future__ import annotations

import hashlib

import numpy as np

Key = str | int


def _words(key: tuple[Key, ...]) -> tuple[int, ...]:
    """A name becomes four words of its SHA-256, a number (0 <= n < 2**64) two, behind a mark of its kind."""
    words: list[int] = []
    for part in key:
        if isinstance(part, str):
            words += [
                1,
                *np.frombuffer(hashlib.sha256(part.encode()).digest()[:16], "<u4").tolist(),
            ]
        elif 0 <= part < 2**64:
            words += [0, part & 0xFFFFFFFF, part >> 32]
        else:
            raise ValueError(f"a number in a seed's key must lie in [0, 2**64); got {part}")
    return tuple(words)


def seed_for(root: int, *key: Key) -> int:
    """The seed, in [0, 2**63), of what `key` names under the root seed."""
    state = np.random.SeedSequence(root, spawn_key=_words(key)).generate_state(1, np.uint64)
    return int(state[0] >> np.uint64(1))


def generator(seed: int, *key: Key) -> np.random.Generator:
    """A random generator for one purpose, named by `key`, of what `seed` belongs to."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=_words(key)))

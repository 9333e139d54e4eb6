"""One root seed, and an independent random stream for everything that is random.

A seed is derived from the root seed and a key of names and numbers (study, world, agent, index).
Adding a world, an agent or a degree of freedom therefore never changes the numbers of another, and
cutting work into jobs changes none.
"""

from __future__ import annotations

import hashlib

import numpy as np

Key = str | int


def _words(key: tuple[Key, ...]) -> tuple[int, ...]:
    """32-bit words of a key: 1 and four words of the SHA-256 of a name; 0 and two of a number."""
    words: list[int] = []
    for part in key:
        if isinstance(part, str):
            name_digest = hashlib.sha256(part.encode()).digest()
            words += [1, *np.frombuffer(name_digest[:16], "<u4").tolist()]
        elif 0 <= part < 2**64:
            words += [0, part & 0xFFFFFFFF, part >> 32]
        else:
            raise ValueError(f"a number in a seed's key must lie in [0, 2**64); got {part}")
    return tuple(words)


def seed_for(root: int, *key: Key) -> int:
    """Derive the seed, in [0, 2**63), of what `key` names from the root seed."""
    state = np.random.SeedSequence(root, spawn_key=_words(key)).generate_state(1, np.uint64)
    return int(state[0] >> np.uint64(1))


def generator(seed: int, *key: Key) -> np.random.Generator:
    """Return a random generator for one purpose, named by `key`."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=_words(key)))

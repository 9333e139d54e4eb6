"""Finished runs: where each of their files comes from, and how two of them differ."""

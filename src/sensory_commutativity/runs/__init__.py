"""Finished runs: where each of their files comes from, how two of them differ, and whether one is as it was made."""

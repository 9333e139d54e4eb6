"""A claim of the paper beside what was measured."""

from __future__ import annotations

from typing import NamedTuple


class Claim(NamedTuple):
    """A row of the table paper_comparison."""

    claim: str
    section: str
    paper_value: str
    our_value: str
    ci_low: float | None
    ci_high: float | None
    holds: bool


def p_of_claim(p: float) -> str:
    """A p-value, as small as it is."""
    return f"p {p:.2g}" if p > 0 else "p < 1e-300"

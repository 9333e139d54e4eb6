"""A claim of the paper, and what was measured."""

from __future__ import annotations

from typing import NamedTuple


class Claim(NamedTuple):
    """A row of the table paper_comparison.

    Attributes
    ----------
    claim, section, paper_value : str
        What the paper says, where, and its value if it gives one.
    our_value : str
        What this run measured.
    ci_low, ci_high : float or None
        95 % interval, if the value is a single number.
    holds : bool
    """

    claim: str
    section: str
    paper_value: str
    our_value: str
    ci_low: float | None
    ci_high: float | None
    holds: bool


def format_p(p: float) -> str:
    """A p-value with two significant digits."""
    return f"p {p:.2g}" if p > 0 else "p < 1e-300"

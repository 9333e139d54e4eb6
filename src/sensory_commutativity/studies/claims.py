"""A claim of the paper, what was measured, and what follows from it."""

from __future__ import annotations

from typing import Literal, NamedTuple

Verdict = Literal["holds", "holds in part", "not shown", "does not hold"]
VERDICTS: tuple[Verdict, ...] = ("holds", "holds in part", "not shown", "does not hold")
"""What a claim can come to: the rule is met; it is met by some of what the claim is about, or with
a limit that the claim does not have; the data decide neither way; the data contradict it."""


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
        Whether the rule is met.
    rule : str
        The rule, fixed before the run.
    limits : str
        What the rule does not show; may be empty.
    verdict : str, optional
        One of VERDICTS; by default what `holds` says.
    """

    claim: str
    section: str
    paper_value: str
    our_value: str
    ci_low: float | None
    ci_high: float | None
    holds: bool
    rule: str = ""
    limits: str = ""
    verdict: Verdict | None = None

    def row(self) -> dict[str, object]:
        """The row of the table, with the verdict filled in."""
        verdict = self.verdict or ("holds" if self.holds else "does not hold")
        return {**self._asdict(), "verdict": verdict}


def decide(met: int, contradicted: int, of: int) -> Verdict:
    """The verdict on a claim about several things.

    Parameters
    ----------
    met : int
        Of how many the data show the claim.
    contradicted : int
        Of how many they show the opposite.
    of : int
        How many there are.
    """
    if met == of:
        return "holds"
    if met:
        return "holds in part"
    return "does not hold" if contradicted else "not shown"


def format_p(p: float) -> str:
    """A p-value with two significant digits."""
    return f"p {p:.2g}" if p > 0 else "p < 1e-300"

"""The page of results: the paper's claims, from the table paper_comparison of the committed run.

    python docs/_generate/results.py         rewrites the block between the marks in docs/results.md

``make pages`` runs it. The block is regenerated whenever the site is built.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from sensory_commutativity.storage.columns import FLOAT
from sensory_commutativity.studies.paper.tables.paper_comparison import paper_comparison

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "results.md"
RUN = "results/paper"
TABLE = ROOT / RUN / "tables" / "paper_comparison.parquet"
START, END = "<!-- claims -->", "<!-- end claims -->"
SHOWN = {"claim", "section", "paper_value", "our_value", "ci_low", "ci_high", "holds", "verdict"}
"""Columns that the page shows in a place of their own; further ones are listed by their names."""


class Evidence(NamedTuple):
    """Where a claim is decided and shown."""

    pattern: str
    table: str
    figure: str


EVIDENCE = (
    Evidence("closed empty room", "flatland_scp", "flatland_free_space"),
    Evidence("falls with", "flatland_trends", "flatland_combinations"),
    Evidence("what displaces nothing", "flatland_commutation", "flatland_commutation"),
    Evidence("naive change|harder to predict", "flatland_baselines", "flatland_scp"),
    Evidence("base below|shoulders below|elbows below|left and right", "flatland_comparisons",
             "flatland_comparisons"),
    Evidence("head and eyelid|every other degree of freedom", "flatland_scp", "flatland_scp"),
    Evidence("same for all thresholds", "apartment_order", "apartment_order"),
    Evidence("SCP rises", "apartment_hierarchy", "apartment_scp"),
    Evidence("the wheels|always commutes|nearest the body|free space", "apartment_scp",
             "apartment_scp"),
    Evidence("RAFT predicts better|better than FlowNet", "mask_comparisons", "mask_iou"),
    Evidence("three outcomes", "mask_summary", "mask_confusion"),
    Evidence("unseen|generalis", "mask_summary", "mask_generalisation"),
    Evidence("mask", "mask_summary", "mask_iou"),
    Evidence("first against last|going back|return", "mask_discoveries", "mask_discoveries"),
    Evidence("local SCP|open space|kitchen", "local_scp_summary", "local_scp"),
    Evidence("every action space|viable", "navigation_summary", "navigation_scores"),
    Evidence("SCP-|truncated|adapted", "navigation_comparisons", "navigation_survival"),
)  # fmt: skip
"""First pattern that is found in a claim -> its table and figure."""


def evidence(claim: str) -> Evidence | None:
    """Table and figure of a claim; None if no pattern matches."""
    return next((one for one in EVIDENCE if re.search(one.pattern, claim, re.I)), None)


def claims_block(claims: pd.DataFrame) -> str:
    """Markdown of all claims: how many of each verdict, a table, and the details of each."""
    frame = claims.assign(result=[verdict(row) for _, row in claims.iterrows()])
    counts = frame["result"].value_counts()
    summary = ", ".join(f"{result} {number}" for result, number in counts.items())
    lines = [f"{len(frame)} claims: {summary}.", _overview(frame), "## Each claim"]
    for number, (_, row) in enumerate(frame.iterrows(), 1):
        lines += _details(number, row)
    return "\n\n".join(lines)


def verdict(row: pd.Series) -> str:
    """The verdict; of a table without that column, what `holds` says."""
    if isinstance(row.get("verdict"), str) and row["verdict"]:
        return row["verdict"]
    return "holds" if row["holds"] else "does not hold"


def _overview(frame: pd.DataFrame) -> str:
    lines = ["| | the paper says | verdict |", "| --- | --- | --- |"]
    for number, (_, row) in enumerate(frame.iterrows(), 1):
        shown = row["result"] if row["result"] == "holds" else f"**{row['result']}**"
        lines.append(
            f"| [{number}](#claim-{number}) | {_cell(row['claim'])} ({row['section']}) | {shown} |"
        )
    return "\n".join(lines)


def _details(number: int, row: pd.Series) -> list[str]:
    interval = ""
    if pd.notna(row["ci_low"]) and pd.notna(row["ci_high"]):
        interval = f", 95 % interval [{_number(row['ci_low'])}, {_number(row['ci_high'])}]"
    rows = [
        ("verdict", f"**{row['result']}**"),
        ("paper", row["paper_value"]),
        ("measured", f"{row['our_value']}{interval}"),
    ]
    for name in row.index:
        if name not in SHOWN | {"result"} and isinstance(row[name], str) and row[name]:
            rows.append((name, row[name]))
    found = evidence(row["claim"])
    shown = []
    if found is not None:
        picture = f"[`{found.figure}`](../{RUN}/figures/{found.figure}.png)"
        shown = [
            f"| table, figure | `{found.table}`, {picture} |",
            f"| command | `sencom figure {found.figure} --config {RUN}/config.yaml "
            f"--out {found.figure}.png` |",
        ]
    first, *others = [
        f"| {name} | {text if name == 'verdict' else _cell(text)} |" for name, text in rows
    ]
    table = [first, "| --- | --- |", *others]
    title = (
        f'<a id="claim-{number}"></a>\n\n#### {number}. {_cell(row["claim"])} ({row["section"]})'
    )
    return [title, "\n".join([*table, *shown])]


def _number(value: float) -> str:
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.4g}"


def _cell(text: str) -> str:
    return " ".join(str(text).split()).replace("|", r"\|").replace("<", "&lt;").replace("*", r"\*")


def read_claims(file: Path = TABLE) -> pd.DataFrame:
    """The table, with missing intervals as NaN; columns that it does not know are kept."""
    frame = pd.read_parquet(file)
    numbers = [one.name for one in paper_comparison.columns if one.type == FLOAT]
    return frame.astype(dict.fromkeys(numbers, float))


def with_claims(page: str, claims: pd.DataFrame) -> str:
    """The page with the block between the markers regenerated."""
    before, start, rest = page.partition(START)
    _, end, after = rest.partition(END)
    if not start or not end:
        raise ValueError(f"docs/results.md lacks the marks {START} and {END}")
    return f"{before}{START}\n\n{claims_block(claims)}\n\n{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(with_claims(PAGE.read_text(encoding="utf-8"), read_claims()), encoding="utf-8")

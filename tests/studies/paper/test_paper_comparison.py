"""The table of all claims, and the figure that shows it."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pytest

from sensory_commutativity.studies.claims import Claim, decide, format_p
from sensory_commutativity.studies.paper.figures.paper_comparison import (
    paper_comparison as comparison_figure,
)
from sensory_commutativity.studies.paper.tables import paper_comparison as module
from sensory_commutativity.studies.paper.tables.paper_comparison import INPUTS, paper_comparison
from tests.studies.examples import write_frame

CLAIMS = {
    "flatland": Claim("the head always commutes", "III-C", "SCP = 1", "8 of 8", 0.7, 1.0, True),
    "apartment": Claim("wheels are low", "III-C", "order", "it is not", None, None, False),
    "mask": Claim("a long claim " * 9, "IV-A", "0.82", "0.85", 0.8, 0.9, np.True_),
    "navigation": Claim(
        "it learns faster",
        "IV-B",
        "fewer steps",
        "-5",
        None,
        None,
        True,
        rule="the ratio is below a half",
        limits="of one room",
        verdict="holds in part",
    ),
}


@pytest.fixture
def table(default_config, monkeypatch):
    """The table of CLAIMS; each study decides its own from the tables that it is given."""
    given = []

    def claims_of(study: str):
        def claims(*arguments) -> list[Claim]:
            given.append(arguments)
            return [CLAIMS[study]]

        return claims

    for study in CLAIMS:
        monkeypatch.setattr(module, f"{study}_claims", claims_of(study))
    frames = [f"frame {name}" for name in INPUTS]
    table = paper_comparison(*frames, default_config)
    tables = dict(zip(INPUTS, frames, strict=True))
    assert given[:3] == [(tables, default_config)] * 3
    names = "summary", "comparisons", "sensitivity"
    assert given[3] == (*(f"frame navigation_{name}" for name in names), default_config)
    return table


def test_claims_are_listed_in_the_order_of_the_paper(table, default_config, tmp_path):
    assert table["claim"].tolist() == [claim.claim for claim in CLAIMS.values()]
    assert table["verdict"].tolist() == ["holds", "does not hold", "holds", "holds in part"]
    assert table["holds"].tolist() == [True, False, True, True]
    assert table["ci_low"].tolist() == pytest.approx([0.7, np.nan, 0.8, np.nan], nan_ok=True)
    write_frame(paper_comparison, default_config, tmp_path, table)  # types fit the columns


def test_the_figure_shows_every_claim_and_whether_it_holds(table, default_config):
    figure = comparison_figure({"paper_comparison": table}, default_config)
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    plt.close(figure)
    assert texts.count("holds") == 2 and texts.count("does not hold") == 1
    assert texts.count("holds in part") == 1
    joined = " ".join(" ".join(texts).split())
    for claim in CLAIMS.values():
        assert claim.claim.strip() in joined and claim.our_value in joined
    assert "8 of 8 [0.7000, 1.0000]" in joined
    assert "Rule: the ratio is below a half" in joined and "Limits: of one room" in joined


def test_tables_of_earlier_versions_say_only_whether_a_claim_holds(table, default_config):
    earlier = table.assign(verdict=None, rule=None, limits=None)
    figure = comparison_figure({"paper_comparison": earlier}, default_config)
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    plt.close(figure)
    assert texts.count("holds") == 3 and texts.count("does not hold") == 1


def test_a_claim_about_several_things_is_decided_by_how_many_show_it():
    assert decide(3, 0, 3) == "holds" and decide(1, 2, 3) == "holds in part"
    assert decide(0, 0, 3) == "not shown" and decide(0, 1, 3) == "does not hold"


def test_p_values_have_two_digits():
    cases = ((0.01234, "p 0.012"), (1e-12, "p 1e-12"), (0.0, "p < 1e-300"), (1.0, "p 1"))
    for p, text in cases:
        assert format_p(p) == text

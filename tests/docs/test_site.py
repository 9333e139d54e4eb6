"""The site: it builds without a warning, and what is made for it comes from the code."""

from __future__ import annotations

import html
import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pandas as pd
import pytest

import sensory_commutativity
from sensory_commutativity.cli import COMMANDS
from sensory_commutativity.studies.declarations import Table
from sensory_commutativity.studies.registry import declarations
from tests.docs.generate import hook, links, reference, results
from tests.helpers import ROOT


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built as `make docs` does."""
    folder = tmp_path_factory.mktemp("site")
    run = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)],
        cwd=ROOT, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    return folder


def test_every_link_and_picture_of_the_site_leads_somewhere(site: Path) -> None:
    checked = 0
    for page in site.rglob("*.html"):
        if page.name == "404.html":
            continue  # its links are absolute
        for link in re.findall(r'(?:href|src)="([^"]+)"', page.read_text(encoding="utf-8")):
            parts = urlsplit(html.unescape(link))
            if parts.scheme or parts.netloc or not parts.path:
                continue
            target = (page.parent / unquote(parts.path)).resolve()
            assert target.is_file() or (target / "index.html").is_file(), f"{page}: {link}"
            checked += 1
    assert checked > 1000


def test_every_public_name_is_documented(site: Path) -> None:
    text = " ".join(page.read_text() for page in (site / "reference" / "api").rglob("*.html"))
    for name in sensory_commutativity.__all__:
        assert name.startswith("__") or re.search(rf'id="[\w.]+\.{name}"', text), name
    assert not re.search(r":(class|func|meth|mod):<code>", text)


def test_nothing_is_shown_escaped(site: Path) -> None:
    for page in [*(site / "reference").rglob("*.html"), site / "results" / "index.html"]:
        assert not re.search(r"\\[|<_*&]", page.read_text(encoding="utf-8").split("<article")[1]), (
            page
        )


def test_every_command_and_table_has_a_section() -> None:
    page = reference.commands_page()
    for name in COMMANDS:
        assert f"## sencom {name}\n" in page
    assert "`--distance TEXT`" in page and "\n    " not in page
    pages = " ".join(reference.reference_pages().values())
    for name, table in declarations(Table, optional=True).items():
        assert f"## {name}\n" in pages
        assert all(f"| `{column.name}`" in pages for column in table.columns), name


def test_every_key_of_the_configuration_is_listed() -> None:
    page = reference.configuration_page()
    for key in (
        "`seed` | integer, ≥ 0, < 2^63",
        "`flatland.worlds.NAME.objects`",
        "`apartment.robots.NAME.description`",
        "`navigation.zones[].x`",
        "`masks.image_size`",
        "`atlas.",
    ):
        assert key in page, key
    assert "$ref" not in page and "| mapping |" not in page


def test_links_are_valid_in_the_repository_and_on_the_site() -> None:
    text = (
        "[a](../config/README.md#b) ![c](../results/paper/figures/flatland_scp.png) "
        "[d](cluster.md) "
        "[e](tutorials/x.ipynb) [f](../src) [g](https://x.org) [![h](i.png)](../README.md)\n"
        "```text\n[j](../LICENSE)\n```\n[k](../LICENSE)"
    )
    assert links.rewrite(text, "docs/a.md", ROOT) == (
        "[a](repository/config/README.md#b) "
        "![c](repository/results/paper/figures/flatland_scp.png) [d](cluster.md) "
        "[e](tutorials/x.md) f [g](https://x.org) [![h](i.png)](index.md)\n"
        "```text\n[j](../LICENSE)\n```\n[k](repository/LICENSE.md)"
    )
    assert links.relative_targets(text, "docs/a.md")[-1] == "LICENSE"
    assert links.rewrite("[a](docs/glossary.md)", "CONTRIBUTING.md", ROOT) == "[a](../glossary.md)"


def test_the_navigation_takes_pages_as_they_come() -> None:
    nav = [{"Home": "index.md"}, {"How-to": ["robots*.md", "gone.md", {"More": "c.md"}]}]
    pages = ["c.md", "index.md", "new.md", "robots-2.md", "robots.md", "repository/x.md"]
    assert hook.complete_navigation(nav, pages) == [
        {"Home": "index.md"},
        {"How-to": ["robots-2.md", "robots.md", {"More": "c.md"}, "new.md"]},
    ]


def test_names_in_tables_may_break_and_roles_are_plain_names() -> None:
    content = "<td><code>a.b_c</code></td><td>0</td><td><code>[1.0]</code></td><p><code>a.b</code>"
    expected = content.replace("a.b_c", "a.<wbr>b_<wbr>c")
    assert hook.on_page_content(content, None, None, None) == expected
    role = ":class:<code>~a.World</code> and :func:<code>.measure</code>"
    plain = "<code>a.World</code> and <code>measure</code>"
    assert hook.on_page_content(role, None, None, None) == plain


# ---- results ----------------------------------------------------------------------------------

CLAIMS = pd.DataFrame(
    {
        "claim": ["fetch: wheels < arm | lowest", "what displaces nothing commutes"],
        "section": ["III-C", "II-C"],
        "paper_value": ["", "conjecture"],
        "our_value": ["0.35", "0.893"],
        "ci_low": [0.3, float("nan")],
        "ci_high": [0.4, float("nan")],
        "holds": [True, False],
    }
)


def test_claims_of_tables_with_and_without_verdicts() -> None:
    block = results.claims_block(CLAIMS)
    assert "2 claims: holds 1, does not hold 1." in block
    assert (
        r"fetch: wheels &lt; arm \| lowest" in block and "0.35, 95 % interval [0.3, 0.4]" in block
    )
    extended = CLAIMS.assign(verdict=["holds in part", "not shown"], rule=["p below .01", ""])
    block = results.claims_block(extended)
    assert "**holds in part**" in block and "**not shown**" in block
    assert "| rule | p below .01 |" in block and block.count("| rule |") == 1


def test_every_claim_has_a_table_and_a_figure_of_the_run() -> None:
    for claim in results.read_claims()["claim"]:
        found = results.evidence(claim)
        assert found is not None, claim
        assert (ROOT / results.RUN / "tables" / f"{found.table}.parquet").is_file(), claim
        assert (ROOT / results.RUN / "figures" / f"{found.figure}.png").is_file(), claim


def test_the_page_of_results_is_that_of_the_committed_table() -> None:
    page = results.PAGE.read_text(encoding="utf-8")
    assert results.with_claims(page, results.read_claims()) == page, "make pages writes it anew"

"""The workflow's files keep Snakemake's own style."""

from __future__ import annotations

from .running import BIN, ROOT, run


def test_snakefmt_has_nothing_to_change() -> None:
    result = run([BIN / "snakefmt", "--check", "workflow"], ROOT)
    assert result.returncode == 0, result.stderr

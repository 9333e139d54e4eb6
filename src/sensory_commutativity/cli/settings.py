"""Commands that check and complete a configuration."""

from __future__ import annotations

import json
from pathlib import Path

import click

from ..studies.loading import json_schema, load, write_resolved
from .common import with_out


@click.command()
@click.argument("files", nargs=-1, required=True)
def check(files: tuple[str, ...]) -> None:
    """Check config FILES, each laid over the ones before: settings, the folder for results, robots, scenes, and that things fit into their rooms."""
    from ..studies.check import check_run

    config = load(*files)
    check_run(config)
    runs = config.flatland.runs()
    n = sum(run.experiments for run in runs)
    there = config.apartment.runs()
    m = sum(run.experiments for run in there)
    click.echo(
        f"profile {config.profile}: SC-experiments of each degree of freedom: {n:,} in {len(runs)} runs in Flatland, {m:,} in {len(there)} runs in "
        f"apartments; results go to {config.folder}"
    )


@click.command()
@click.argument("files", nargs=-1, required=True)
@with_out
def resolve(files: tuple[str, ...], out: Path) -> None:
    """Check config FILES, each laid over the ones before, and write all settings with every default filled in."""
    write_resolved(load(*files), out)


@click.command()
@with_out
def schema(out: Path) -> None:
    """Write the JSON schema of the configuration."""
    out.write_text(json.dumps(json_schema(), indent=2) + "\n")

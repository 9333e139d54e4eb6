"""Commands that check and complete a configuration."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path

import click

from ..data import data_file
from ..extras import extra_needed
from ..storage.atomic import atomic_write
from ..studies.config import Config
from ..studies.loading import json_schema, load, write_resolved
from .options import config_option, out_option


@click.group()
def config() -> None:
    """Check, complete or describe a configuration."""


@config.command()
@click.argument("files", nargs=-1)
def check(files: tuple[str, ...]) -> None:
    """Check configuration FILES, each merged over the ones before.

    Without FILES, checks the default profile that belongs to the package. Checks the settings, the
    folder of the results, robots, scenes, and that objects fit into their rooms.
    """
    from ..studies.check import check_run

    checked = load(*(files or [data_file("config", "config.yaml")]))
    with extra_needed("workflow"):
        check_run(checked)
    flatland, apartment = checked.flatland.runs(), checked.apartment.runs()
    click.echo(
        f"profile {checked.profile}: SC-experiments per degree of freedom: "
        f"{sum(run.experiments for run in flatland):,} in {len(flatland)} runs in Flatland, "
        f"{sum(run.experiments for run in apartment):,} in {len(apartment)} runs in apartments; "
        f"results go to {checked.folder}"
    )


@config.command()
@click.argument("files", nargs=-1, required=True)
@out_option
def resolve(files: tuple[str, ...], out: Path) -> None:
    """Merge configuration FILES and fill in all defaults."""
    write_resolved(load(*files), out)


@config.command()
@out_option
def schema(out: Path) -> None:
    """Write the JSON schema of the configuration."""
    if not out.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(out))
    with atomic_write(out) as temporary:
        temporary.write_text(json.dumps(json_schema(), indent=2) + "\n", encoding="utf-8")


@config.command("check-start")
@config_option
@click.option("--robot", required=True, help="A key of apartment.robots.")
@click.option("--scene", required=True, help="A key of apartment.scenes.")
@click.option(
    "--start", type=click.Choice(["anywhere", "within-reach"]), required=True,
    help="Where the robot starts.",
)  # fmt: skip
@out_option
def check_start(config: Config, robot: str, scene: str, start: str, out: Path) -> None:
    """Check that a robot finds start situations in a scene.

    Fetches the VGG16 weights first, so that later jobs need no network.
    """
    from ..storage.seal import SEAL, SEAL_KEY, seal
    from ..studies.apartment.builders import check_ready
    from ..studies.provenance import provenance

    if config is None:
        raise click.UsageError("give the configuration of the run with --config")
    if (robot, scene, start) not in [run[:3] for run in config.apartment.runs()]:
        raise click.UsageError(
            f"the configuration has no run of robot {robot!r} in scene {scene!r}, start {start!r}"
        )
    ready = check_ready(config, robot, scene, start)
    content = {SEAL_KEY: SEAL, **ready, "about": provenance(config)}
    with atomic_write(out) as temporary:
        temporary.write_bytes(seal(f"{json.dumps(content, indent=2)}\n".encode()))

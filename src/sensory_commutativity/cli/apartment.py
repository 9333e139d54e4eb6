"""Commands that write the tables of the apartment."""

from __future__ import annotations

import importlib
import json
from pathlib import Path

import click

from ..studies.config import Config
from .common import Part, check_parts, table, with_config, with_out, with_parts

_robot = click.option("--robot", required=True, help="A key of apartment.robots.")
_scene = click.option("--scene", required=True, help="A key of apartment.scenes.")
_start = click.option(
    "--start",
    type=click.Choice(["anywhere", "within-reach"]),
    required=True,
    help="From which situations.",
)


@click.command()
@with_config
@_robot
@_scene
@_start
@click.option("--length", type=click.IntRange(1), required=True, help="Actions in a sequence.")
@click.option(
    "--part",
    type=Part(),
    required=True,
    help="Which of the shares that the configuration cuts the work into.",
)
@with_out
def apartment_experiments_part(
    config: Config,
    robot: str,
    scene: str,
    start: str,
    length: int,
    part: tuple[int, int],
    out: Path,
) -> None:
    """Play a share of the SC-experiments of a robot in a scene."""
    from ..studies.apartment.tables.apartment_experiments import write_experiments

    runs = {run[:4]: run for run in config.apartment.runs()}
    if (robot, scene, start, length) not in runs:
        known = "; ".join(" ".join(map(str, run)) for run in runs)
        raise click.UsageError(
            f"the configuration has no run of robot {robot!r}, scene {scene!r}, start {start!r}, length {length}; it has: {known}"
        )
    run = runs[robot, scene, start, length]
    check_parts(part, config.apartment.n_jobs(run.experiments))
    write_experiments(config, run, part[0] - 1, out)


@click.command()
@with_config
@with_parts
@with_out
def apartment_experiments(config: Config, parts: tuple[Path, ...], out: Path) -> None:
    """Gather the PARTS of the table apartment_experiments."""
    from ..studies.apartment.tables.apartment_experiments import gather_experiments

    gather_experiments(list(parts), out, config)


@click.command()
@with_config
@_robot
@_scene
@_start
@with_out
def apartment_ready(config: Config, robot: str, scene: str, start: str, out: Path) -> None:
    """Fetch the VGG16 weights, once, and try whether a robot finds situations to start from in a scene."""
    from ..studies.apartment.builders import check_ready

    if (robot, scene, start) not in [run[:3] for run in config.apartment.runs()]:
        raise click.UsageError(
            f"the configuration has no run of robot {robot!r} in scene {scene!r}, start {start!r}"
        )
    found = check_ready(config, robot, scene, start)
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")


def _from_experiments(name: str, text: str) -> click.Command:
    """A command that makes the table `name` from apartment_experiments alone."""

    @click.command(name.replace("_", "-"), help=text)
    @with_config
    @table("apartment-experiments")
    @with_out
    def command(config: Config, apartment_experiments: Path, out: Path) -> None:
        stage = importlib.import_module(f"..stages.{name}", __package__)
        getattr(stage, name.replace("apartment", "write"))(apartment_experiments, out, config)

    return command


FROM_EXPERIMENTS = tuple(
    _from_experiments(*row)
    for row in (
        ("apartment_scp", "Estimate the SCP of every degree of freedom."),
        ("apartment_hierarchy", "Compare wheels, shoulder, elbow and wrist."),
        ("apartment_order", "Is the order of the degrees of freedom stable?"),
        ("apartment_interaction", "Set the SCP beside what was truly touched."),
    )
)

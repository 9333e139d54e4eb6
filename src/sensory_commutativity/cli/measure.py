"""Commands that measure and check a world."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import WorldError
from ..storage.atomic import atomic_write
from .real_robots import measure_recorded, real_robot_options, write_record
from .real_robots import record as start_recording
from .robot import warn_about_robot
from .worlds import build_world, list_worlds, world_options

if TYPE_CHECKING:
    from ..measurement.measurement import Measurement

FILE: Any = click.Path(dir_okay=False, path_type=Path)


@click.command()
@world_options
@click.option("-n", "--n", "n", default=300, show_default=True, help="Start situations.")
@click.option("--length", default=50, show_default=True, help="Actions in a sequence.")
@click.option(
    "--threshold", "thresholds", type=float, multiple=True,
    help="Largest distance that counts as equal; may be given several times  [default: 0; of an "
    "environment .01 and .1]",
)  # fmt: skip
@click.option(
    "--distance",
    help="mse (mean squared error), scaled (in units of each sensor's spread) or vgg16 (features "
    "of images)  [default: mse; of an environment scaled]",
)  # fmt: skip
@click.option("--seed", default=0, show_default=True, help="Determines everything random.")
@click.option(
    "--rest-steps", type=int,
    help="Steps without a command at the end of each order  [default: 3; of an environment 100 at "
    "most, until it is still]",
)  # fmt: skip
@click.option("--workers", default=1, show_default=True, help="Processes.")
@click.option(
    "--out", type=FILE,
    help="Parquet file for the experiments; if it exists, the measurement goes on from it.",
)  # fmt: skip
@click.option("--plot", type=FILE, help="Picture of the SCPs to write: PNG, PDF or SVG.")
@real_robot_options
def measure(
    world: str | None,
    list_names: bool,
    options: tuple[str, ...],
    n: int,
    length: int,
    thresholds: tuple[float, ...],
    distance: str | None,
    seed: int,
    rest_steps: int | None,
    workers: int,
    out: Path | None,
    plot: Path | None,
    protocol: str,
    reset_every: int | None,
    wander: int | None,
    until: str | None,
    alpha: float,
    margin: float,
    log: Path | None,
    record: Path | None,
    **which: str | None,
) -> None:
    """Measure the SCP of every degree of freedom of WORLD.

    WORLD is a name that --list shows, a Gymnasium environment (Pendulum-v1), or a world of your own
    (FILE.py:NAME or MODULE:NAME, where NAME is a world or a function that returns one).
    """
    from ..measurement.measure import measure as measure_world

    if list_names:
        list_worlds()
        return
    for option, path in (("--out", out), ("--plot", plot)):
        if path is not None and not path.parent.is_dir():
            raise click.UsageError(f"{option} {path}: there is no folder {path.parent}; create it")
    if plot is not None:
        _check_format(plot)
    if log is not None:
        unused = dict(WORLD=world, until=until, record=record, **which)
        measurement = measure_recorded(log, distance, thresholds, unused)
        if out is not None:
            measurement.save(out)
    else:
        built = build_world(world, options, which, restored=protocol != "return")
        warn_about_robot(built)
        source = start_recording(built, record, protocol)
        measurement = measure_world(
            source, n, length, distance, thresholds or None, seed, protocol=protocol,
            reset_every=reset_every, wander=wander, until=until, alpha=alpha, margin=margin,
            rest_steps=rest_steps, workers=workers, resume=out,
        )  # fmt: skip
        write_record(record, source, measurement.settings.distance)
    click.echo(str(measurement))
    ordered = measurement.settings.stopping is not None or not measurement.controls
    if len(measurement.dofs) > 1 and ordered:
        click.echo(f"\n{measurement.order()}")
    if plot is not None:
        from matplotlib.figure import Figure  # needs no screen

        figure = Figure(figsize=(6.4, 1.4 + 0.3 * len(measurement.dofs)), layout="constrained")
        measurement.plot(figure.add_subplot())
        with atomic_write(plot) as temporary:
            figure.savefig(temporary, dpi=150)
    written = [str(path) for path in (out, plot, record) if path is not None]
    if written:
        click.echo(f"\nwritten: {', '.join(written)}")
    _refuse_if_terminated(measurement)


@click.command()
@world_options
@click.option("--tries", default=20, show_default=True, help="Random starts.")
@click.option("--seed", default=0, show_default=True, help="Determines starts and sequences.")
def check(
    world: str | None,
    list_names: bool,
    options: tuple[str, ...],
    tries: int,
    seed: int,
    **which: str | None,
) -> None:
    """Check that WORLD keeps the promises that its SCP rests on.

    WORLD is as for `sencom measure`. Plays random sequences and says which promise is broken, and
    why: exact replay, a restore that restores, observations that are fresh and never change. The
    exit code is 1 if one is broken.
    """
    from ..scp.check import check_world

    if list_names:
        list_worlds()
        return
    report = check_world(build_world(world, options, which), tries, seed=seed)
    click.echo(str(report))
    if not report.passed:
        raise SystemExit(1)


def _refuse_if_terminated(measurement: Measurement) -> None:
    """Raise WorldError if an episode ended within every sequence: nothing can be read then."""
    terminated = measurement.controls.get("terminated")
    if terminated is not None and len(terminated) and (terminated == 1).all():
        raise WorldError(
            f"{measurement.settings.world}: everything terminated: every sequence ended its "
            "episode, so no SCP is defined; choose a shorter --length, or switch termination off "
            "(-o terminate_when_unhealthy=false in gymnasium's MuJoCo environments)"
        )


def _check_format(plot: Path) -> None:
    if plot.suffix.lower() not in (".png", ".pdf", ".svg"):
        raise click.UsageError(f"--plot {plot}: expected a name that ends in .png, .pdf or .svg")

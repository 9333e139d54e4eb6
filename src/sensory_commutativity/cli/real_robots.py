"""Options of `sencom measure` for real robots: without a restore, few experiments, and logs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from ..errors import UserError
from ..measurement.measurement import Measurement

FILE: Any = click.Path(dir_okay=False, path_type=Path)


def real_robot_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options, in a group of their own at the end of the help."""
    for decorator in (
        click.option(
            "--record", type=FILE, help="Parquet file for every step of --protocol return."
        ),
        click.option(
            "--log", type=FILE,
            help="Measure what a robot recorded by --protocol return, in place of WORLD.",
        ),
        click.option(
            "--margin", default=0.05, show_default=True,
            help="Difference of SCPs below which --until ordered may call two tied.",
        ),
        click.option(
            "--alpha", default=0.05, show_default=True,
            help="Largest probability that --until ordered says anything wrong.",
        ),
        click.option(
            "--until", type=click.Choice(["ordered"]),
            help="Stop when every pair is ordered or tied; -n is then the largest number of "
            "starts.",
        ),
        click.option(
            "--wander", type=int,
            help="Random actions between two starts of --protocol return  [default: --length]",
        ),
        click.option(
            "--reset-every", type=int,
            help="Starts of --protocol return between two resets  [default: never]",
        ),
        click.option(
            "--protocol", type=click.Choice(["reset", "return"]), default="reset",
            show_default=True,
            help="reset: restore the start for each order; return: go back by the inverse actions.",
        ),
    ):  # fmt: skip
        function = decorator(function)
    return function


def measure_recorded(
    log: Path, distance: str | None, thresholds: tuple[float, ...], unused: dict[str, Any]
) -> Measurement:
    """Measure a log; raises UsageError for options that ask for another source."""
    from ..measurement.logs import measure_log

    given = [name for name, value in unused.items() if value]
    if given:
        raise click.UsageError(f"--log measures a file; leave out {given[0]}")
    return measure_log(log, distance, thresholds or None)


def record(world: Any, path: Path | None, protocol: str) -> Any:
    """A world whose steps are recorded, if `path` asks for it; raises UsageError."""
    if path is None:
        return world
    if protocol != "return":
        raise click.UsageError("--record needs --protocol return")
    if not path.parent.is_dir():
        raise click.UsageError(f"--record {path}: there is no folder {path.parent}; create it")
    from ..measurement.recorder import Recorder

    return Recorder(world)


def write_record(path: Path | None, recorder: Any, distance: str) -> None:
    """Write what was recorded, if it was asked for."""
    if path is None:
        return
    from ..measurement.recorder import write_log

    if distance not in ("mse", "scaled"):
        raise UserError(f"--record: a log names mse or scaled, not the distance {distance}")
    write_log(path, recorder, distance)

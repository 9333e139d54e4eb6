"""Commands that write the tables of Flatland."""

from __future__ import annotations

from pathlib import Path

import click

from ..studies.config import Config
from .common import Part, check_parts, table, with_config, with_out, with_parts


@click.command()
@with_config
@click.option("--world", required=True, help="A key of flatland.worlds.")
@click.option("--agent", required=True, help="A key of flatland.agents.")
@click.option("--length", type=click.IntRange(1), required=True, help="Actions in a sequence.")
@click.option(
    "--part",
    type=Part(),
    required=True,
    help="Which of the shares that the configuration cuts the work into.",
)
@with_out
def flatland_experiments_part(
    config: Config, world: str, agent: str, length: int, part: tuple[int, int], out: Path
) -> None:
    """Play a share of the SC-experiments of an agent in a world."""
    from ..studies.flatland.tables.flatland_experiments import write_experiments

    runs = {run[:3]: run for run in config.flatland.runs()}
    if (world, agent, length) not in runs:
        known = "; ".join(f"{w} {a} {n}" for w, a, n in runs)
        raise click.UsageError(
            f"the configuration has no run of world {world!r}, agent {agent!r}, length {length}; it has: {known}"
        )
    run = runs[world, agent, length]
    check_parts(part, config.flatland.n_jobs(run.experiments))
    write_experiments(config, run, part[0] - 1, out)


@click.command()
@with_config
@with_parts
@with_out
def flatland_experiments(config: Config, parts: tuple[Path, ...], out: Path) -> None:
    """Gather the PARTS of the table flatland_experiments."""
    from ..studies.flatland.tables.flatland_scp import gather_experiments

    gather_experiments(list(parts), out, config)


@click.command()
@with_config
@table("flatland-experiments")
@with_out
def flatland_scp(config: Config, flatland_experiments: Path, out: Path) -> None:
    """Estimate the SCP of every degree of freedom."""
    from ..studies.flatland.tables.flatland_scp import write_scp

    write_scp(flatland_experiments, out, config)


@click.command()
@with_config
@table("flatland-experiments")
@with_out
def flatland_sensitivity(config: Config, flatland_experiments: Path, out: Path) -> None:
    """Estimate the SCP for all sequence lengths and thresholds."""
    from ..studies.flatland.tables.flatland_scp import write_sensitivity

    write_sensitivity(flatland_experiments, out, config)


@click.command()
@with_config
@table("flatland-experiments")
@with_out
def flatland_comparisons(config: Config, flatland_experiments: Path, out: Path) -> None:
    """Compare the degrees of freedom in pairs (McNemar, Holm)."""
    from ..studies.flatland.tables.flatland_comparisons import write_comparisons

    write_comparisons(flatland_experiments, out, config)


@click.command()
@with_config
@table("flatland-scp")
@with_out
def flatland_trends(config: Config, flatland_scp: Path, out: Path) -> None:
    """Test whether the SCP falls with the number of objects and with arm length."""
    from ..studies.flatland.tables.flatland_trends import write_trends

    write_trends(flatland_scp, out, config)


@click.command()
@with_config
@click.option("--world", required=True, help="The reference world or the settled one.")
@click.option(
    "--part",
    type=Part(),
    required=True,
    help="Which of the shares that the configuration cuts the work into.",
)
@with_out
def flatland_commutation_part(config: Config, world: str, part: tuple[int, int], out: Path) -> None:
    """Play a share of the experiments on pairs of degrees of freedom."""
    from ..studies.flatland.tables.flatland_commutation import write_commutation_experiments

    known = config.flatland.commutation_worlds()
    if world not in known:
        raise click.BadParameter(
            f"no commutation experiments in {world!r}; choose one of {', '.join(known)}",
            param_hint="--world",
        )
    check_parts(part, config.flatland.n_commutation_jobs)
    write_commutation_experiments(config, world, part[0] - 1, out)


@click.command()
@with_config
@with_parts
@with_out
def flatland_commutation(config: Config, parts: tuple[Path, ...], out: Path) -> None:
    """Estimate from PARTS the probability that two degrees of freedom commute."""
    from ..studies.flatland.tables.flatland_commutation import write_commutation

    write_commutation(list(parts), out, config)


@click.command()
@with_config
@click.option("--dof", required=True, help="A degree of freedom, e.g. left-elbow.")
@with_out
def flatland_baselines_part(config: Config, dof: str, out: Path) -> None:
    """Measure naive change and prediction error of one degree of freedom."""
    from ..studies.flatland.tables.flatland_baselines import write_baseline
    from ..worlds.flatland.agent import Polyphemus

    known = [d.name for d in Polyphemus().dofs]
    if dof not in known:
        raise click.BadParameter(
            f"there is no {dof!r}; choose one of {', '.join(known)}", param_hint="--dof"
        )
    write_baseline(config, dof, out)


@click.command()
@with_config
@with_parts
@with_out
def flatland_baselines(config: Config, parts: tuple[Path, ...], out: Path) -> None:
    """Gather PARTS and work out the excess prediction errors."""
    from ..studies.flatland.tables.flatland_baselines import gather_baselines

    gather_baselines(list(parts), out, config)


@click.command()
@with_config
@table("flatland-baselines")
@table("flatland-scp")
@with_out
def flatland_alternatives(
    config: Config, flatland_baselines: Path, flatland_scp: Path, out: Path
) -> None:
    """Correlate the two alternatives with the SCP."""
    from ..studies.flatland.tables.flatland_baselines import write_alternatives

    write_alternatives(flatland_baselines, flatland_scp, out, config)

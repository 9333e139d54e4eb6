"""Commands of the navigation task: action spaces, training runs, and what is made of their curves."""

from __future__ import annotations

import importlib
from pathlib import Path

import click

from ..studies.config import Config
from .common import table, with_config, with_out, with_parts


@click.command()
@with_config
@with_parts
@with_out
def navigation_scp(config: Config, parts: tuple[Path, ...], out: Path) -> None:
    """Estimate the SCP of the agent that learns from PARTS of its SC-experiments."""
    from ..studies.navigation.tables.navigation_scp import write_navigation_scp

    write_navigation_scp(list(parts), out, config)


@click.command()
@with_config
@table("navigation-scp")
@with_out
def navigation_action_spaces(config: Config, navigation_scp: Path, out: Path) -> None:
    """Make the action spaces of all training runs from the measured SCPs."""
    from ..studies.navigation.tables.navigation_action_spaces import write_action_spaces

    write_action_spaces(navigation_scp, out, config)


@click.command()
@with_config
@click.option("--action-space", required=True, help="One of navigation.action_spaces.")
@click.option("--seed", type=click.IntRange(0), required=True, help="One of navigation.seeds.")
@table("navigation-scp")
@click.option(
    "--model",
    type=click.Path(dir_okay=False, path_type=Path),
    required=True,
    help="File for the trained policy.",
)
@with_out
def navigation_run(
    config: Config, action_space: str, seed: int, navigation_scp: Path, model: Path, out: Path
) -> None:
    """Train one agent, or go on where a killed run stopped; write its learning curve."""
    from ..studies.navigation.tables.navigation_curves import write_run

    if (action_space, seed) not in config.navigation.runs:
        navigation = config.navigation
        raise click.UsageError(
            f"the configuration has no run of action space {action_space!r} with seed {seed}; it has {', '.join(navigation.action_spaces)}, "
            f"each with {len(navigation.seeds)} seeds between {min(navigation.seeds)} and {max(navigation.seeds)}"
        )
    write_run(config, action_space, seed, navigation_scp, out, model)


@click.command()
@with_config
@with_parts
@with_out
def navigation_curves(config: Config, parts: tuple[Path, ...], out: Path) -> None:
    """Gather the learning curves in PARTS; every run of the configuration must be there, once."""
    from ..studies.navigation.tables.navigation_curves import gather_curves

    gather_curves(list(parts), out, config)


def _from_table(name: str, source: str, text: str) -> click.Command:
    """A command that makes the table `name` from the table `source` alone."""

    @click.command(name.replace("_", "-"), help=text)
    @with_config
    @table(source.replace("_", "-"))
    @with_out
    def command(config: Config, out: Path, **tables: Path) -> None:
        stage = importlib.import_module(f"..stages.{name}", __package__)
        getattr(stage, name.replace("navigation", "write"))(tables[source], out, config)

    return command


FROM_TABLES = tuple(
    _from_table(*row)
    for row in (
        ("navigation_scores", "navigation_curves", "Score every training run."),
        (
            "navigation_summary",
            "navigation_scores",
            "Mean, median, interquartile mean of every score.",
        ),
        ("navigation_comparisons", "navigation_scores", "Compare the action spaces in pairs."),
        ("navigation_checkpoints", "navigation_curves", "Compare them at every checkpoint."),
        (
            "navigation_survival",
            "navigation_scores",
            "Kaplan-Meier curves of the steps to the threshold.",
        ),
        ("navigation_profiles", "navigation_scores", "Fraction of runs above every return."),
        ("navigation_power", "navigation_scores", "Which differences would so many runs find?"),
        ("navigation_calibration", "navigation_scores", "How often do the tests err? (A/A)"),
    )
)


@click.command()
@with_config
@click.option("--action-space", required=True, help="One of navigation.action_spaces.")
@table("navigation-scores")
@click.option(
    "--models",
    type=click.Path(path_type=Path),
    required=True,
    help="Folder of the trained policies.",
)
@with_out
def navigation_episode(
    config: Config, action_space: str, navigation_scores: Path, models: Path, out: Path
) -> None:
    """Animate the first evaluation episodes of the median run of an action space, as a GIF."""
    from ..studies.navigation.figures.navigation_episode import animate_episode

    if action_space not in config.navigation.action_spaces:
        raise click.BadParameter(
            f"there is no action space {action_space!r}; choose one of {', '.join(config.navigation.action_spaces)}",
            param_hint="--action-space",
        )
    animate_episode(config, action_space, navigation_scores, models, out)

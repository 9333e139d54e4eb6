"""Commands that make what people look at: the comparison with the paper, figures, the animation."""

from __future__ import annotations

from pathlib import Path

import click

from ..studies.config import Config
from .common import with_config, with_out


@click.command()
@with_config
@click.option(
    "--tables", type=click.Path(path_type=Path), required=True, help="Folder of the tables."
)
@with_out
def paper_comparison(config: Config, tables: Path, out: Path) -> None:
    """Set the paper's claims beside what was measured."""
    from ..studies.paper.tables.paper_comparison import write_paper_comparison

    write_paper_comparison(tables, out, config)


@click.command()
@with_config
@click.argument("name")
@click.option(
    "--tables", type=click.Path(path_type=Path), required=True, help="Folder of the tables."
)
@with_out
def figure(config: Config, name: str, tables: Path, out: Path) -> None:
    """Draw the figure NAME as OUT (PNG) and beside it as PDF."""
    from ..studies.catalogue import FIGURES

    if name not in FIGURES:
        raise click.BadParameter(
            f"there is no figure {name!r}; choose one of {', '.join(FIGURES)}", param_hint="NAME"
        )
    from ..studies.plotting import draw_figure

    draw_figure(name, tables, out, config)


@click.command()
@with_config
@click.option(
    "--dof",
    default="left-shoulder",
    show_default=True,
    help="The degree of freedom that is driven.",
)
@with_out
def animation(config: Config, dof: str, out: Path) -> None:
    """Animate one SC-experiment that does not commute, both orders side by side, as a GIF."""
    from ..studies.flatland.figures.flatland_experiment import animate_experiment

    animate_experiment(config, dof, out)

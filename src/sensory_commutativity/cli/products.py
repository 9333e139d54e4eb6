"""Commands that compute what the studies declare: tables, arrays, models, figures, animations."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from ..studies.config import Config
from ..studies.declarations import Animation, Arrays, Figure, Model, Product, Shard, Table
from ..studies.registry import KINDS, declarations, find, input_shards
from .options import FILE, config_option


def _command(kind: type[Product], shard_option: str, help_text: str) -> click.Command:
    """A command ``KIND NAME [INPUTS]`` with the options that all of them take."""

    def options(function: Callable[..., Any]) -> Callable[..., Any]:
        function = click.option(
            "--list", "list_names", is_flag=True, help="List all names and exit."
        )(function)
        if kind is Model:
            function = click.option("--curve", type=FILE, help="File for its training curve.")(
                function
            )
        if shard_option:
            function = click.option(
                f"--{shard_option}", "shard_name", help=f"Only this {shard_option}."
            )(function)
        function = click.option(
            "--out", type=FILE, help="File to write [default: its place in the run's folder]."
        )(function)
        function = config_option(function)
        function = click.argument("inputs", nargs=-1, type=click.Path(path_type=Path))(function)
        return click.argument("name", required=False)(function)

    @click.command(KINDS[kind] if kind is not Model else "train", help=help_text)
    @options
    def command(
        name: str | None,
        inputs: tuple[Path, ...],
        config: Config | None,
        out: Path | None,
        list_names: bool,
        shard_name: str | None = None,
        curve: Path | None = None,
    ) -> None:
        if list_names:
            for product in declarations(kind, optional=True).values():
                click.echo(f"{product.name:34} {product.title}")
            return
        if name is None:
            raise click.UsageError("give a NAME; --list shows all names")
        product = find(kind, name)
        if config is None:
            raise click.UsageError("give the configuration of the run with --config")
        shard = _find_shard(product, config, shard_name, shard_option)
        _write(product, config, inputs, out, shard, curve)

    return command


def _find_shard(product: Product, config: Config, name: str | None, option: str) -> Shard | None:
    if name is None:
        runs_needed = product.shards is not None and not isinstance(product, Table)
        if runs_needed or getattr(product, "shards_only", False):
            raise click.UsageError(f"{product.name} is computed per {option}; give --{option}")
        return None
    if product.shards is None:
        raise click.UsageError(f"{product.name} has no shards; leave out --{option}")
    return product.shards.find(config, name)


def _write(
    product: Product,
    config: Config,
    inputs: tuple[Path, ...],
    out: Path | None,
    shard: Shard | None,
    curve: Path | None,
) -> None:
    from ..studies.runner import write_product  # imports pandas

    defaults = default_inputs(product, config, shard)
    files = list(inputs) or [config.folder / path for path in defaults]
    out = out or config.folder / product.file(shard)
    if isinstance(product, Model) and product.curve and curve is None:
        assert shard is not None
        curve = config.folder / find(Table, product.curve).file(shard)
    write_product(product, config, files, out, shard, curve)


def default_inputs(product: Product, config: Config, shard: Shard | None) -> list[Any]:
    """Files of all inputs, relative to the folder of the run."""
    if isinstance(product, Table) and product.shards is not None and shard is None:
        return [product.file(one) for one in product.shards.all(config)]
    declared = input_shards(product, config, shard)
    return [source.file(one) for source, shards in declared for one in shards]


_INPUTS = "INPUTS are the files that it is computed from [default: those in the run's folder]."
table = _command(
    Table, "shard",
    "Compute the table NAME, or one shard of it.\n\n"
    f"{_INPUTS} The shards of a table are the INPUTS of the table itself.",
)  # fmt: skip
arrays = _command(Arrays, "shard", f"Compute the arrays NAME, or one shard of them.\n\n{_INPUTS}")
train = _command(
    Model, "run", f"Train the model NAME, or resume where training was killed.\n\n{_INPUTS}"
)
figure = _command(Figure, "", f"Draw the figure NAME as PNG, and beside it as PDF.\n\n{_INPUTS}")
animation = _command(Animation, "run", f"Write the animation NAME as GIF.\n\n{_INPUTS}")

"""Types and options that several commands take."""

from __future__ import annotations

from pathlib import Path

import click

from ..studies.config import Config
from ..studies.loading import load


class _Config(click.ParamType):
    """A configuration file, loaded and checked."""

    name = "file"

    def convert(self, value, param, ctx) -> Config:
        return value if isinstance(value, Config) else load(value)


class Part(click.ParamType):
    """I/N: the I-th of N, from 1."""

    name = "i/n"

    def convert(self, value, param, ctx) -> tuple[int, int]:
        try:
            i, n = (int(part) for part in value.split("/"))
        except ValueError:
            self.fail(f"{value!r} is not of the form I/N, e.g. 1/4", param, ctx)
        if not 1 <= i <= n:
            self.fail(f"{value!r}: I must lie between 1 and N", param, ctx)
        return i, n


def check_parts(part: tuple[int, int], n: int) -> None:
    """Refuse a part of other than the `n` parts that the configuration cuts the work into."""
    if part[1] != n:
        raise click.BadParameter(
            f"the configuration cuts this work into {n} parts, not {part[1]}; give I/{n}",
            param_hint="--part",
        )


with_config = click.option(
    "--config",
    type=_Config(),
    required=True,
    help="Configuration, e.g. results/default/config.yaml.",
)
with_out = click.option(
    "--out", type=click.Path(dir_okay=False, path_type=Path), required=True, help="File to write."
)
with_parts = click.argument("parts", nargs=-1, required=True, type=click.Path(path_type=Path))


def table(option: str):
    """The option that takes a table of this name."""
    text = f"The table {option.replace('-', '_')}."
    return click.option(f"--{option}", type=click.Path(path_type=Path), required=True, help=text)

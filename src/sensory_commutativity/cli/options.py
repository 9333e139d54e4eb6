"""Options that several commands take."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..storage.files import printable
from ..studies.config import Config
from ..studies.loading import load

FILE: Any = click.Path(dir_okay=False, path_type=Path)


class ConfigFile(click.ParamType):
    """A configuration file, loaded and checked."""

    name = "file"

    def convert(self, value: Any, param: Any, ctx: Any) -> Config:
        return value if isinstance(value, Config) else load(value)


def say(text: str) -> None:
    """Print a line. Names and values come from files, so control characters are escaped."""
    click.echo(printable(text))


config_option = click.option(
    "--config", type=ConfigFile(), help="Configuration, e.g. results/default/config.yaml."
)
out_option = click.option("--out", type=FILE, required=True, help="File to write.")

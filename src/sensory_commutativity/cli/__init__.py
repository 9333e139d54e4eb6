"""The command line. Every rule of the workflow calls one of these commands."""

from __future__ import annotations

import os

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    # Jobs run side by side, one thread each; must be set before numpy is imported.
    os.environ.setdefault(_variable, "1")

import sys

import click

from ..errors import UserError
from .config import config
from .predict import predict
from .products import animation, arrays, figure, table, train
from .runs import run

CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 100}


@click.group(context_settings=CONTEXT)
@click.version_option(package_name="sensory-commutativity")
def main() -> None:
    """Play the same actions in two orders from the same start. Do the sensors end equal?

    The workflow calls these commands in the right order: run `make`, or `snakemake --cores all`.
    """


for _command in (table, arrays, train, figure, animation, predict, config, run):
    main.add_command(_command)


def entry_point() -> None:
    """Run a command; an error that the user can correct is one line and exit code 2."""
    try:
        main(standalone_mode=False)
    except click.exceptions.Exit as error:
        sys.exit(error.exit_code)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.ctx.get_help() if error.ctx else main.get_help(click.Context(main)),
                   err=True)  # fmt: skip
        sys.exit(2)
    except click.ClickException as error:
        hint = ""
        if isinstance(error, click.UsageError) and error.ctx is not None:
            hint = f" (see {error.ctx.command_path} --help)"
        _fail(error.format_message() + hint)
    except click.Abort:
        sys.exit(130)
    except UserError as error:
        _fail(str(error))
    except OSError as error:
        if error.filename is None:
            raise
        _fail(f"{error.filename}: {error.strerror}; check the path and its permissions")


def _fail(message: str) -> None:
    print(f"sensory-commutativity: error: {' '.join(message.split())}", file=sys.stderr)
    sys.exit(2)

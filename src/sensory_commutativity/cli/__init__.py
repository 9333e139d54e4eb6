"""The command line: every rule of the workflow calls one of these commands, so that a person can run by hand exactly what a rule runs."""

from __future__ import annotations

import os

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(
        _variable, "1"
    )  # jobs run side by side, one thread each; set before numpy is imported

import sys

import click

from ..errors import UserError
from . import apartment, figures, flatland, masks, navigation, runs, settings

CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 120}


@click.group(context_settings=CONTEXT)
@click.version_option(package_name="sensory-commutativity")
def main() -> None:
    """Play the same actions in two orders from the same start. Did the sensors end equal?

    Commands named after a table write that table; `check` tries a configuration; `figure` and `animation` draw;
    `provenance` says where a file comes from, `compare` how two runs differ, `verify` whether a run is as it was made.
    The workflow calls them in the right order: run `make`, or `snakemake --cores all`.
    """


for _command in (
    figures.animation,
    apartment.apartment_experiments,
    apartment.apartment_experiments_part,
    apartment.apartment_ready,
    *apartment.FROM_EXPERIMENTS,
    settings.check,
    figures.figure,
    flatland.flatland_alternatives,
    flatland.flatland_baselines,
    flatland.flatland_baselines_part,
    flatland.flatland_commutation,
    flatland.flatland_commutation_part,
    flatland.flatland_comparisons,
    flatland.flatland_experiments,
    flatland.flatland_experiments_part,
    flatland.flatland_scp,
    flatland.flatland_sensitivity,
    flatland.flatland_trends,
    *masks.COMMANDS,
    navigation.navigation_action_spaces,
    navigation.navigation_curves,
    navigation.navigation_episode,
    navigation.navigation_run,
    navigation.navigation_scp,
    *navigation.FROM_TABLES,
    figures.paper_comparison,
    runs.checksums,
    runs.compare,
    runs.crate,
    runs.provenance,
    runs.verify,
    settings.resolve,
    settings.schema,
):
    main.add_command(_command)


def run() -> None:
    """Entry point: an error that is the user's to mend becomes one line and exit code 2."""
    try:
        main(standalone_mode=False)
    except click.exceptions.Exit as leave:
        sys.exit(leave.exit_code)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(
            error.ctx.get_help() if error.ctx else main.get_help(click.Context(main)), err=True
        )
        sys.exit(2)
    except click.ClickException as error:
        where = (
            f" ({error.ctx.command_path} --help)"
            if isinstance(error, click.UsageError) and error.ctx
            else ""
        )
        _fail(error.format_message() + where)
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

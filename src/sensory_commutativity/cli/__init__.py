"""The command line. Every rule of the workflow calls one of these commands."""

from __future__ import annotations

import os

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    # Jobs run side by side, one thread each; must be set before numpy is imported.
    os.environ.setdefault(_variable, "1")

import signal
import sys

if os.path.basename(sys.argv[0]) in ("sencom", "sensory-commutativity"):
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # until entry_point: no traceback of the imports

import importlib

import click

from ..errors import UserError
from ..extras import missing_extra
from ..storage.files import printable

CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 100}

COMMANDS = {
    "measure": ("measure", "Measure the SCP of a world's degrees of freedom."),
    "check": ("measure", "Check that a world can be measured."),
    "robot": ("robot", "Describe and check a robot of your own."),
    "predict": ("predict", "Find what changed between two pictures of one camera."),
    "table": ("products", "Compute a table of a study, or a shard of it."),
    "arrays": ("products", "Compute arrays of a study, or a shard of them."),
    "train": ("products", "Train a model of a study."),
    "figure": ("products", "Draw a figure of a study."),
    "animation": ("products", "Write an animation of a study."),
    "config": ("config", "Check, complete or describe a configuration."),
    "run": ("runs", "Check, compare and archive finished runs."),
}
"""Name -> module that is imported when the command is used, and what the list of commands says."""


class LazyGroup(click.Group):
    """A group that imports a command when it is used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        module = importlib.import_module(f".{COMMANDS[name][0]}", __name__)
        command = getattr(module, name)
        assert isinstance(command, click.Command)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])


def _show_version(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    if value:
        from .. import __version__

        click.echo(f"sensory-commutativity {__version__}")
        ctx.exit()


@click.group(cls=LazyGroup, context_settings=CONTEXT)
@click.option("-q", "--quiet", is_flag=True, help="Show no progress bars.")
@click.option("-v", "--verbose", is_flag=True, help="Show where an error arose.")
@click.option(
    "--version", is_flag=True, is_eager=True, expose_value=False, callback=_show_version,
    help="Show the version and exit.",
)  # fmt: skip
def main(quiet: bool, verbose: bool) -> None:
    """Play the same actions in two orders from the same start. Do the sensors end equal?

    `sencom measure corridor` answers it for a small world. The commands from `table` on belong to
    the workflow, which calls them in the right order: run `make`, or `snakemake --cores all`.
    """
    if quiet:
        from ..progress import hide

        hide()


def entry_point() -> None:
    """Run a command; an error that the user can correct is one line and exit code 2.

    Ctrl-C ends it with exit code 130 and prints nothing, whatever it interrupts: an import that is
    interrupted may raise any error.
    """
    if sys.getfilesystemencoding() != "utf-8":  # as under LC_ALL=C: file names would be ASCII
        os.environ["PYTHONUTF8"] = "1"
        os.execv(sys.executable, [sys.executable, *sys.orig_argv[1:]])
    interrupted: list[int] = []

    def interrupt(number: int, frame: object) -> None:
        interrupted.append(number)
        sys.unraisablehook = lambda unraisable: None
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, interrupt)
    try:
        _run_command()
    except BaseException:
        if interrupted:
            sys.exit(130)
        raise


def _run_command() -> None:
    verbose = any(word in ("-v", "--verbose") for word in sys.argv[1:3])
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
        if verbose:
            raise
        _fail(str(error))
    except ModuleNotFoundError as error:
        missing = missing_extra(error)
        if missing is None or verbose:
            raise
        _fail(str(missing))
    except OSError as error:
        if error.filename is None or verbose:
            raise
        _fail(f"{error.filename}: {error.strerror}; check the path and its permissions")


def _fail(message: str) -> None:
    text = printable(" ".join(message.split()))  # names and values come from files
    print(f"sensory-commutativity: error: {text}", file=sys.stderr)
    sys.exit(2)

"""The command line: every rule of the workflow calls one of these commands, so that a person can run by hand exactly what a rule runs."""

from __future__ import annotations

import os

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")  # jobs run side by side, one thread each; set before numpy is imported

import json
import sys
from pathlib import Path

import click

from .config import Config, json_schema, load, write_resolved
from .errors import UserError

CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 120}


class _Config(click.ParamType):
    """A configuration file, loaded and checked."""

    name = "file"

    def convert(self, value, param, ctx) -> Config:
        return value if isinstance(value, Config) else load(value)


class _Part(click.ParamType):
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


def _check_parts(part: tuple[int, int], n: int) -> None:
    if part[1] != n:
        raise click.BadParameter(f"the configuration cuts this work into {n} parts, not {part[1]}; give I/{n}", param_hint="--part")


with_config = click.option("--config", type=_Config(), required=True, help="Configuration, e.g. results/default/config.yaml.")
with_out = click.option("--out", type=click.Path(dir_okay=False, path_type=Path), required=True, help="File to write.")
with_parts = click.argument("parts", nargs=-1, required=True, type=click.Path(path_type=Path))


def _table(option: str):
    text = f"The table {option.replace('-', '_')}."
    return click.option(f"--{option}", type=click.Path(path_type=Path), required=True, help=text)


@click.group(context_settings=CONTEXT)
@click.version_option(package_name="sensory-commutativity")
def main() -> None:
    """Play the same actions in two orders from the same start. Did the sensors end equal?

    Commands named after a table write that table; `check` tries a configuration; `figure` and `animation` draw. The workflow calls them in the
    right order: run `make`, or `snakemake --cores all`.
    """


# ---- configuration ---------------------------------------------------------------------------------------------------------


@main.command()
@click.argument("files", nargs=-1, required=True)
def check(files: tuple[str, ...]) -> None:
    """Check config FILES, each laid over the ones before: settings, the folder for results, and that agents and things fit into their rooms."""
    from .folders import check_writable
    from .worlds.flatland.from_config import check_rooms

    config = load(*files)
    check_writable(config.folder)
    check_rooms(config)
    runs = config.flatland.runs()
    n = sum(run.experiments for run in runs)
    click.echo(f"profile {config.profile}: {n:,} SC-experiments of each degree of freedom in {len(runs)} runs; results go to {config.folder}")


@main.command()
@click.argument("files", nargs=-1, required=True)
@with_out
def resolve(files: tuple[str, ...], out: Path) -> None:
    """Check config FILES, each laid over the ones before, and write all settings with every default filled in."""
    write_resolved(load(*files), out)


@main.command()
@with_out
def schema(out: Path) -> None:
    """Write the JSON schema of the configuration."""
    out.write_text(json.dumps(json_schema(), indent=2) + "\n")


# ---- Flatland --------------------------------------------------------------------------------------------------------------


@main.command()
@with_config
@click.option("--world", required=True, help="A key of flatland.worlds.")
@click.option("--agent", required=True, help="A key of flatland.agents.")
@click.option("--length", type=click.IntRange(1), required=True, help="Actions in a sequence.")
@click.option("--part", type=_Part(), required=True, help="Which of the shares that the configuration cuts the work into.")
@with_out
def flatland_experiments_part(config: Config, world: str, agent: str, length: int, part: tuple[int, int], out: Path) -> None:
    """Play a share of the SC-experiments of an agent in a world."""
    from .stages.flatland_experiments import write_experiments

    runs = {run[:3]: run for run in config.flatland.runs()}
    if (world, agent, length) not in runs:
        known = "; ".join(f"{w} {a} {n}" for w, a, n in runs)
        raise click.UsageError(f"the configuration has no run of world {world!r}, agent {agent!r}, length {length}; it has: {known}")
    run = runs[world, agent, length]
    _check_parts(part, config.flatland.n_jobs(run.experiments))
    write_experiments(config, run, part[0] - 1, out)


@main.command()
@with_config
@with_parts
@with_out
def flatland_experiments(config: Config, parts: tuple[Path, ...], out: Path) -> None:
    """Gather the PARTS of the table flatland_experiments."""
    from .stages.flatland_scp import gather_experiments

    gather_experiments(list(parts), out, config)


@main.command()
@with_config
@_table("flatland-experiments")
@with_out
def flatland_scp(config: Config, flatland_experiments: Path, out: Path) -> None:
    """Estimate the SCP of every degree of freedom."""
    from .stages.flatland_scp import write_scp

    write_scp(flatland_experiments, out, config)


@main.command()
@with_config
@_table("flatland-experiments")
@with_out
def flatland_sensitivity(config: Config, flatland_experiments: Path, out: Path) -> None:
    """Estimate the SCP for all sequence lengths and thresholds."""
    from .stages.flatland_scp import write_sensitivity

    write_sensitivity(flatland_experiments, out, config)


@main.command()
@with_config
@_table("flatland-experiments")
@with_out
def flatland_comparisons(config: Config, flatland_experiments: Path, out: Path) -> None:
    """Compare the degrees of freedom in pairs (McNemar, Holm)."""
    from .stages.flatland_comparisons import write_comparisons

    write_comparisons(flatland_experiments, out, config)


@main.command()
@with_config
@_table("flatland-scp")
@with_out
def flatland_trends(config: Config, flatland_scp: Path, out: Path) -> None:
    """Test whether the SCP falls with the number of objects and with arm length."""
    from .stages.flatland_trends import write_trends

    write_trends(flatland_scp, out, config)


@main.command()
@with_config
@click.option("--world", required=True, help="The reference world or the settled one.")
@click.option("--part", type=_Part(), required=True, help="Which of the shares that the configuration cuts the work into.")
@with_out
def flatland_commutation_part(config: Config, world: str, part: tuple[int, int], out: Path) -> None:
    """Play a share of the experiments on pairs of degrees of freedom."""
    from .stages.flatland_commutation import write_commutation_experiments

    known = config.flatland.commutation_worlds()
    if world not in known:
        raise click.BadParameter(f"no commutation experiments in {world!r}; choose one of {', '.join(known)}", param_hint="--world")
    _check_parts(part, config.flatland.n_commutation_jobs)
    write_commutation_experiments(config, world, part[0] - 1, out)


@main.command()
@with_config
@with_parts
@with_out
def flatland_commutation(config: Config, parts: tuple[Path, ...], out: Path) -> None:
    """Estimate from PARTS the probability that two degrees of freedom commute."""
    from .stages.flatland_commutation import write_commutation

    write_commutation(list(parts), out, config)


@main.command()
@with_config
@click.option("--dof", required=True, help="A degree of freedom, e.g. left-elbow.")
@with_out
def flatland_baselines_part(config: Config, dof: str, out: Path) -> None:
    """Measure naive change and prediction error of one degree of freedom."""
    from .stages.flatland_baselines import write_baseline
    from .worlds.flatland.agent import Polyphemus

    known = [d.name for d in Polyphemus().dofs]
    if dof not in known:
        raise click.BadParameter(f"there is no {dof!r}; choose one of {', '.join(known)}", param_hint="--dof")
    write_baseline(config, dof, out)


@main.command()
@with_config
@with_parts
@with_out
def flatland_baselines(config: Config, parts: tuple[Path, ...], out: Path) -> None:
    """Gather PARTS and work out the excess prediction errors."""
    from .stages.flatland_baselines import gather_baselines

    gather_baselines(list(parts), out, config)


@main.command()
@with_config
@_table("flatland-baselines")
@_table("flatland-scp")
@with_out
def flatland_alternatives(config: Config, flatland_baselines: Path, flatland_scp: Path, out: Path) -> None:
    """Correlate the two alternatives with the SCP."""
    from .stages.flatland_baselines import write_alternatives

    write_alternatives(flatland_baselines, flatland_scp, out, config)


# ---- what people look at ---------------------------------------------------------------------------------------------------


@main.command()
@with_config
@click.option("--tables", type=click.Path(path_type=Path), required=True, help="Folder of the tables.")
@with_out
def paper_comparison(config: Config, tables: Path, out: Path) -> None:
    """Set the paper's claims beside what was measured."""
    from .stages.paper_comparison import write_paper_comparison

    write_paper_comparison(tables, out, config)


@main.command()
@with_config
@click.argument("name")
@click.option("--tables", type=click.Path(path_type=Path), required=True, help="Folder of the tables.")
@with_out
def figure(config: Config, name: str, tables: Path, out: Path) -> None:
    """Draw the figure NAME as OUT (PNG) and beside it as PDF."""
    from .figures.catalogue import FIGURES

    if name not in FIGURES:
        raise click.BadParameter(f"there is no figure {name!r}; choose one of {', '.join(FIGURES)}", param_hint="NAME")
    from .figures.style import draw_figure

    draw_figure(name, tables, out, config)


@main.command()
@with_config
@click.option("--dof", default="left-shoulder", show_default=True, help="The degree of freedom that is driven.")
@with_out
def animation(config: Config, dof: str, out: Path) -> None:
    """Animate one SC-experiment that does not commute, both orders side by side, as a GIF."""
    from .figures.animation import animate_experiment

    animate_experiment(config, dof, out)


def run() -> None:
    """Entry point: an error that is the user's to mend becomes one line and exit code 2."""
    try:
        main(standalone_mode=False)
    except click.exceptions.Exit as leave:
        sys.exit(leave.exit_code)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.ctx.get_help() if error.ctx else main.get_help(click.Context(main)), err=True)
        sys.exit(2)
    except click.ClickException as error:
        where = f" ({error.ctx.command_path} --help)" if isinstance(error, click.UsageError) and error.ctx else ""
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

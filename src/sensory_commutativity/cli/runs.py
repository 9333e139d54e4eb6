"""Commands on finished runs: provenance, comparison, verification, and a crate for an archive."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..storage.files import printable
from .options import FILE, out_option, say

if TYPE_CHECKING:
    from ..runs.compare import TableDifference
    from ..runs.verify import Verification

FOLDER = click.Path(exists=True, file_okay=False, path_type=Path)
STATUS = {
    "identical": "identical",
    "rounding": "equal but for rounding",
    "within": "within their intervals",
    "beyond": "BEYOND their intervals",
    "differs": "differs",
    "rows": "other rows",
}


@click.group()
def run() -> None:
    """Check, compare and archive finished runs."""


@run.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def provenance(file: Path, as_json: bool) -> None:
    """Print where a file of a run comes from.

    FILE is any file of a run: a table, an array file, a model, a figure, an animation, the report,
    or one that carries none itself, such as the settings: then the provenance is that of the run.
    """
    from ..runs.origin import read_origin

    origin = read_origin(file)
    if as_json:
        click.echo(json.dumps(origin, indent=2))
        return
    width = min(max(len(printable(key)) for key in origin), 30)
    for key, value in origin.items():
        for i, line in enumerate(_lines(key, value)):
            say(f"{printable(key) if i == 0 else '':{width}}  {line}")


def _lines(key: str, value: str) -> list[str]:
    """The lines that show a value; control characters are escaped."""
    if key in ("packages", "inputs"):
        try:
            return [printable(f"{name} {version}") for name, version in json.loads(value).items()]
        except (ValueError, AttributeError):
            pass
    return [printable(value)]


@run.command()
@click.argument("run_a", type=FOLDER)
@click.argument("run_b", type=FOLDER)
def compare(run_a: Path, run_b: Path) -> None:
    """Compare the tables of two runs, RUN_A and RUN_B.

    Runs are folders like results/paper. Says which tables differ, by how much, and whether beyond
    their intervals. The exit code is 1 if a table is missing in one run, unreadable, has other
    rows, or differs beyond its intervals.
    """
    from ..runs.compare import compare_runs, find_tables_folder
    from ..runs.origin import read_origin

    differences = compare_runs(run_a, run_b)
    readable = [
        d.table for d in differences if d.status != "unreadable" and not d.status.startswith("only")
    ]
    if readable:
        origins = [
            read_origin(find_tables_folder(folder) / f"{readable[0]}.parquet")
            for folder in (run_a, run_b)
        ]
        for key in ("profile", "config_sha256", "root_seed", "git_commit", "python", "platform"):
            a, b = (origin.get(key, "?") for origin in origins)
            say(f"{key:14} {a if a == b else f'{a}  |  {b}'}")
        click.echo("")
    for difference in differences:
        say(_describe(difference))
    bad = [d for d in differences if not d.is_by_chance]
    identical = sum(d.status == "identical" for d in differences)
    by_chance = len(differences) - identical - len(bad)
    click.echo(
        f"\n{len(differences)} tables: {identical} identical, {by_chance} within what chance does, "
        f"{len(bad)} to look at"
    )
    if bad:
        raise SystemExit(1)


def _describe(difference: TableDifference) -> str:
    """One line about how a table differs."""
    text = f"{difference.table:34} {STATUS.get(difference.status, difference.status)}"
    if difference.differing_rows:
        text += f"; {difference.differing_rows:,} of {difference.rows:,} rows"
        if difference.intervals and difference.status in ("within", "beyond"):
            intervals = f"{difference.disjoint_intervals:,} of {difference.intervals:,}"
            text += f", {intervals} intervals apart"
    if difference.largest_difference:
        text += f"; most: {difference.largest_difference}"
    return text


@run.command()
@out_option
def checksums(out: Path) -> None:
    """Write the SHA-256 of every file of a run.

    The run is the one whose folder holds OUT. `sha256sum -c` reads OUT. A file that was not written
    since OUT was last written keeps its line, so that damage does not get a new checksum.
    """
    from ..runs.checksums import write_manifest

    made, kept = write_manifest(out)
    click.echo(f"{out}: {made:,} checksums made, {kept:,} kept", err=True)


@run.command()
@click.argument("folder", metavar="RUN", type=FOLDER)
@click.option("--remove", is_flag=True, help="Delete bad files; the workflow makes them again.")
@click.option("--files-only", is_flag=True, help="Do not check whether the files belong together.")
@click.option("--no-redraw", is_flag=True, help="Do not draw the figures again to compare them.")
def verify(folder: Path, remove: bool, files_only: bool, no_redraw: bool) -> None:
    """Check that a run is whole and belongs together.

    RUN is a folder like results/default. Names every file that is damaged, missing or changed.
    Files are compared with the checksums that the workflow writes at its end; files without one are
    read from end to end. Links are not followed.

    Then names what contradicts the rest: tables that are incomplete or were computed with other
    settings, files that were computed from others than are there, figures that are not what their
    tables give (each is drawn again), a report with other figures, a mixture of configurations or
    commits. The exit code is 1 if a file is bad or contradicts the rest.
    """
    from ..runs.verify import verify_run

    result = verify_run(folder)
    say_bad_files(folder, result)
    contradictions = False
    if not files_only and not remove:
        contradictions = say_consistency(folder, not no_redraw)
    if result.bad:
        say_remedy(folder, result, remove)
    if result.bad or contradictions:
        raise SystemExit(1)


def say_bad_files(folder: Path, result: Verification) -> None:
    """Print the bad files, one a line, and how many files were checked."""
    for bad in result.bad:
        say(f"{folder / bad.path}: {bad.status}: {bad.reason}")
    for name, n in sorted(result.absent.items()):
        kind = "raw data" if name == "data" else "models"
        say(f"{folder / name}: {kind} not here ({n:,} files)")
    unchecked = ""
    if result.unchecked:
        unchecked = f", {result.unchecked:,} of types that cannot be checked"
    files = "file" if len(result.bad) == 1 else "files"
    say(
        f"{len(result.bad):,} bad {files}; {result.recorded:,} have their checksum, "
        f"{result.readable:,} without one are readable{unchecked}"
    )


def say_consistency(folder: Path, redraw: bool) -> bool:
    """Print what contradicts the rest of a run, and whether the run is clean."""
    from ..runs.consistency import check_consistency

    result = check_consistency(folder, redraw)
    for path, reason in result.contradictions:
        say(f"{folder / path}: contradicts the run: {reason}")
    for note in result.notes:
        say(f"note: {note}")
    n = len(result.contradictions)
    if result.is_clean:
        say("a clean run: all files come from one configuration and one commit")
    else:
        say(f"not a clean run: {n:,} contradiction{'' if n == 1 else 's'}, "
            f"{len(result.notes):,} note{'' if len(result.notes) == 1 else 's'}")  # fmt: skip
    return n > 0


def say_remedy(folder: Path, result: Verification, remove: bool) -> None:
    """Delete bad files if asked to, or print what to do about them."""
    from ..runs.verify import remove_bad_files

    if remove:
        for name in remove_bad_files(folder, result):
            say(f"{folder / name}: deleted")
        say("run the workflow again: it makes what is missing, and what depends on it")
    elif "data" in result.absent:
        say("get the bad files again from where this run comes from")
    else:
        changed = any(bad.status == "changed" for bad in result.bad)
        ended = "if a run has not ended, run the workflow to its end; else " if changed else ""
        command = f"sensory-commutativity run verify {folder} --remove"
        say(f"{ended}{command} deletes what is bad; then run the workflow again")


@run.command()
@click.argument("folder", metavar="RUN", type=FOLDER)
@click.option("--out", type=FILE, required=True, help="ZIP file to write.")
@click.option("--with-data", is_flag=True, help="Include the raw data, which no figure needs.")
def crate(folder: Path, out: Path, with_data: bool) -> None:
    """Write a run as a Workflow Run RO-Crate, for an archive.

    RUN is a folder like results/default. The crate holds settings, tables, models, figures and the
    workflow.
    """
    from ..runs.crate import write_crate

    n = write_crate(folder, out, with_data)
    click.echo(f"{out}: {n:,} files, {out.stat().st_size / 1e6:.1f} MB")

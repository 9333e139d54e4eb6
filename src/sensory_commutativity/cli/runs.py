"""Commands on finished runs: where a file comes from, how two runs differ, and whether one is as it was made."""

from __future__ import annotations

import json
from pathlib import Path

import click

FOLDER = click.Path(exists=True, file_okay=False, path_type=Path)
SAID = {
    "identical": "identical",
    "rounding": "equal but for rounding",
    "within": "within their intervals",
    "beyond": "BEYOND their intervals",
    "differs": "differs",
    "rows": "other rows",
}


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def provenance(file: Path, as_json: bool) -> None:
    """Where does FILE come from? A table, an array file, a model or a figure of a run."""
    from ..runs.origin import read_origin

    found = read_origin(file)
    if as_json:
        click.echo(json.dumps(found, indent=2))
        return
    width = max(map(len, found))
    for key, value in found.items():
        for i, line in enumerate(_lines(key, value)):
            click.echo(f"{key if i == 0 else '':{width}}  {line}")


def _lines(key: str, value: str) -> list[str]:
    return (
        [f"{name} {version}" for name, version in json.loads(value).items()]
        if key == "packages"
        else [value]
    )


@click.command()
@click.argument("run_a", type=FOLDER)
@click.argument("run_b", type=FOLDER)
def compare(run_a: Path, run_b: Path) -> None:
    """Which tables differ between RUN_A and RUN_B (folders like results/paper), by how much, and beyond their intervals or not?

    The exit code is 1 if a table is missing in one of them, cannot be read, has other rows, or has values beyond their intervals.
    """
    from ..runs.compare import compare_runs, find_tables_folder
    from ..runs.origin import read_origin

    runs = (run_a, run_b)
    found = compare_runs(*runs)
    readable = [
        table.table
        for table in found
        if table.status != "unreadable" and not table.status.startswith("only")
    ]
    if readable:
        origins = [read_origin(find_tables_folder(run) / f"{readable[0]}.parquet") for run in runs]
        for key in ("profile", "config_sha256", "root_seed", "git_commit", "python", "platform"):
            a, b = (origin.get(key, "?") for origin in origins)
            click.echo(f"{key:14} {a if a == b else f'{a}  |  {b}'}")
        click.echo("")
    for table in found:
        beyond = (
            f", {table.disjoint_intervals:,} of {table.intervals:,} intervals apart"
            if table.intervals and table.status in ("within", "beyond")
            else ""
        )
        rows = f"; {table.differing_rows:,} of {table.rows:,} rows{beyond}" if table.differing_rows else ""
        click.echo(
            f"{table.table:26} {SAID.get(table.status, table.status)}{rows}{f'; most: {table.largest_difference}' if table.largest_difference else ''}"
        )
    bad = [table for table in found if not table.is_by_chance]
    same = sum(table.status == "identical" for table in found)
    click.echo(
        f"\n{len(found)} tables: {same} identical, {len(found) - same - len(bad)} within what chance does, {len(bad)} to look at"
    )
    if bad:
        raise SystemExit(1)


@click.command()
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    required=True,
    help="File to write, in the run's folder.",
)
def checksums(out: Path) -> None:
    """Write the SHA-256 of every file of the run in whose folder OUT lies, as `sha256sum -c` reads them.

    A file that was not written since OUT was last written keeps its line, so that damage is not taken for what the run made.
    """
    from ..runs.checksums import write_manifest

    made, kept = write_manifest(out)
    click.echo(f"{out}: {made:,} checksums made, {kept:,} kept", err=True)


@click.command()
@click.argument("run", type=FOLDER)
@click.option(
    "--remove", is_flag=True, help="Delete what is bad, so that the workflow makes it anew."
)
def verify(run: Path, remove: bool) -> None:
    """Is RUN (a folder like results/default) as it was made? Names every file that is damaged, missing or changed.

    Files are held against the checksums that the workflow writes when it ends; those without one are read from end to end. The exit code is 1 if
    something is bad.
    """
    from ..runs.verify import remove_bad_files, verify_run

    found = verify_run(run)
    for bad in found.bad:
        click.echo(f"{run / bad.path}: {bad.status}: {bad.reason}")
    for folder, n in sorted(found.absent.items()):
        click.echo(
            f"{run / folder}: {'raw data' if folder == 'data' else 'models'} not here ({n:,} files)"
        )
    unknown = f", {found.unchecked:,} of kinds that cannot be checked" if found.unchecked else ""
    files = "file" if len(found.bad) == 1 else "files"
    click.echo(
        f"{len(found.bad):,} bad {files}; {found.recorded:,} as their checksums say, {found.readable:,} without one can be read{unknown}"
    )
    if not found.bad:
        return
    if remove:
        for name in remove_bad_files(run, found):
            click.echo(f"{run / name}: deleted")
        click.echo("run the workflow again: it makes anew what is missing, and what depends on it")
    elif "data" in found.absent:
        click.echo("take the bad files anew from where this run comes from")
    else:
        ended = (
            "if a run has not ended, run the workflow to its end; else "
            if any(bad.status == "changed" for bad in found.bad)
            else ""
        )
        click.echo(
            f"{ended}sensory-commutativity run verify {run} --remove deletes what is bad; then run the workflow again"
        )
    raise SystemExit(1)


@click.command()
@click.argument("run", type=FOLDER)
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    required=True,
    help="ZIP file to write.",
)
@click.option("--with-data", is_flag=True, help="Put in the raw data too, which no figure needs.")
def crate(run: Path, out: Path, with_data: bool) -> None:
    """Write RUN (a folder like results/default) as a Workflow Run RO-Crate, for an archive: settings, tables, models, figures and the workflow."""
    from ..runs.crate import write_crate

    n = write_crate(run, out, with_data)
    click.echo(f"{out}: {n:,} files, {out.stat().st_size / 1e6:.1f} MB")


@click.group()
def run() -> None:
    """Check, compare and archive finished runs."""


for _command in (provenance, compare, checksums, verify, crate):
    run.add_command(_command)

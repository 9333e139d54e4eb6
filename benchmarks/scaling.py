"""The speed-up from a second core, and the overhead of the workflow.

Run by ``make scaling``, which takes ten minutes; nothing else should run meanwhile.

Scaling: Snakemake computes the SC-experiments of Flatland and of the apartment, cut into equal
jobs, on one core and then on two.

Overhead: the whole workflow at the paper's sizes, with a stand-in for the command line that writes
the files of every job and does no work, so that Snakemake alone is measured. It is compared with
the time that the jobs themselves took: in the run of ``results/paper``, if its benchmark files are
there, or in the run given by ``--benchmarks``.
"""

from __future__ import annotations

import argparse
import csv
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
BIN = Path(sys.executable).parent
JOBS = 8
"""Chosen: the jobs of a study are equally long, so two cores share them equally."""


class Study(NamedTuple):
    """SC-experiments that are cut into JOBS jobs: a table, its run, and settings.

    `before` names files that are made once and not measured.
    """

    table: str
    run: str
    settings: str
    before: tuple[str, ...] = ()


STUDIES = {
    "flatland": Study(
        "flatland_experiments",
        "furnished.polyphemus.50",
        "flatland: {reference: {experiments: 8000}, experiments_per_job: 1000}",
    ),
    "apartment": Study(
        "apartment_experiments",
        "fetch.rs-stand-in.anywhere.50",
        "apartment: {reference: {experiments: 40}, experiments_per_job: 5}",
        ("data/apartment_ready/fetch.rs-stand-in.anywhere.json",),
    ),
}
STAND_IN = """#!{python}
import sys
from pathlib import Path
for option, value in zip(sys.argv, sys.argv[1:]):
    if option in ("--out", "--curve"):
        path = Path(value)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"x")
        if path.suffix == ".png":
            path.with_suffix(".pdf").write_bytes(b"x")
"""
"""A program in place of ``sensory-commutativity`` that only writes the files it is asked for."""


def copy_workflow(folder: Path) -> Path:
    """Copy the workflow without results."""
    for name in ("workflow", "config", "profiles"):
        shutil.copytree(ROOT / name, folder / name)
    return folder


def snakemake(folder: Path, *arguments: str, first: Path = BIN) -> float:
    """Run Snakemake with the folder `first` at the front of PATH; return the seconds it took."""
    path = os.pathsep.join([str(first), str(BIN), os.environ["PATH"]])
    start = time.perf_counter()
    run = subprocess.run(
        [str(BIN / "snakemake"), "--quiet", "progress", "rules", *arguments],
        cwd=folder,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
    )
    if run.returncode:
        sys.exit(run.stderr[-3000:])
    return time.perf_counter() - start


def total_job_seconds(benchmarks: Path) -> float:
    """Sum of the run times of all jobs in a folder of benchmark files."""
    total = 0.0
    for file in benchmarks.rglob("*.tsv"):
        with file.open() as lines:
            total += sum(float(row["s"]) for row in csv.DictReader(lines, delimiter="\t"))
    return total


def measure_scaling(name: str) -> None:
    study, seconds = STUDIES[name], {}
    for cores in (1, 2):
        with tempfile.TemporaryDirectory() as temporary:
            folder = copy_workflow(Path(temporary))
            (folder / "layer.yaml").write_text(f"profile: scaling\n{study.settings}\n")
            results = Path("results/scaling")
            shards = results / "data" / study.table
            files = [f"{shards}/{study.run}.{i + 1}-of-{JOBS}.parquet" for i in range(JOBS)]
            options = ["--configfile", "config/config.yaml", "layer.yaml", "--cores", str(cores)]
            if study.before:
                snakemake(folder, *options, *(str(results / file) for file in study.before))
            seconds[cores] = snakemake(folder, *options, *files)
            in_jobs = total_job_seconds(folder / results / "benchmarks" / study.table)
        overhead = 1 - in_jobs / cores / seconds[cores]
        print(
            f"{name}: {JOBS} jobs on {cores} core{'s' * (cores > 1)}: {seconds[cores]:6.1f} s; "
            f"in the jobs {in_jobs:6.1f} s, overhead {overhead:.1%}",
            flush=True,
        )
    print(f"{name}: speed-up from 1 to 2 cores {seconds[1] / seconds[2]:.2f}", flush=True)


def measure_overhead(benchmarks: Path) -> None:
    with tempfile.TemporaryDirectory() as temporary:
        folder = copy_workflow(Path(temporary))
        stand_in = folder / "bin" / "sensory-commutativity"
        stand_in.parent.mkdir()
        stand_in.write_text(STAND_IN.format(python=sys.executable))
        stand_in.chmod(stand_in.stat().st_mode | stat.S_IXUSR)
        options = ["--configfile", "config/paper.yaml", "--cores", "2"]
        seconds = snakemake(folder, *options, first=stand_in.parent)
        n = sum(1 for path in (folder / "results" / "paper").rglob("*") if path.is_file())
    print(
        f"the workflow alone, at the paper's sizes, on 2 cores: {seconds:.0f} s for {n:,} files",
        flush=True,
    )
    in_jobs = total_job_seconds(benchmarks)
    if not in_jobs:
        print(
            f"no benchmark files in {benchmarks}, so there is nothing to compare with; "
            "run `make paper`, or give --benchmarks"
        )
        return
    print(
        f"in the jobs: {in_jobs / 3600:.1f} core hours, {in_jobs / 7200:.1f} h on 2 cores; "
        f"overhead {seconds / (seconds + in_jobs / 2):.1%}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "what",
        nargs="*",
        default=[*STUDIES, "overhead"],
        help="flatland, apartment, overhead; default: all",
    )
    parser.add_argument(
        "--benchmarks",
        type=Path,
        default=ROOT / "results" / "paper" / "benchmarks",
        help="benchmark files of a run",
    )
    arguments = parser.parse_args()
    for what in arguments.what:
        if what == "overhead":
            measure_overhead(arguments.benchmarks)
        else:
            measure_scaling(what)


if __name__ == "__main__":
    main()

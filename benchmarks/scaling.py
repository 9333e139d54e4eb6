"""What a second core gives, and what the workflow itself costs. Run by `make scaling`, which takes a quarter of an hour; nothing else should run.

Scaling: the SC-experiments of Flatland and of the apartment, cut into equal jobs, are made by Snakemake on one core and on two, each time anew.
Overhead: the whole workflow at the paper's sizes, with a command in place of each job's own that writes its files and does no work; so what is
measured is Snakemake alone. It is held against what the jobs themselves took in the run of `results/paper`, where its benchmark files lie, or in the
run named by --benchmarks.
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

ROOT = Path(__file__).resolve().parents[1]
BIN = Path(sys.executable).parent
STAGES = {
    "2-D": (
        "flatland: {reference: {experiments: 8000}, experiments_per_job: 1000}",
        "flatland_experiments",
        "furnished.polyphemus.50.{}-of-8.parquet",
        8,
    ),
    "3-D": (
        "apartment: {reference: {experiments: 40}, experiments_per_job: 5}",
        "apartment_experiments",
        "fetch.rs-stand-in.anywhere.50.{}-of-8.parquet",
        8,
    ),
}
"""Stage -> settings, folder of the raw data, their files, how many."""
STAND_IN = """#!{python}
import sys
from pathlib import Path
given = sys.argv[1:]
for option in ("--out", "--predictor", "--model"):
    for at in [i for i, argument in enumerate(given) if argument == option]:
        path = Path(given[at + 1])
        if option != "--out" and (not path.suffix or path.exists()):
            continue  # the name of a model, or an input
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"x")
        if path.suffix == ".png":
            path.with_suffix(".pdf").write_bytes(b"x")
"""


def workflow(folder: Path) -> Path:
    """A copy of the workflow without results."""
    shutil.copy(ROOT / "Snakefile", folder)
    for name in ("workflow", "config"):
        shutil.copytree(ROOT / name, folder / name)
    return folder


def snakemake(folder: Path, *arguments: str, first: Path = BIN) -> float:
    """Run it; return the seconds that it took."""
    environment = {
        **os.environ,
        "PATH": f"{first}{os.pathsep}{BIN}{os.pathsep}{os.environ['PATH']}",
    }
    begin = time.perf_counter()
    run = subprocess.run(
        [str(BIN / "snakemake"), "--quiet", "progress", "rules", *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
    )
    if run.returncode:
        sys.exit(run.stderr[-3000:])
    return time.perf_counter() - begin


def seconds_of_jobs(benchmarks: Path) -> float:
    """What the jobs of a run took, all together."""
    total = 0.0
    for file in benchmarks.rglob("*.tsv"):
        with file.open() as lines:
            total += sum(float(row["s"]) for row in csv.DictReader(lines, delimiter="\t"))
    return total


def scaling(stage: str) -> None:
    settings, kind, name, n = STAGES[stage]
    took = {}
    for cores in (1, 2):
        with tempfile.TemporaryDirectory() as place:
            folder = workflow(Path(place))
            (folder / "overlay.yaml").write_text(f"profile: scaling\n{settings}\n")
            files = [f"results/scaling/data/{kind}/{name.format(i + 1)}" for i in range(n)]
            given = ["--configfile", "config/default.yaml", "overlay.yaml", "--cores", str(cores)]
            if kind == "apartment_experiments":  # what is made once is no part of the stage
                snakemake(
                    folder,
                    *given,
                    "results/scaling/data/apartment_ready/fetch.rs-stand-in.anywhere.json",
                )
            took[cores] = snakemake(folder, *given, *files)
            inner = seconds_of_jobs(folder / "results" / "scaling" / "benchmarks" / f"{kind}_part")
            print(f"{stage}: {n} jobs on {cores} core{'s' * (cores > 1)}: {took[cores]:6.1f} s; the jobs' own {inner:6.1f} s, "
                  f"i.e. {1 - inner / cores / took[cores]:.1%} around them", flush=True)  # fmt: skip
    print(f"{stage}: speed-up from 1 to 2 cores {took[1] / took[2]:.2f}", flush=True)


def overhead(benchmarks: Path) -> None:
    with tempfile.TemporaryDirectory() as place:
        folder = workflow(Path(place))
        stand_in = folder / "bin" / "sensory-commutativity"
        stand_in.parent.mkdir()
        stand_in.write_text(STAND_IN.format(python=sys.executable))
        stand_in.chmod(stand_in.stat().st_mode | stat.S_IXUSR)
        took = snakemake(
            folder, "--configfile", "config/paper.yaml", "--cores", "2", first=stand_in.parent
        )
        n = sum(1 for path in (folder / "results" / "paper").rglob("*") if path.is_file())
    print(
        f"the workflow itself, at the paper's sizes, on 2 cores: {took:.0f} s for {n:,} files",
        flush=True,
    )
    own = seconds_of_jobs(benchmarks)
    if own:
        print(
            f"the jobs themselves: {own / 3600:.1f} core hours, {own / 7200:.1f} h on 2 cores; overhead {took / (took + own / 2):.1%}"
        )
    else:
        print(
            f"no benchmark files in {benchmarks}, so there is nothing to hold that against; run `make paper`, or give --benchmarks"
        )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "what", nargs="*", default=[*STAGES, "overhead"], help="2-D, 3-D, overhead; all by default"
    )
    parser.add_argument(
        "--benchmarks",
        type=Path,
        default=ROOT / "results" / "paper" / "benchmarks",
        help="benchmark files of a run",
    )
    given = parser.parse_args()
    for what in given.what:
        if what == "overhead":
            overhead(given.benchmarks)
        else:
            scaling(what)


if __name__ == "__main__":
    main()

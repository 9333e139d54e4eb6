# What all rules share: the checked configuration, the folders, and when a rule must run again.
import hashlib
import json
import shlex
import sys
from pathlib import Path

from sensory_commutativity import __version__
from sensory_commutativity.checks import check_run
from sensory_commutativity.config import LEARNED, validate, write_resolved
from sensory_commutativity.errors import ConfigError, UserError
from sensory_commutativity.figures.catalogue import (
    ARRAYS,
    COMPARED,
    FIGURES,
    source_file,
)
from sensory_commutativity.folders import hold
from sensory_commutativity.masks.from_config import (
    experiments_of_job,
    map_jobs,
    pairs_of_job,
    settings_of_data,
    settings_of_judging,
    settings_of_map,
    settings_of_tests,
    settings_of_training,
    tuple_jobs,
    tuple_runs,
)
from sensory_commutativity.runs.checksums import MANIFEST
from sensory_commutativity.tables import TABLES as SCHEMAS
from sensory_commutativity.worlds.apartment.from_config import (
    contents,
    settings_of_run,
    settings_of_start,
)
from sensory_commutativity.worlds.flatland.agent import Polyphemus
from sensory_commutativity.yamlfile import read_yaml

try:
    # Snakemake takes the last of two equal keys without a word
    for file in workflow.configfiles:
        read_yaml(file, ConfigError, "a config file, e.g. config/default.yaml")
    CONFIG = validate(config)
    if workflow.is_main_process:  # not again before every job of a cluster
        check_run(CONFIG)
except UserError as error:
    print(f"error: {' '.join(str(error).split())}", file=sys.stderr)
    sys.exit(2)

RESULTS = CONFIG.folder
DATA = RESULTS / "data"
MODELS = RESULTS / "models"
TABLES = RESULTS / "tables"
DRAWN = RESULTS / "figures"
LOGS = RESULTS / "logs"
BENCHMARKS = RESULTS / "benchmarks"
CHECKSUMS = RESULTS / MANIFEST
RESOLVED = (
    RESULTS / "config.yaml"
)  # no rule's input: what a rule depends on is in its params

FLATLAND = CONFIG.flatland
APARTMENT = CONFIG.apartment
MASKS = CONFIG.masks
NAVIGATION = CONFIG.navigation
RUNS = {f"{run.world}.{run.agent}.{run.length}": run for run in FLATLAND.runs()}
TUPLE_RUNS = tuple_runs(CONFIG)
DOFS = [dof.name for dof in Polyphemus().dofs]


wildcard_constraints:
    world="|".join(FLATLAND.worlds),
    agent="|".join(FLATLAND.agents),
    dof="|".join(DOFS),
    length=r"\d+",
    robot="|".join(APARTMENT.robots),
    scene="|".join(APARTMENT.scenes),
    start="anywhere|within-reach",
    action_space="|".join(NAVIGATION.action_spaces),
    seed=r"\d+",
    split="training|validation",
    run="|".join(TUPLE_RUNS),
    model="raft|flownet|difference",
    part=r"\d+",
    parts=r"\d+",


def digest(*settings):
    """A rule's params: it runs again when these settings or the package's version change, and only then."""
    text = json.dumps(
        [__version__, CONFIG.seed, *settings],
        default=lambda section: section.model_dump(mode="json"),
    )
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def growing(amount):
    """A resource, memory in MB or run time in minutes, that a job is given more of each time that it is tried again."""
    return lambda wildcards, attempt: amount * attempt


def folder_of(inputs, otherwise):
    """The folder in which a rule's inputs of this name lie: on a machine without the shared disk, a copy's."""
    return lambda wildcards, input: next(
        (Path(file).parent for file in input.get(inputs, [])), otherwise
    )


onstart:
    try:
        hold(RESULTS)
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
    write_resolved(CONFIG, Path(RESOLVED))


if workflow.remote_exec:  # a job on another machine, which may not see the file
    write_resolved(CONFIG, Path(RESOLVED))

# What all rules share: the checked configuration, the folders, the commands, and the settings that
# each rule depends on.
import sys
from pathlib import Path

from sensory_commutativity.errors import ConfigError, UserError
from sensory_commutativity.runs.checksums import MANIFEST
from sensory_commutativity.storage.folders import lock_folder
from sensory_commutativity.storage.yamlfile import read_yaml
from sensory_commutativity.studies.check import check_run
from sensory_commutativity.studies.declarations import (
    Animation,
    Arrays,
    Figure,
    Model,
    Table,
)
from sensory_commutativity.studies.loading import validate, write_resolved
from sensory_commutativity.studies.registry import (
    declarations,
    find,
    find_product,
    input_shards,
    settings_digest,
)

try:
    # Snakemake silently takes the last of two equal keys.
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
FIGURES = RESULTS / "figures"
LOGS = RESULTS / "logs"
BENCHMARKS = RESULTS / "benchmarks"
CHECKSUMS = RESULTS / MANIFEST
RESOLVED = RESULTS / "config.yaml"  # no rule's input: rules depend on their params


wildcard_constraints:
    run=r"[a-z0-9][a-z0-9.-]*?",
    part=r"\d+-of-\d+",


def shards(name, run=None):
    """Files of all shards of a table, of arrays or of a model, or of those of one run."""
    product = find_product(name)
    found = product.shards.of_run(CONFIG, run) if run else product.shards.all(CONFIG)
    return [RESULTS / product.file(shard) for shard in found]


def shard_of(product, wildcards):
    """The shard of a table or of arrays, or the run of a model, that a job makes."""
    part = f".{wildcards.part}" if "part" in wildcards.keys() else ""
    return product.shards.find(CONFIG, f"{wildcards.run}{part}")


def inputs(name):
    """Files that a shard, or the model or animation of a run, is computed from."""
    product = find_product(name)
    return lambda wildcards: [
        RESULTS / source.file(one)
        for source, chosen in input_shards(
            product, CONFIG, shard_of(product, wildcards)
        )
        for one in chosen
    ]


def settings(name, kind=None):
    """Hash of the settings that a product depends on: a rule runs again if it changes."""
    product = find(kind, name) if kind else find_product(name)
    if product.shards is None or isinstance(product, (Table, Arrays)):
        return settings_digest(product, CONFIG)
    return lambda wildcards: settings_digest(product, CONFIG, wildcards.run)


def shard_settings(name):
    """The same for a shard, with the units that it holds."""
    product = find_product(name)

    def of_job(wildcards):
        shard = shard_of(product, wildcards)
        digest = settings_digest(product, CONFIG, shard.run)
        return f"{digest} {shard.start}-{shard.stop}"

    return of_job


def scale_with_attempt(amount):
    """A resource, memory in MB or run time in minutes, of which every retry gets more."""
    return lambda wildcards, attempt: amount * attempt


onstart:
    try:
        lock_folder(RESULTS)
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
    write_resolved(CONFIG, Path(RESOLVED))


if workflow.remote_exec:  # a job on another machine, which may not see the file
    write_resolved(CONFIG, Path(RESOLVED))

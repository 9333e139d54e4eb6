# What all rules share: the checked configuration, the folders, the commands, and the settings that
# each rule depends on.
import sys
from pathlib import Path

try:
    from sensory_commutativity.errors import ConfigError, UserError
except ModuleNotFoundError:
    sys.exit(
        "error: the package sensory-commutativity is not installed; run make in the repository, or "
        "pip install 'sensory-commutativity[workflow]'"
    )
from sensory_commutativity.runs.checksums import MANIFEST
from sensory_commutativity.storage.folders import lock_folder
from sensory_commutativity.storage.hashing import digest
from sensory_commutativity.storage.yamlfile import read_yaml
from sensory_commutativity.studies.apartment.builders import start_settings
from sensory_commutativity.studies.check import check_run
from sensory_commutativity.studies.declarations import (
    Animation,
    Arrays,
    Figure,
    Model,
    Table,
)
from sensory_commutativity.studies.loading import (
    remove_keys,
    validate,
    write_resolved,
)
from sensory_commutativity.studies.paths import resolve_merged_paths
from sensory_commutativity.studies.registry import (
    configured,
    find,
    find_product,
    input_shards,
    settings_digest,
)

PLANNING = {"-n", "--dry-run", "--dryrun", "--lint", "--summary", "--list", "--dag"}
"""Options with which Snakemake writes no results, also beside a run that does."""


def read_config():
    """The settings that Snakemake merged, checked, with paths relative to the current folder."""
    given = workflow.config_settings.configfiles  # these go over the Snakefile's own
    own = [file for file in workflow.configfiles if file not in given]
    files = [Path(file) for file in (*own, *given)]
    layers = [  # Snakemake silently takes the last of two equal keys
        read_yaml(file, ConfigError, "a config file, e.g. config/config.yaml")
        for file in files
    ]
    folders = [file.parent for file in files]
    merged = remove_keys(config, layers)  # Snakemake cannot remove a key
    return validate(
        resolve_merged_paths(merged, list(zip(layers, folders, strict=True)))
    )


try:
    CONFIG = read_config()
    if workflow.is_main_process:  # not again before every job of a cluster
        check_run(CONFIG)
        if not PLANNING & set(sys.argv):
            lock_folder(CONFIG.folder)
            write_resolved(CONFIG, CONFIG.folder / "config.yaml")
    elif workflow.remote_exec:  # on another machine, which may not see the file
        write_resolved(CONFIG, CONFIG.folder / "config.yaml")
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
MASKS = CONFIG.masks
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


def memory_of_pairs(n):
    """MB of n pairs of each outcome, with masks and probabilities, held twice."""
    return 2 * 3 * n * MASKS.image_size**2 * (2 * 3 + 2) // 1_000_000


def figures():
    """Every figure as PNG and PDF, and every animation."""
    drawn = [
        RESULTS / figure.file().with_suffix(suffix)
        for figure in configured(Figure, CONFIG).values()
        for suffix in (".png", ".pdf")
    ]
    for animation in configured(Animation, CONFIG).values():
        runs = animation.shards.all(CONFIG) if animation.shards else [None]
        drawn += [RESULTS / animation.file(run) for run in runs]
    return drawn


def all_outputs():
    """All shards, models, tables and arrays, so that a missing one is made again before it gets a
    checksum."""
    starts = {(run.robot, run.scene, run.start) for run in CONFIG.apartment.runs()}
    found = [DATA / "apartment_ready" / f"{'.'.join(start)}.json" for start in starts]
    for kind in (Table, Arrays, Model):
        for name, product in configured(kind, CONFIG).items():
            if product.shards is not None:
                found += shards(name)
            whole = product.shards is None or isinstance(product, Table)
            if whole and not getattr(product, "shards_only", False):
                found.append(RESULTS / product.file())
    return found


def optional_shards(name):
    """Files of all shards of a table of a study that the configuration may leave out."""
    return shards(name) if CONFIG.reset_free is not None else []


def reset_free_outputs():
    """Tables and figures of the study reset_free; none without its section."""
    if CONFIG.reset_free is None:
        return []
    found = [
        RESULTS / product.file()
        for kind in (Table, Figure)
        for name, product in configured(kind, CONFIG).items()
        if name.startswith("reset_free_")
    ]
    return found


def atlas_shards(name):
    """Files of all shards of a table of the atlas; none without a section atlas."""
    return shards(name) if CONFIG.atlas is not None else []


def gallery_shards(name):
    """Files of all shards of a table of the gallery; none without a section gallery."""
    return shards(name) if CONFIG.gallery is not None else []

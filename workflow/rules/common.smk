# What all rules share: the checked configuration, the folders, and when a rule must run again.
import hashlib
import json
import math
import sys

from sensory_commutativity import __version__
from sensory_commutativity.config import validate
from sensory_commutativity.errors import UserError
from sensory_commutativity.figures.catalogue import FIGURES
from sensory_commutativity.folders import check_writable

try:
    CONFIG = validate(config)
    check_writable(CONFIG.folder)
except UserError as error:
    print(f"error: {error}", file=sys.stderr)
    sys.exit(2)

RESULTS = CONFIG.folder
DATA = RESULTS / "data"
TABLES = RESULTS / "tables"
DRAWN = RESULTS / "figures"
LOGS = RESULTS / "logs"
BENCHMARKS = RESULTS / "benchmarks"
RESOLVED = RESULTS / "config.yaml"

FLATLAND = CONFIG.flatland
RUNS = {f"{run.world}.{run.agent}.{run.length}": run for run in FLATLAND.runs()}
DOFS = "base-longitudinal base-rotation head eyelid left-shoulder left-elbow right-shoulder right-elbow".split()


wildcard_constraints:
    world="|".join(FLATLAND.worlds),
    agent="|".join(FLATLAND.agents),
    dof="|".join(DOFS),
    length=r"\d+",
    part=r"\d+",
    parts=r"\d+",


def digest(*settings):
    """A rule's params: it runs again when these settings or the package's version change, and only then."""
    text = json.dumps(
        [__version__, CONFIG.seed, *settings],
        default=lambda section: section.model_dump(mode="json"),
    )
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def n_parts(experiments, per_job=FLATLAND.experiments_per_job):
    return math.ceil(experiments / per_job)


rule resolve:
    output:
        RESOLVED,
    log:
        LOGS / "resolve.log",
    params:
        settings=json.dumps(CONFIG.model_dump(mode="json")),
    message:
        "writing all settings to {output}"
    shell:
        "sensory-commutativity resolve --settings {params.settings:q} --out {output:q} 2> {log:q}"

"""SC-experiments to test mask predictors on, a file per job (paper, section IV-A, "Inference" and "Evaluation")."""

from __future__ import annotations

from pathlib import Path

from ....change_detection.simulated.object_experiments import ObjectExperiments, tuples_of
from ....progress import progress
from ....storage.arrays import write_arrays
from ....storage.provenance import provenance
from ...config import Config
from ..builders import TupleRun, experiments_of_job, household_of_tests
from ..tables.mask_dof import read_dof

CONTENT = "tuples"


def write_mask_tuples(config: Config, run: TupleRun, job: int, mask_dof: Path, out: Path) -> None:
    """A job's experiments of a run: arrays as :func:`.masks.experiments.tuples_of` gives them."""
    tests = config.masks.tests
    household = household_of_tests(config, run, job)
    experiments = ObjectExperiments(
        household, read_dof(mask_dof, config), tests.sequence_length, run.alternatives
    )
    played = [
        experiments.play()
        for _ in progress(range(experiments_of_job(config, job)), out.stem, "experiment")
    ]
    write_arrays(out, CONTENT, tuples_of(played, household), provenance(config))

"""Commands of seeing what moved: pairs, training, tests, the map, and a predictor for one's own pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..studies.config import Config
from ..studies.objects.config import LEARNED
from .common import Part, check_parts, table, with_config, with_out, with_parts

FILE: Any = click.Path(dir_okay=False, path_type=Path)
_part = click.option(
    "--part",
    type=Part(),
    required=True,
    help="Which of the jobs that the configuration cuts the work into.",
)
_model = click.option(
    "--model", type=click.Choice(LEARNED), required=True, help="Which of the models that learn."
)
_predictor = click.option(
    "--predictor", type=FILE, required=True, help="File of a trained predictor."
)
_unjudged = click.option(
    "--predictor",
    type=FILE,
    required=True,
    help="What mask-training wrote: a trained model without a judge.",
)
_training = click.option(
    "--training",
    type=FILE,
    multiple=True,
    required=True,
    help="File of pairs to learn from; once for each.",
)
_validation = click.option(
    "--validation",
    type=FILE,
    multiple=True,
    required=True,
    help="File of validation pairs; once for each.",
)
_tuples = click.option(
    "--tuples",
    type=FILE,
    multiple=True,
    required=True,
    help="Files of tuples RUN.I-of-N.h5, all of all runs.",
)


@click.command()
@with_config
@table("apartment-scp")
@with_out
def mask_dof(config: Config, apartment_scp: Path, out: Path) -> None:
    """Choose the degree of freedom whose SCP is nearest one half."""
    from ..studies.objects.tables.mask_dof import write_dof

    write_dof(apartment_scp, out, config)


@click.command()
@with_config
@click.option(
    "--split",
    type=click.Choice(["training", "validation"]),
    required=True,
    help="What they serve for.",
)
@_part
@with_out
def mask_pairs(config: Config, split: str, part: tuple[int, int], out: Path) -> None:
    """Make a job's pairs of pictures."""
    from ..studies.objects.data.mask_pairs import write_mask_pairs

    check_parts(part, config.masks.pair_jobs(split))  # type: ignore[arg-type]
    write_mask_pairs(config, split, part[0] - 1, out)  # type: ignore[arg-type]


@click.command()
@with_config
@_model
@_training
@_validation
@click.option("--predictor", type=FILE, required=True, help="File for the trained predictor.")
@with_out
def mask_training(
    config: Config,
    model,
    training: tuple[Path, ...],
    validation: tuple[Path, ...],
    predictor: Path,
    out: Path,
) -> None:
    """Train a model on a CPU or, if there is one, a GPU, or go on where it was killed; write its curve."""
    from ..studies.objects.models.mask_model import write_training

    write_training(config, model, training, validation, out, predictor)


@click.command()
@with_config
@_model
@_unjudged
@click.option("--pairs", type=FILE, required=True, help="File of training pairs.")
@with_out
def mask_places(config: Config, model, predictor: Path, pairs: Path, out: Path) -> None:
    """Find the places that a trained model thinks changed in a file of training pairs."""
    from ..studies.objects.data.mask_places import write_mask_places

    write_mask_places(config, model, predictor, pairs, out)


@click.command()
@with_config
@_model
@_unjudged
@click.option(
    "--places",
    type=FILE,
    multiple=True,
    required=True,
    help="File of places to learn from; once for each.",
)
@_validation
@with_out
def mask_judging(
    config: Config,
    model,
    predictor: Path,
    places: tuple[Path, ...],
    validation: tuple[Path, ...],
    out: Path,
) -> None:
    """Train a judge of places, or go on where it was killed, and write the predictor with it, its decision rule tuned."""
    from ..studies.objects.models.view_classifier import write_judged

    write_judged(config, model, predictor, places, validation, out)


@click.command()
@with_config
@_validation
@with_out
def mask_difference(config: Config, validation: tuple[Path, ...], out: Path) -> None:
    """Tune the decision rule of the image difference, which learns nothing else, and write it as a predictor."""
    from ..studies.objects.models.view_classifier import write_difference

    write_difference(config, validation, out)


@click.command()
@with_config
@with_parts
@with_out
def mask_curves(config: Config, parts: tuple[Path, ...], out: Path) -> None:
    """Gather the training curves in PARTS."""
    from ..studies.objects.models.mask_model import gather_curves

    gather_curves(parts, out, config)


@click.command()
@with_config
@click.option(
    "--run", required=True, help="as-trained, other-objects, other-apartments or all-other."
)
@_part
@table("mask-dof")
@with_out
def mask_tuples(config: Config, run: str, part: tuple[int, int], mask_dof: Path, out: Path) -> None:
    """Play a job's SC-experiments on objects."""
    from ..studies.objects.builders import tuple_jobs, tuple_runs
    from ..studies.objects.data.mask_tuples import write_mask_tuples

    runs = tuple_runs(config)
    if run not in runs:
        raise click.BadParameter(
            f"there is no run {run!r}; choose one of {', '.join(runs)}", param_hint="--run"
        )
    check_parts(part, tuple_jobs(config))
    write_mask_tuples(config, runs[run], part[0] - 1, mask_dof, out)


def _by_run(tuples: tuple[Path, ...], config: Config) -> dict[str, list[Path]]:
    """Run -> its files, in the order of their numbers. Every file's name begins with that of its run."""
    from ..studies.objects.builders import tuple_jobs, tuple_runs

    n = tuple_jobs(config)
    named = {path.name: path for path in tuples}
    wanted = {run: [f"{run}.{i + 1}-of-{n}.h5" for i in range(n)] for run in tuple_runs(config)}
    missing = [name for names in wanted.values() for name in names if name not in named]
    if missing:
        raise click.BadParameter(
            f"{missing[0]} is missing (and {len(missing) - 1} more); give all files of tuples",
            param_hint="--tuples",
        )
    return {run: [named[name] for name in names] for run, names in wanted.items()}


@click.command()
@with_config
@click.option("--model", required=True, help="raft, flownet or difference.")
@_predictor
@_tuples
@with_out
def mask_model_scores(
    config: Config, model: str, predictor: Path, tuples: tuple[Path, ...], out: Path
) -> None:
    """Score one model on all test sets."""
    from ..studies.objects.tables.mask_scores import write_model_scores

    write_model_scores(config, predictor, model, _by_run(tuples, config), out)


@click.command()
@with_config
@with_parts
@with_out
def mask_scores(config: Config, parts: tuple[Path, ...], out: Path) -> None:
    """Gather the scores of all models in PARTS."""
    from ..studies.objects.tables.mask_scores import gather_scores

    gather_scores(parts, out, config)


@click.command()
@with_config
@table("mask-scores")
@with_out
def mask_summary(config: Config, mask_scores: Path, out: Path) -> None:
    """Accuracy and overlap of every model on every test set."""
    from ..studies.objects.tables.mask_summary import write_summary

    write_summary(mask_scores, out, config)


@click.command()
@with_config
@table("mask-scores")
@with_out
def mask_comparisons(config: Config, mask_scores: Path, out: Path) -> None:
    """Compare RAFT with the other models on the same tuples."""
    from ..studies.objects.tables.mask_comparisons import write_comparisons

    write_comparisons(mask_scores, out, config)


@click.command()
@with_config
@_predictor
@with_parts
@with_out
def mask_alternatives(config: Config, predictor: Path, parts: tuple[Path, ...], out: Path) -> None:
    """What the RAFT says of SC-experiments and their alternatives, from all tuples of the run as-trained in PARTS."""
    from ..studies.objects.tables.mask_alternatives import write_alternatives

    write_alternatives(config, predictor, parts, out)


@click.command()
@with_config
@table("mask-alternatives")
@with_out
def mask_discoveries(config: Config, mask_alternatives: Path, out: Path) -> None:
    """What SC-experiments and their alternatives find on the same starts."""
    from ..studies.objects.tables.mask_discoveries import write_discoveries

    write_discoveries(mask_alternatives, out, config)


@click.command()
@with_config
@_training
@_tuples
@_predictor
@table("mask-scores")
@with_out
def mask_examples(
    config: Config, training: tuple[Path, ...], tuples: tuple[Path, ...], predictor: Path, mask_scores: Path, out: Path
) -> None:  # fmt: skip
    """Put pictures aside for the figures."""
    from ..studies.objects.data.mask_examples import write_examples

    write_examples(config, training, _by_run(tuples, config), predictor, mask_scores, out)


@click.command()
@with_config
@_part
@with_out
def local_scp_experiments(config: Config, part: tuple[int, int], out: Path) -> None:
    """Play the SC-experiments at a job's places of the map."""
    from ..studies.objects.builders import map_jobs
    from ..studies.objects.tables.local_scp import write_local_scp_experiments

    check_parts(part, map_jobs(config))
    write_local_scp_experiments(config, part[0] - 1, out)


@click.command()
@with_config
@_predictor
@with_parts
@with_out
def local_scp(config: Config, predictor: Path, parts: tuple[Path, ...], out: Path) -> None:
    """Measure the local SCP at all places, from the experiments in PARTS."""
    from ..studies.objects.tables.local_scp import write_local_scp

    write_local_scp(config, parts, predictor, out)


@click.command()
@with_config
@table("local-scp")
@with_out
def local_scp_summary(config: Config, local_scp: Path, out: Path) -> None:
    """Does the local SCP show where immovable things are?"""
    from ..studies.objects.tables.local_scp_summary import write_summary

    write_summary(local_scp, out, config)


@click.group()
def masks() -> None:
    """Find what moved between two pictures of your own."""


@masks.command()
@click.argument("first", type=FILE)
@click.argument("second", type=FILE)
@click.option(
    "--predictor",
    type=FILE,
    help="A trained predictor; without it the RAFT that comes with this project.",
)
@click.option(
    "--out",
    type=FILE,
    help="Picture to write: both pictures with what moved outlined; without it SECOND-moved.png.",
)
def predict(first: Path, second: Path, predictor: Path | None, out: Path | None) -> None:
    """Is SECOND the same view as FIRST, another, or the same but for what moved? And where?

    Both are PNG or JPEG files of one camera, of any size from 64 pixels on.
    """
    from ..change_detection.predict import predict_files

    click.echo(
        predict_files(first, second, predictor, out or second.with_name(f"{second.stem}-moved.png"))
    )


COMMANDS = (
    mask_dof, mask_pairs, mask_training, mask_places, mask_judging, mask_difference, mask_curves, mask_tuples, mask_model_scores, mask_scores,
    mask_summary, mask_comparisons, mask_alternatives, mask_discoveries, mask_examples, local_scp_experiments, local_scp, local_scp_summary, masks,
)  # fmt: skip
